"""Small linear systems over any scalar type, as the blocks of the closure plan have them.

Up to 3 x 3 the inverse is written out.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from ..ground.arrays import Array
from .numerics import invert
from .scalar import Scalar, Scalars, absolute, sqrt
from .vector import cross, dot

Matrix = Sequence[Scalars]
Rows = list[list[Scalar]]


def mirrored(matrix: Rows) -> Rows:
    """A symmetric matrix, its lower triangle from the upper one."""
    rows = [list(row) for row in matrix]
    for i in range(len(rows)):
        for j in range(i):
            rows[i][j] = matrix[j][i]
    return rows


def transposed(rows: Matrix) -> Rows:
    """The columns of a matrix, as rows."""
    return [list(column) for column in zip(*rows, strict=True)]


def transposed_product(a: Matrix, b: Matrix) -> Rows:
    """a^T b of two matrices with equally many rows; zeros are left out."""
    result: Rows = []
    for column in transposed(a):
        totals = [_dot_of_some(column, other) for other in transposed(b)]
        result.append(totals)
    return result


def unit_vectors(size: int) -> list[list[float]]:
    """The columns of the identity."""
    return np.eye(size).tolist()


class Inverse:
    """A square matrix, ready to solve with.

    Attributes:
        size: number of rows.
        adjugate: `divisor` times the inverse, rows (size, size); by Cramer's rule up to 3 x 3.
        divisor: the adjugate over this number is the inverse.
    """

    def __init__(self, matrix: Matrix, order: Sequence[int] = ()) -> None:
        """Invert a matrix.

        Args:
            matrix: rows (size, size).
            order: the rows in an order that elimination needs not change much, for speed.
        """
        self.size = size = len(matrix)
        self.adjugate: Rows
        self.divisor: Scalar
        if size in _ADJUGATE:
            self.adjugate, self.divisor = _ADJUGATE[size](matrix)
            return
        order = order or range(size)
        inverse = invert(list(chain.from_iterable(matrix[k] for k in order)), size)
        self.adjugate = []
        for k in range(size):
            row = dict(zip(order, inverse[k * size : (k + 1) * size], strict=True))
            self.adjugate.append([row[c] for c in range(size)])
        self.divisor = 1.0

    def conditioning(self, matrix: Matrix, units: Sequence[float]) -> Scalar:
        """size / (||A|| ||A^-1||) in Frobenius norms: 1 at best, 0 where A is singular.

        Args:
            matrix: the matrix that was inverted, rows (size, size).
            units: unit of the unknown of each column. A is the matrix with its columns multiplied
                by these units.
        """
        total = _sum_of_squares(matrix, units)
        if self.size == 2:  # the adjugate has the norm of the matrix
            return 2.0 * units[0] * units[1] * absolute(self.divisor) / total
        inverse_squares: list[Scalar] = []
        for row, unit in zip(self.adjugate, units, strict=True):
            inverse_squares += [a * a / (unit * unit) for a in row]
        return self.size * absolute(self.divisor) / sqrt(total * _sum(inverse_squares))

    def excess(self, matrix: Matrix, units: Sequence[float], limit: float) -> Scalar:
        """A scalar that is positive if the conditioning is above a limit.

        Args:
            matrix: as for `conditioning`.
            units: as for `conditioning`.
            limit: the limit.
        """
        if self.size == 2:
            ratio = limit / (2.0 * units[0] * units[1])
            return absolute(self.divisor) - ratio * _sum_of_squares(matrix, units)
        return self.conditioning(matrix, units) - limit

    def solve(self, rhs: Scalars) -> list[Scalar]:
        """x with matrix x = rhs."""
        return [_product(row, rhs) / self.divisor for row in self.adjugate]

    def solve_transposed(self, rhs: Scalars) -> list[Scalar]:
        """x with matrix^T x = rhs."""
        columns = zip(*self.adjugate, strict=True)
        return [_product(column, rhs) / self.divisor for column in columns]


def pivot_order(matrix: Array) -> tuple[int, ...]:
    """The order in which Gauss' elimination with pivoting takes the rows of a square matrix."""
    remaining = matrix.copy()
    rows = list(range(len(matrix)))
    order: list[int] = []
    for column in range(len(matrix)):
        pivot = max(rows, key=lambda k: abs(remaining[k, column]))
        rows.remove(pivot)
        order.append(pivot)
        if remaining[pivot, column]:
            factors = remaining[rows, column] / remaining[pivot, column]
            remaining[rows] -= np.outer(factors, remaining[pivot])
    return tuple(order)


def _sum_of_squares(matrix: Matrix, units: Sequence[float]) -> Scalar:
    """The squared Frobenius norm of a matrix with its columns multiplied by units."""
    squares: list[Scalar] = []
    for row in matrix:
        squares += [a * a * (unit * unit) for a, unit in zip(row, units, strict=True)]
    return _sum(squares)


def _product(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    return _sum(x * y for x, y in zip(a, b, strict=True))


def _sum(terms: Iterable[Scalar]) -> Scalar:
    remaining = iter(terms)
    total = next(remaining)
    for term in remaining:
        total = total + term
    return total


def _dot_of_some(a: Scalars, b: Scalars) -> Scalar:
    """The dot product of two vectors; numbers that are zero are left out."""
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        if not _is_zero(x) and not _is_zero(y):
            total = total + x * y
    return total


def _is_zero(x: Scalar) -> bool:
    return isinstance(x, float) and x == 0.0


def _adjugate1(m: Matrix) -> tuple[Rows, Scalar]:
    return [[1.0]], m[0][0]


def _adjugate2(m: Matrix) -> tuple[Rows, Scalar]:
    (a, b), (c, d) = m
    return [[d, -b], [-c, a]], a * d - b * c


def _adjugate3(m: Matrix) -> tuple[Rows, Scalar]:
    x, y, z = (tuple(row) for row in m)
    columns = (cross(y, z), cross(z, x), cross(x, y))
    return transposed(columns), dot(x, columns[0])


_ADJUGATE = {1: _adjugate1, 2: _adjugate2, 3: _adjugate3}
