"""Units of numbers in files, and their dimensions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

Dimension = tuple[int, int, int, int]  # exponents of m, kg, s, rad

PLAIN: Dimension = (0, 0, 0, 0)
ANGLE: Dimension = (0, 0, 0, 1)
_BASE = ("m", "kg", "s", "rad")
_SYMBOLS: dict[str, Dimension] = {
    "1": PLAIN,
    "m": (1, 0, 0, 0),
    "kg": (0, 1, 0, 0),
    "s": (0, 0, 1, 0),
    "rad": ANGLE,
    "N": (1, 1, -2, 0),
    "Pa": (-1, 1, -2, 0),
    "W": (2, 1, -3, 0),
}
_WORDS = {  # by unit
    "m": "a length",
    "kg": "a mass",
    "s": "a time",
    "rad": "an angle",
    "N": "a force",
    "N m": "a torque",
    "Pa": "a pressure",
    "W": "a power",
    "1/s": "a frequency",
    "m/s": "a velocity",
    "rad/s": "an angular velocity",
    "m/s^2": "an acceleration",
    "rad/s^2": "an angular acceleration",
    "kg m^2": "a moment of inertia",
    "m^3": "a volume",
    "m^3/s": "a flow",
}
_TURN = 2.0 * math.pi  # [rad]
_FACTORS: dict[str, tuple[float, str]] = {  # in SI units
    "km": (1e3, "m"),
    "m": (1.0, "m"),
    "dm": (1.0, "m"),
    "cm": (1.0, "m"),
    "mm": (1.0, "m"),
    "um": (1.0, "m"),
    "l": (1.0, "m^3"),
    "rad": (1.0, "rad"),
    "mrad": (1.0, "rad"),
    "deg": (math.pi / 180.0, "rad"),
    "t": (1e3, "kg"),
    "kg": (1.0, "kg"),
    "g": (1.0, "kg"),
    "h": (3600.0, "s"),
    "min": (60.0, "s"),
    "s": (1.0, "s"),
    "ms": (1.0, "s"),
    "us": (1.0, "s"),
    "Hz": (1.0, "1/s"),
    "kHz": (1e3, "1/s"),
    "N": (1.0, "N"),
    "kN": (1e3, "N"),
    "MN": (1e6, "N"),
    "Nm": (1.0, "N m"),
    "kNm": (1e3, "N m"),
    "J": (1.0, "N m"),
    "kJ": (1e3, "N m"),
    "Pa": (1.0, "Pa"),
    "kPa": (1e3, "Pa"),
    "MPa": (1e6, "Pa"),
    "bar": (1e5, "Pa"),
    "mbar": (100.0, "Pa"),
    "W": (1.0, "W"),
    "kW": (1e3, "W"),
    "MW": (1e6, "W"),
    "rpm": (_TURN / 60.0, "rad/s"),
}


_DIVISORS = {  # units that are fractions of SI units
    "dm": 10.0,
    "cm": 100.0,
    "mm": 1e3,
    "um": 1e6,
    "l": 1e3,
    "mrad": 1e3,
    "g": 1e3,
    "ms": 1e3,
    "us": 1e6,
}


class Quantity(NamedTuple):
    """A number in SI units, with its dimension.

    Attributes:
        dividend: the value in SI units times the divisor.
        dimension: its dimension; None for a name, whose unit is unknown.
        has_number: whether it has a number, and not only units.
        divisor: 1000 for units such as mm, so that 700*mm is exactly 0.7.
    """

    dividend: float
    dimension: Dimension | None = PLAIN
    has_number: bool = True
    divisor: float = 1.0

    @property
    def value(self) -> float:
        """The value in SI units."""
        return self.dividend / self.divisor

    def times(self, other: Quantity) -> Quantity:
        """The product."""
        dimension = _combined(self.dimension, other.dimension, 1)
        has_number = self.has_number or other.has_number
        divisor = self.divisor * other.divisor
        return Quantity(self.dividend * other.dividend, dimension, has_number, divisor)

    def divided_by(self, other: Quantity) -> Quantity:
        """The quotient."""
        dimension = _combined(self.dimension, other.dimension, -1)
        has_number = self.has_number or other.has_number
        dividend = self.dividend * other.divisor
        return Quantity(dividend / other.dividend, dimension, has_number, self.divisor)


def dimension_of(unit: str) -> Dimension:
    """The dimension of a unit such as `N m s/rad`, `kg m^2` or `1/s`."""
    above, _, below = unit.partition("/")
    dimension = PLAIN
    for part, sign in ((above, 1), (below, -1)):
        for factor in part.split():
            symbol, _, power = factor.partition("^")
            exponent = sign * int(power or 1)
            for _ in range(abs(exponent)):
                dimension = _sum(dimension, _SYMBOLS[symbol], 1 if exponent > 0 else -1)
    return dimension


def described(dimension: Dimension | None) -> str:
    """A dimension as text, such as `a length`."""
    if dimension is None:
        return "of a unit that is not written"
    for unit, words in _WORDS.items():
        if dimension_of(unit) == dimension:
            return words
    powers = {name: power for name, power in zip(_BASE, dimension, strict=True) if power}
    factors = [name if power == 1 else f"{name}^{power}" for name, power in powers.items()]
    return f"of the unit {' '.join(factors)}"


def mismatch(dimension: Dimension | None, units: Sequence[str]) -> str:
    """The error text for the dimension of a number; empty if it fits a unit.

    Args:
        dimension: dimension of the number.
        units: the allowed units; empty if any unit is allowed.
    """
    if dimension is None or dimension == PLAIN or not units:
        return ""
    if any(dimension_of(unit) == dimension for unit in units):
        return ""
    unit = units[0]
    words = _WORDS.get(unit)
    expected = f"a number in {unit}" if words is None else f"{words} [{unit}]"
    if unit == "1":
        expected = "a number without a unit"
    return f"is {described(dimension)}; expected {expected}"


def _combined(one: Dimension | None, other: Dimension | None, sign: int) -> Dimension | None:
    if one is None or other is None:
        return None
    return _sum(one, other, sign)


def _sum(one: Dimension, other: Dimension, sign: int) -> Dimension:
    m, kg, s, rad = (a + sign * b for a, b in zip(one, other, strict=True))
    return m, kg, s, rad


def _units() -> Mapping[str, Quantity]:
    units: dict[str, Quantity] = {}
    for name, (factor, unit) in _FACTORS.items():
        divisor = _DIVISORS.get(name, 1.0)
        units[name] = Quantity(factor, dimension_of(unit), False, divisor)
    return MappingProxyType(units)


UNITS = _units()  # units in expressions, by name
