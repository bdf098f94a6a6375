"""Complex numbers with a radius, and polynomials of them, in outward rounding."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from .platforms.study import Complex
from .rounding import TINY

ROUNDING = 2.0**-50  # share of a sum or product of two complex numbers that rounding can change


class Ball(NamedTuple):
    """All complex numbers within a radius of a middle, elementwise for arrays.

    Attributes:
        middle: middles.
        radius: radii, of the same shape.
    """

    middle: Complex
    radius: Array

    @property
    def magnitude(self) -> Array:
        """The largest absolute value."""
        largest: Array = (np.abs(self.middle) + self.radius) * (1.0 + ROUNDING)
        return largest

    @property
    def least(self) -> Array:
        """The smallest absolute value; not positive if zero is in it."""
        least: Array = np.abs(self.middle) * (1.0 - ROUNDING) - self.radius * (1.0 + ROUNDING)
        return least

    def conjugate(self) -> Ball:
        """The conjugate numbers."""
        return Ball(self.middle.conj(), self.radius)

    def plus(self, other: Ball) -> Ball:
        """The sums."""
        middle = self.middle + other.middle
        return Ball(middle, _raised(self.radius + other.radius, middle))

    def minus(self, other: Ball) -> Ball:
        """The differences."""
        return self.plus(Ball(-other.middle, other.radius))

    def times(self, other: Ball) -> Ball:
        """The products."""
        middle = self.middle * other.middle
        changed = np.abs(self.middle) * other.radius
        changes = changed + self.radius * other.magnitude
        return Ball(middle, _raised(changes, middle))

    def divided_by(self, other: Ball) -> Ball:
        """The quotients; without bound where the divisor may be zero."""
        least = other.least
        with np.errstate(divide="ignore", invalid="ignore"):
            middle = self.middle / other.middle
            changes = (self.radius + np.abs(middle) * other.radius) / least
            radius = np.where(
                least > 0.0,
                _raised(changes, middle),
                np.inf,
            )
        return Ball(middle, radius)


def _raised(radius: Array, middle: Complex) -> Array:
    raised: Array = (radius + ROUNDING * np.abs(middle)) * (1.0 + 4.0 * ROUNDING) + TINY
    return raised


class Polynomial(NamedTuple):
    """A polynomial in z and 1 / z.

    Attributes:
        lowest: the lowest power.
        coefficients: coefficients (n,) from that power on, each a ball of arrays.
    """

    lowest: int
    coefficients: tuple[Ball, ...]

    def times(self, other: Polynomial) -> Polynomial:
        """The product."""
        sums: dict[int, Ball] = {}
        for i, a in enumerate(self.coefficients):
            for j, b in enumerate(other.coefficients):
                product = a.times(b)
                earlier = sums.get(i + j)
                sums[i + j] = product
                if earlier is not None:
                    sums[i + j] = earlier.plus(product)
        ordered = [sums[power] for power in sorted(sums)]
        return Polynomial(self.lowest + other.lowest, tuple(ordered))

    def minus(self, other: Polynomial) -> Polynomial:
        """The difference."""
        lowest = min(self.lowest, other.lowest)
        highest = max(self.highest, other.highest)
        powers = range(lowest, highest + 1)
        differences = [self.of(power).minus(other.of(power)) for power in powers]
        return Polynomial(lowest, tuple(differences))

    @property
    def highest(self) -> int:
        """The highest power."""
        return self.lowest + len(self.coefficients) - 1

    def of(self, power: int) -> Ball:
        """The coefficient of a power."""
        if self.lowest <= power <= self.highest:
            return self.coefficients[power - self.lowest]
        first = self.coefficients[0]
        return Ball(
            np.zeros_like(first.middle),
            np.zeros_like(first.radius),
        )

    def at(self, z: Ball) -> Ball:
        """The values at z, by Horner's rule."""
        *others, total = self.coefficients
        for coefficient in reversed(others):
            total = total.times(z).plus(coefficient)
        one = Ball(
            np.ones_like(z.middle),
            np.zeros_like(z.radius),
        )
        inverse = one.divided_by(z)
        factor = z
        if self.lowest < 0:
            factor = inverse
        for _ in range(abs(self.lowest)):
            total = total.times(factor)
        return total
