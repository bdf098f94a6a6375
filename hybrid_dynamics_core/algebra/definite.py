"""Symmetric positive definite systems over any scalar: L D L^T, written out, without square roots."""

from __future__ import annotations

from collections.abc import Sequence

from .scalar import Scalar


class Definite:
    """A symmetric positive definite matrix, ready to solve with; only its lower triangle is read.

    `pivots` are D: what is left of each diagonal entry after the rows before it. All are positive
    where the matrix is positive definite; one that is next to nothing says that the matrix is
    singular. `floor`: added where one divides by a pivot, so small that it counts only where
    nothing is left; it keeps results of no meaning finite.
    """

    def __init__(self, matrix: Sequence[Sequence[Scalar]], floor: Scalar = 0.0) -> None:
        self.size = len(matrix)
        self._floor = floor
        self.pivots: list[Scalar] = []
        self._lower: list[list[Scalar]] = []
        for i in range(self.size):
            scaled: list[Scalar] = []  # row i of L D
            for j in range(i):
                value = matrix[i][j]
                for k in range(j):
                    value = value - scaled[k] * self._lower[j][k]
                scaled.append(value)
            row = [
                value / self._divisor(pivot)
                for value, pivot in zip(scaled, self.pivots, strict=True)
            ]
            pivot = matrix[i][i]
            for a, b in zip(scaled, row, strict=True):
                pivot = pivot - a * b
            self.pivots.append(pivot)
            self._lower.append(row)

    def solve(self, rhs: Sequence[Scalar]) -> list[Scalar]:
        """x with matrix x = rhs."""
        x: list[Scalar] = []
        for i, row in enumerate(self._lower):
            value = rhs[i]
            for a, b in zip(row, x, strict=True):
                value = value - a * b
            x.append(value)
        x = [value / self._divisor(pivot) for value, pivot in zip(x, self.pivots, strict=True)]
        for i in range(self.size - 1, -1, -1):
            for j in range(i + 1, self.size):
                x[i] = x[i] - self._lower[j][i] * x[j]
        return x

    def _divisor(self, pivot: Scalar) -> Scalar:
        """A pivot that is the constant zero (its matrix is refused by its pivots) must not stop a trace."""
        raised = pivot + self._floor
        return 1.0 if isinstance(raised, float) and raised == 0.0 else raised
