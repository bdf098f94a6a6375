"""A joint that follows others: mimic joints, gears, level hands, coupled cylinders."""

from __future__ import annotations

from collections.abc import Mapping

from ...algebra.scalar import Scalar, Scalars
from ...mechanism.configuration import Configuration
from .equations import Linearised, LoopEquations


class JointCoupling(LoopEquations):
    """One linear equation: sum of coefficient * coordinate + offset = 0."""

    length = 1.0
    has_length = False

    def __init__(self, name: str, coefficients: Mapping[int, float], offset: float) -> None:
        self.name = name
        self.coefficients = dict(coefficients)
        self.offset = offset
        self.involved = (frozenset(self.coefficients),)
        self.counted_turns = frozenset(self.coefficients)

    def linearise(self, configuration: Configuration) -> Linearised:
        """A constant row."""
        total: Scalar = self.offset
        for k, coefficient in self.coefficients.items():
            total = total + coefficient * configuration.q[k]
        return Linearised([dict(self.coefficients)], [total])

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """Zero: the equation is linear."""
        return [0.0]

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """The coordinates themselves."""
        return [configuration.q[k] for k in self.coefficients]
