"""Numbers with their derivatives by the variables of a design."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..ground.arrays import Array


class Quantity:
    """An array and its slope, with the arithmetic of both.

    Attributes:
        value: the array, of any shape.
        slope: derivatives by the k variables (..., k).
    """

    __array_ufunc__ = None  # lets arrays on the left defer to these methods

    def __init__(self, value: Any, slope: Any) -> None:
        self.value: Array = np.asarray(value, dtype=np.float64)
        self.slope: Array = np.asarray(slope, dtype=np.float64)

    def __repr__(self) -> str:
        return f"Quantity({self.value})"

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, key: Any) -> Quantity:
        """Some entries."""
        return Quantity(self.value[key], self.slope[key])

    def __add__(self, other: Any) -> Quantity:
        added = _quantity(other, self)
        total = self.value + added.value
        slope = _widened(self.slope, total)
        return Quantity(total, slope + _widened(added.slope, total))

    __radd__ = __add__

    def __neg__(self) -> Quantity:
        return Quantity(-self.value, -self.slope)

    def __sub__(self, other: Any) -> Quantity:
        return self + (-_quantity(other, self))

    def __rsub__(self, other: Any) -> Quantity:
        return _quantity(other, self) - self

    def __mul__(self, other: Any) -> Quantity:
        factor = _quantity(other, self)
        product = self.value * factor.value
        first = _scaled(self.slope, factor.value, product)
        second = _scaled(factor.slope, self.value, product)
        return Quantity(product, first + second)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Quantity:
        return self * _quantity(other, self) ** -1

    def __rtruediv__(self, other: Any) -> Quantity:
        return _quantity(other, self) / self

    def __pow__(self, power: float) -> Quantity:
        value = self.value**power
        factor = power * self.value ** (power - 1)
        return Quantity(value, _scaled(self.slope, factor, value))

    def __abs__(self) -> Quantity:
        value = np.abs(self.value)
        sign = np.sign(self.value)
        return Quantity(value, _scaled(self.slope, sign, value))

    def sqrt(self) -> Quantity:
        """Square root."""
        return self**0.5

    def sum(self) -> Quantity:
        """Sum of all entries."""
        slope = self._flat().sum(axis=0)
        return Quantity(self.value.sum(), slope)

    def over(self, axis: int) -> Quantity:
        """Sums along an axis of the entries."""
        return Quantity(self.value.sum(axis=axis), self.slope.sum(axis=axis))

    def mean(self) -> Quantity:
        """Mean of all entries."""
        return self.sum() * (1.0 / self.value.size)

    def max(self) -> Quantity:
        """The largest entry; where several are, the slope is that of the first."""
        return self._chosen(np.argmax)

    def min(self) -> Quantity:
        """The least entry; where several are, the slope is that of the first."""
        return self._chosen(np.argmin)

    def _chosen(self, choose: Callable[[Array], Any]) -> Quantity:
        place = int(choose(self.value))
        value = self.value.ravel()[place]
        return Quantity(value, self._flat()[place])

    def _flat(self) -> Array:
        """The slope (entries, k)."""
        count = self.slope.shape[-1]
        return self.slope.reshape(-1, count)


def joined(*parts: Quantity) -> Quantity:
    """The entries of quantities of one unit, one after the other (entries,)."""
    values = [part.value.reshape(-1) for part in parts]
    count = parts[0].slope.shape[-1]
    slopes = [part.slope.reshape(-1, count) for part in parts]
    return Quantity(np.concatenate(values), np.concatenate(slopes))


def solved(matrix: Quantity, rhs: Quantity) -> Quantity:
    """The solutions x (N, n) of A x = b for matrices (N, n, n) and right sides (N, n)."""
    columns = rhs.value[..., None]
    x = np.linalg.solve(matrix.value, columns)[..., 0]
    moved = np.einsum("nijk,nj->nik", matrix.slope, x)
    slope = np.linalg.solve(matrix.value, rhs.slope - moved)
    return Quantity(x, slope)


def determinant(matrix: Quantity) -> Quantity:
    """Determinants (N,) of matrices (N, n, n)."""
    value = np.linalg.det(matrix.value)
    cofactors = np.empty_like(matrix.value)
    size = matrix.value.shape[-1]
    for i in range(size):
        for j in range(size):
            minor = np.delete(np.delete(matrix.value, i, axis=1), j, axis=2)
            cofactors[:, i, j] = (-1.0) ** (i + j) * np.linalg.det(minor)
    return Quantity(value, np.einsum("nij,nijk->nk", cofactors, matrix.slope))


def _quantity(other: Any, like: Quantity) -> Quantity:
    if isinstance(other, Quantity):
        return other
    value = np.asarray(other, dtype=np.float64)
    count = like.slope.shape[-1]
    return Quantity(value, np.zeros((*value.shape, count)))


def _widened(slope: Array, value: Array) -> Array:
    """The slope of a value that was broadcast."""
    count = slope.shape[-1]
    return np.broadcast_to(slope, (*value.shape, count))


def _scaled(slope: Array, factor: Array, value: Array) -> Array:
    """A slope times a factor, both in the shape of a value."""
    wide = np.broadcast_to(factor, value.shape)
    return np.asarray(_widened(slope, value) * wide[..., None])
