"""Small linear systems over any scalar type, written out (Cramer's rule): the blocks of the closure plan."""

from __future__ import annotations

from collections.abc import Sequence

from .scalar import Scalar
from .vector import cross, dot

Matrix = Sequence[Sequence[Scalar]]


class Inverse:
    """Adjugate and determinant of a 1 x 1 to 3 x 3 matrix."""

    def __init__(self, matrix: Matrix) -> None:
        self.size = len(matrix)
        self.adjugate, self.determinant = _ADJUGATE[self.size](matrix)

    def solve(self, rhs: Sequence[Scalar]) -> list[Scalar]:
        """x with matrix x = rhs."""
        return [_sum(a * b for a, b in zip(row, rhs, strict=True)) / self.determinant for row in self.adjugate]

    def solve_transposed(self, rhs: Sequence[Scalar]) -> list[Scalar]:
        """x with matrix^T x = rhs."""
        columns = zip(*self.adjugate, strict=True)
        return [_sum(a * b for a, b in zip(column, rhs, strict=True)) / self.determinant for column in columns]


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
