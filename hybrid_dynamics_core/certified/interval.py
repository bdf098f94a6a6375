"""Intervals in outward rounding, as scalars of the programs and equations of the library.

Sums, products, quotients and roots are rounded to the next double outward. Sines and cosines of
the platform's library are taken as correct to four units in the last place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..ground.arrays import Array
from .rounding import down, up

_LIBRARY = 2.0**-50  # [1] largest error of a sine or cosine: four units in the last place
_NEAR = 1e-9  # [turns] this near to an extreme value, an interval of angles counts as holding it
_HALF_TURN = float(up(np.asarray(np.pi)))  # [rad]
_UNBOUNDED = 1e15  # [rad] angles whose sines have no digits


class Interval:
    """All numbers from `lower` to `upper`, elementwise for arrays.

    Attributes:
        lower: lower bounds.
        upper: upper bounds, of the same shape.
    """

    __slots__ = ("lower", "upper")
    __array_ufunc__ = None  # lets NumPy scalars on the left defer to these methods

    def __init__(
        self,
        lower: ArrayLike,
        upper: ArrayLike | None = None,
    ) -> None:
        self.lower: Array = np.asarray(lower, dtype=float)
        self.upper: Array = self.lower
        if upper is not None:
            self.upper = np.asarray(upper, dtype=float)

    @classmethod
    def around(cls, middle: ArrayLike, radius: ArrayLike) -> Interval:
        """All numbers within a radius of a middle."""
        centre: Array = np.asarray(middle, dtype=float)
        distance: Array = np.asarray(radius, dtype=float)
        return cls(down(centre - distance), up(centre + distance))

    @property
    def middle(self) -> Array:
        """A double near the middle; NaN of all numbers."""
        with np.errstate(invalid="ignore"):
            centre: Array = 0.5 * self.lower + 0.5 * self.upper
        return centre

    @property
    def radius(self) -> Array:
        """A distance from `middle` within which the interval lies."""
        centre = self.middle
        return np.maximum(
            up(self.upper - centre),
            up(centre - self.lower),
        )

    @property
    def magnitude(self) -> Array:
        """The largest absolute value."""
        return np.maximum(
            np.abs(self.lower),
            np.abs(self.upper),
        )

    def holds_zero(self) -> Array:
        """Whether zero is in it, elementwise (booleans)."""
        return np.asarray((self.lower <= 0.0) & (self.upper >= 0.0))

    def inside(self, other: Interval) -> Array:
        """Whether it lies in the interior of another one, elementwise (booleans)."""
        return np.asarray((self.lower > other.lower) & (self.upper < other.upper))

    def __add__(self, other: Interval | float) -> Interval:
        b = _interval(other)
        return Interval(
            down(self.lower + b.lower),
            up(self.upper + b.upper),
        )

    __radd__ = __add__

    def __neg__(self) -> Interval:
        return Interval(-self.upper, -self.lower)

    def __sub__(self, other: Interval | float) -> Interval:
        b = _interval(other)
        return Interval(
            down(self.lower - b.upper),
            up(self.upper - b.lower),
        )

    def __rsub__(self, other: float) -> Interval:
        return _interval(other) - self

    def __mul__(self, other: Interval | float) -> Interval:
        if other is self:
            return self.squared()
        b = _interval(other)
        with np.errstate(over="ignore"):  # infinite bounds hold it
            products = np.stack(
                np.broadcast_arrays(
                    self.lower * b.lower,
                    self.lower * b.upper,
                    self.upper * b.lower,
                    self.upper * b.upper,
                )
            )
        return Interval(
            down(products.min(axis=0)),
            up(products.max(axis=0)),
        )

    __rmul__ = __mul__

    def squared(self) -> Interval:
        """Its square, which is not negative."""
        with np.errstate(over="ignore"):  # infinite bounds hold it
            ends = np.stack([self.lower**2, self.upper**2])
        least = np.where(
            self.holds_zero(),
            0.0,
            down(ends.min(axis=0)),
        )
        return Interval(
            np.maximum(least, 0.0),
            up(ends.max(axis=0)),
        )

    def reciprocal(self) -> Interval:
        """1 over it; unbounded where it holds zero."""
        with np.errstate(divide="ignore", over="ignore"):
            lower = down(1.0 / self.upper)
            upper = up(1.0 / self.lower)
        undefined = self.holds_zero()
        return Interval(
            np.where(undefined, -np.inf, lower),
            np.where(undefined, np.inf, upper),
        )

    def __truediv__(self, other: Interval | float) -> Interval:
        return self * _interval(other).reciprocal()

    def __rtruediv__(self, other: float) -> Interval:
        return self.reciprocal() * other

    def sqrt(self) -> Interval:
        """Square root of what is not negative in it; NaN if nothing is."""
        with np.errstate(invalid="ignore"):
            upper = up(np.sqrt(self.upper))
        lower = down(np.sqrt(np.maximum(self.lower, 0.0)))
        return Interval(np.maximum(lower, 0.0) + 0.0 * upper, upper)

    def absolute(self) -> Interval:
        """Absolute value."""
        ends = np.stack([np.abs(self.lower), np.abs(self.upper)])
        least = np.where(
            self.holds_zero(),
            0.0,
            ends.min(axis=0),
        )
        return Interval(least, ends.max(axis=0))

    def rint(self) -> Interval:
        """Nearest integers."""
        return Interval(
            np.rint(self.lower),
            np.rint(self.upper),
        )

    def atan2(self, x: Interval) -> Interval:
        """Angles of vectors (x, self); all angles, since nothing here needs them closer."""
        zero = 0.0 * (self.lower + x.lower)
        return Interval(zero - _HALF_TURN, zero + _HALF_TURN)

    def cos(self) -> Interval:
        """Cosine."""
        return self._wave(
            np.cos(self.lower),
            np.cos(self.upper),
            0.0,
        )

    def sin(self) -> Interval:
        """Sine."""
        return self._wave(
            np.sin(self.lower),
            np.sin(self.upper),
            0.25,
        )

    def _wave(
        self,
        first: Array,
        last: Array,
        peak: float,
    ) -> Interval:
        """A wave of period 2 pi with its largest value 1 after `peak` turns.

        Args:
            first: its value at the lower bounds.
            last: its value at the upper bounds.
            peak: where it is largest [turns].
        """
        start = self.lower / (2.0 * np.pi) - peak - _NEAR
        end = self.upper / (2.0 * np.pi) - peak + _NEAR
        wide = ~(self.magnitude < _UNBOUNDED)
        rises = (np.ceil(start) <= end) | wide
        falls = (np.ceil(start - 0.5) <= end - 0.5) | wide
        lower = np.minimum(first, last) - _LIBRARY
        upper = np.maximum(first, last) + _LIBRARY
        lower = np.where(
            falls,
            -1.0,
            np.maximum(lower, -1.0),
        )
        upper = np.where(
            rises,
            1.0,
            np.minimum(upper, 1.0),
        )
        return Interval(lower, upper)

    def __repr__(self) -> str:
        return f"Interval({self.lower!r}, {self.upper!r})"


def _interval(x: Interval | float) -> Interval:
    if isinstance(x, Interval):
        return x
    return Interval(x)


def enclosing(x: Interval | float) -> Interval:
    """A scalar as an interval; a float is a point."""
    return _interval(x)
