"""Linear systems with at least as many equations as unknowns, over any scalar type.

A system with more equations is solved by its normal equations, and refined once: that gives back
the digits that they lose, where the equations agree.
"""

from __future__ import annotations

from collections.abc import Sequence

from .linear import Inverse, Matrix, Rows, transposed, transposed_product
from .scalar import Scalar, Scalars, sqrt
from .vector import add, sub


class LeastSquares:
    """A matrix A (m, n) of full rank with m >= n, ready to solve with.

    Attributes:
        matrix: A, rows (m, n).
    """

    def __init__(self, matrix: Matrix, order: Sequence[int] = ()) -> None:
        """Make it ready to solve with.

        Args:
            matrix: A, rows (m, n).
            order: of a square matrix, an order of its rows as `Inverse` takes it.
        """
        self.matrix = matrix
        self._columns = transposed(matrix)
        self._is_square = len(matrix) == len(self._columns)
        self._normal: Rows = []
        if self._is_square:
            self._inverse = Inverse(matrix, order)
        else:
            self._normal = transposed_product(matrix, matrix)
            self._inverse = Inverse(self._normal)

    def solve(self, rhs: Scalars) -> list[Scalar]:
        """The x (n,) that makes A x - rhs least."""
        if self._is_square:
            return self._inverse.solve(rhs)
        x = self._inverse.solve(_times(self._columns, rhs))
        rest = sub(rhs, _times(self.matrix, x))
        return list(add(x, self._inverse.solve(_times(self._columns, rest))))

    def solve_transposed(self, rhs: Scalars) -> list[Scalar]:
        """The least x (m,) with A^T x = rhs."""
        if self._is_square:
            return self._inverse.solve_transposed(rhs)
        x = _times(self.matrix, self._inverse.solve(rhs))
        rest = sub(rhs, _times(self._columns, x))
        return list(add(x, _times(self.matrix, self._inverse.solve(rest))))

    def conditioning(self, units: Sequence[float]) -> Scalar:
        """n / (||A|| ||A^+||) in Frobenius norms: 1 at best, 0 where A has less than full rank.

        Args:
            units: unit of the unknown of each column. A is the matrix with its columns multiplied
                by these units.
        """
        if self._is_square:
            return self._inverse.conditioning(self.matrix, units)
        total: Scalar = 0.0
        inverse: Scalar = 0.0
        for k, unit in enumerate(units):
            square = unit * unit
            total = total + self._normal[k][k] * square
            inverse = inverse + self._inverse.adjugate[k][k] / square
        return len(units) * sqrt(self._inverse.divisor / (total * inverse))

    def excess(self, units: Sequence[float], limit: float) -> Scalar:
        """A scalar that is positive if the conditioning is above a limit.

        Args:
            units: as for `conditioning`.
            limit: the limit.
        """
        if self._is_square:
            return self._inverse.excess(self.matrix, units, limit)
        return self.conditioning(units) - limit


def _times(rows: Matrix, x: Scalars) -> list[Scalar]:
    (products,) = transposed_product(transposed([x]), transposed(rows))
    return products
