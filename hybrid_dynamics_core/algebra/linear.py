"""Small linear systems over any scalar type: the blocks of the closure plan.

Up to 3 x 3 they are written out.
"""

from __future__ import annotations

from collections.abc import Sequence

from .numerics import invert
from .scalar import Scalar, absolute, sqrt
from .vector import cross, dot

Matrix = Sequence[Sequence[Scalar]]


class Inverse:
    """A square matrix, ready to solve with; `divisor` times the inverse is `adjugate` (Cramer's rule up to 3 x 3)."""

    def __init__(self, matrix: Matrix) -> None:
        self.size = size = len(matrix)
        self.divisor: Scalar
        if size in _ADJUGATE:
            self.adjugate, self.divisor = _ADJUGATE[size](matrix)
            self.determinant = self.divisor
        else:
            *entries, self.determinant = invert([entry for row in matrix for entry in row], size)
            self.adjugate, self.divisor = (
                [entries[k * size : (k + 1) * size] for k in range(size)],
                1.0,
            )

    def conditioning(self, matrix: Matrix, units: Sequence[float]) -> Scalar:
        """size / (||A|| ||A^-1||) in Frobenius norms: 1 at best, 0 where A is singular.

        A is the matrix with each column multiplied by its unit: what the unknown of the column is
        counted in.
        """
        total = _sum(
            a * a * (unit * unit) for row in matrix for a, unit in zip(row, units, strict=True)
        )
        if self.size == 2:  # the adjugate has the norm of the matrix
            return 2.0 * units[0] * units[1] * absolute(self.divisor) / total
        rows = zip(self.adjugate, units, strict=True)
        return (
            self.size
            * absolute(self.divisor)
            / sqrt(total * _sum(a * a / (unit * unit) for row, unit in rows for a in row))
        )

    def solve(self, rhs: Sequence[Scalar]) -> list[Scalar]:
        """x with matrix x = rhs."""
        return [
            _sum(a * b for a, b in zip(row, rhs, strict=True)) / self.divisor
            for row in self.adjugate
        ]

    def solve_transposed(self, rhs: Sequence[Scalar]) -> list[Scalar]:
        """x with matrix^T x = rhs."""
        columns = zip(*self.adjugate, strict=True)
        return [
            _sum(a * b for a, b in zip(column, rhs, strict=True)) / self.divisor
            for column in columns
        ]


def _sum(terms: object) -> Scalar:
    total: Scalar = None
    for term in terms:  # type: ignore[attr-defined]
        total = term if total is None else total + term
    return total


def _adjugate1(m: Matrix) -> tuple[list[list[Scalar]], Scalar]:
    return [[1.0]], m[0][0]


def _adjugate2(m: Matrix) -> tuple[list[list[Scalar]], Scalar]:
    (a, b), (c, d) = m
    return [[d, -b], [-c, a]], a * d - b * c


def _adjugate3(m: Matrix) -> tuple[list[list[Scalar]], Scalar]:
    rows = [tuple(row) for row in m]
    columns = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])]
    return [list(row) for row in zip(*columns, strict=True)], dot(rows[0], columns[0])


_ADJUGATE = {1: _adjugate1, 2: _adjugate2, 3: _adjugate3}
