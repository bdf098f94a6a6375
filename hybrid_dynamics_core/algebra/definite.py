"""Symmetric positive definite systems over any scalar: L D L^T, written out, without roots."""

from __future__ import annotations

from collections.abc import Sequence

from .scalar import Scalar, Scalars


class Definite:
    """A symmetric positive definite matrix, ready to solve with.

    Only its lower triangle is read.

    Attributes:
        size: number of rows.
        pivots: D, what remains of each diagonal entry after the rows before it. All are positive
            where the matrix is positive definite. One next to zero says that it is singular.
    """

    def __init__(self, matrix: Sequence[Scalars], floor: Scalar = 0.0) -> None:
        """Factorise the matrix.

        Args:
            matrix: rows (size, size).
            floor: added where one divides by a pivot. It is so small that it counts only where
                nothing remains, and keeps results without meaning finite.
        """
        self.size = len(matrix)
        self._floor = floor
        self.pivots: list[Scalar] = []
        self._lower: list[list[Scalar]] = []
        for i in range(self.size):
            scaled = self._scaled_row(matrix[i], i)
            row = self._divided_by_pivots(scaled)
            pivot = matrix[i][i]
            for a, b in zip(scaled, row, strict=True):
                pivot = pivot - a * b
            self.pivots.append(pivot)
            self._lower.append(row)

    def solve(self, rhs: Scalars) -> list[Scalar]:
        """x with matrix x = rhs."""
        x: list[Scalar] = []
        for i, row in enumerate(self._lower):
            value = rhs[i]
            for a, b in zip(row, x, strict=True):
                value = value - a * b
            x.append(value)
        x = self._divided_by_pivots(x)
        for i in range(self.size - 1, -1, -1):
            for j in range(i + 1, self.size):
                x[i] = x[i] - self._lower[j][i] * x[j]
        return x

    def _scaled_row(self, entries: Scalars, i: int) -> list[Scalar]:
        """Row i of L D, without its diagonal."""
        scaled: list[Scalar] = []
        for j in range(i):
            value = entries[j]
            for k in range(j):
                value = value - scaled[k] * self._lower[j][k]
            scaled.append(value)
        return scaled

    def _divided_by_pivots(self, values: Scalars) -> list[Scalar]:
        return [value / self._divisor(d) for value, d in zip(values, self.pivots, strict=True)]

    def _divisor(self, pivot: Scalar) -> Scalar:
        """The pivot, or 1 where it is the constant zero: that must not stop a trace."""
        raised = pivot + self._floor
        if isinstance(raised, float) and raised == 0.0:
            return 1.0
        return raised
