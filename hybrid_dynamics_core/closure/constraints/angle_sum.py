"""Angles whose sum is constant: the end links of a planar loop, or two bars, stay parallel."""

from __future__ import annotations

from ...algebra.scalar import Scalar, Scalars, atan2, cos, sin
from ...algebra.vector import Vector, constant, turn
from ...mechanism.configuration import Configuration
from .equations import Linearised, LoopEquations

Turns = tuple[tuple[int, float], ...]  # (coordinate, +1 or -1)


class AngleSum(LoopEquations):
    """offset + sum of +-angles = 0, up to whole turns."""

    length = 1.0
    has_length = False

    def __init__(self, name: str, turns: Turns, offset: float) -> None:
        sums: dict[int, float] = {}
        for k, sign in turns:
            sums[k] = sums.get(k, 0.0) + sign
        self.name = name
        self.offset = offset
        self.turns = tuple((k, sign) for k, sign in sums.items() if sign)
        self.involved = (frozenset(k for k, _ in self.turns),)

    def linearise(self, configuration: Configuration) -> Linearised:
        """A constant row; the residual is the sine of the sum."""
        _, sine = self._direction(configuration)
        return Linearised([dict(self.turns)], [sine])

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """Zero: the equation is linear."""
        return [0.0]

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """The angles themselves."""
        marks: list[Scalar] = []
        for k, _ in self.turns:
            marks += [configuration.c[k], configuration.s[k]]
        return marks

    def gaps(self, configuration: Configuration, residual: list[Scalar]) -> list[Scalar]:
        """The angle itself, since its sine is zero at half a turn too."""
        cosine, sine = self._direction(configuration)
        return [atan2(sine, cosine)]

    def guards(self, configuration: Configuration) -> list[Scalar]:
        """The cosine of the sum: positive if parallel, negative if opposed."""
        cosine, _ = self._direction(configuration)
        return [cosine]

    def _direction(self, configuration: Configuration) -> Vector:
        """Cosine and sine of the sum."""
        offset = (cos(self.offset), sin(self.offset))
        direction: Vector = constant(offset)
        for k, sign in self.turns:
            direction = turn(configuration.c[k], sign * configuration.s[k], direction)
        return direction
