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
        value, slope = _parts(other, self)
        total = self.value + value
        return Quantity(total, _widened(self.slope, total) + _widened(slope, total))

    __radd__ = __add__

    def __neg__(self) -> Quantity:
        return Quantity(-self.value, -self.slope)

    def __sub__(self, other: Any) -> Quantity:
        return self + (-_quantity(other, self))

    def __rsub__(self, other: Any) -> Quantity:
        return _quantity(other, self) - self

    def __mul__(self, other: Any) -> Quantity:
        value, slope = _parts(other, self)
        product = self.value * value
        first = _widened(self.slope, product) * np.broadcast_to(value, product.shape)[..., None]
        second = _widened(slope, product) * np.broadcast_to(self.value, product.shape)[..., None]
        return Quantity(product, first + second)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Quantity:
        return self * _quantity(other, self) ** -1

    def __rtruediv__(self, other: Any) -> Quantity:
        return _quantity(other, self) / self

    def __pow__(self, power: float) -> Quantity:
        factor = power * self.value ** (power - 1)
        return Quantity(self.value**power, factor[..., None] * self.slope)

    def __abs__(self) -> Quantity:
        return Quantity(np.abs(self.value), np.sign(self.value)[..., None] * self.slope)

    def sqrt(self) -> Quantity:
        """Square root."""
        return self**0.5

    def sum(self) -> Quantity:
        """Sum of all entries."""
        return Quantity(self.value.sum(), self._flat().sum(axis=0))

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
        return Quantity(self.value.ravel()[place], self._flat()[place])

    def _flat(self) -> Array:
        return self.slope.reshape(-1, self.slope.shape[-1])


def solved(matrix: Quantity, rhs: Quantity) -> Quantity:
    """The solutions x (N, n) of A x = b for matrices (N, n, n) and right sides (N, n)."""
    x = np.linalg.solve(matrix.value, rhs.value[..., None])[..., 0]
    moved = np.einsum("nijk,nj->nik", matrix.slope, x)
    return Quantity(x, np.linalg.solve(matrix.value, rhs.slope - moved))


def _quantity(other: Any, like: Quantity) -> Quantity:
    if isinstance(other, Quantity):
        return other
    value = np.asarray(other, dtype=np.float64)
    return Quantity(value, np.zeros((*value.shape, like.slope.shape[-1])))


def _parts(other: Any, like: Quantity) -> tuple[Array, Array]:
    quantity = _quantity(other, like)
    return quantity.value, quantity.slope


def _widened(slope: Array, value: Array) -> Array:
    """The slope of a value that was broadcast."""
    return np.broadcast_to(slope, (*value.shape, slope.shape[-1]))
