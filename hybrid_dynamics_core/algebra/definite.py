"""Symmetric positive definite systems over any scalar: L D L^T, written out, without roots."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .scalar import Scalar, Scalars


class Definite:
    """A symmetric positive definite matrix, ready to solve with.

    Only its lower triangle is read.

    Attributes:
        size: number of rows.
        pivots: the entries of D. All are positive if the matrix is positive definite. A pivot next
            to zero means that it is singular.
        mask: 1 for each row that is kept, 0 for each that is dropped.
    """

    def __init__(
        self,
        matrix: Sequence[Scalars],
        floor: Scalar = 0.0,
        keep: Callable[[int, Scalar], Scalar] | None = None,
    ) -> None:
        """Factorise the matrix.

        Args:
            matrix: rows (size, size).
            floor: a tiny number that is added to each pivot before dividing by it. Where a pivot is
                zero, results stay finite, but have no meaning.
            keep: called with a row and its pivot; returns 1 to keep the row, or 0 to drop its
                equation and set its unknown to zero. If None, all rows are kept.
        """
        self.size = len(matrix)
        self._floor = floor
        self.pivots: list[Scalar] = []
        self.mask: list[Scalar] = []
        self._lower: list[list[Scalar]] = []
        for i in range(self.size):
            scaled = self._scaled_row(matrix[i], i)
            row = self._divided_by_pivots(scaled)
            pivot = matrix[i][i]
            for a, b in zip(scaled, row, strict=True):
                pivot = pivot - a * b
            self.pivots.append(pivot)
            self.mask.append(keep(i, pivot) if keep else 1.0)
            self._lower.append(row)

    def solve(self, rhs: Scalars) -> list[Scalar]:
        """x with matrix x = rhs."""
        x = self._divided_by_pivots(self.remainders(rhs))
        for i in range(self.size - 1, -1, -1):
            for j in range(i + 1, self.size):
                x[i] = x[i] - self._lower[j][i] * x[j]
        return x

    def remainders(self, rhs: Scalars) -> list[Scalar]:
        """y with L y = rhs (forward substitution)."""
        remainders: list[Scalar] = []
        for i, row in enumerate(self._lower):
            value = rhs[i]
            for a, b in zip(row, remainders, strict=True):
                value = value - a * b
            remainders.append(value)
        return remainders

    def dependence(self, i: int) -> list[Scalar]:
        """Coefficients (i,) of the combination of rows 0 to i - 1 that is nearest to row i."""
        x = list(self._lower[i])
        for k in range(i - 1, -1, -1):
            for j in range(k + 1, i):
                x[k] = x[k] - self._lower[j][k] * x[j]
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
        """Each value over the pivot of its row; zero in rows that are left out."""
        quotients: list[Scalar] = []
        for value, pivot, mask in zip(values, self.pivots, self.mask, strict=True):
            quotients.append(mask * value / self._divisor(pivot, mask))
        return quotients

    def _divisor(self, pivot: Scalar, mask: Scalar) -> Scalar:
        """The pivot, or 1 for a row that is left out."""
        raised = mask * pivot + self._floor + (1.0 - mask)
        # a constant zero must not stop a trace
        if isinstance(raised, float) and raised == 0.0:
            return 1.0
        return raised
