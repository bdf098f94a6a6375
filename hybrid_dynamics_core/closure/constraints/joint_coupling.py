"""A joint that follows another one (mimic, gears, coupled cylinders): one linear equation between two coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...algebra.scalar import Scalar
from ...mechanism.configuration import Configuration
from ..blocks.block_solver import Step
from .equations import Equation, Linearised, LoopEquations


class CoordinateRelation(LoopEquations):
    """sum of coefficient * coordinate + offset = 0."""

    length = 1.0

    def __init__(self, name: str, coefficients: Mapping[int, float], offset: float) -> None:
        self.name, self.coefficients, self.offset = name, dict(coefficients), offset
        self.involved = (frozenset(self.coefficients),)

    def linearise(self, configuration: Configuration) -> Linearised:
        """A constant row."""
        total: Scalar = self.offset
        for k, coefficient in self.coefficients.items():
            total = total + coefficient * configuration.q[k]
        return Linearised([dict(self.coefficients)], [total])

    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:  # noqa: ARG002
        """A linear relation has none."""
        return [0.0]

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """The coordinates themselves."""
        return [configuration.q[k] for k in self.coefficients]


class RelationStep(Step):
    """The one unknown of a linear relation."""

    def __init__(self, relation: CoordinateRelation, unknown: int, revolute: bool) -> None:
        self.relation = relation
        self.equations = (Equation(relation, 0),)
        self.unknowns = (unknown,)
        self._revolute = revolute

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,  # noqa: ARG002
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """Always closes."""
        (unknown,) = self.unknowns
        scale = -1.0 / self.relation.coefficients[unknown]
        value: Scalar = self.relation.offset * scale
        for k, coefficient in self.relation.coefficients.items():
            if k != unknown:
                value = value + coefficient * scale * configuration.q[k]
        put = configuration.set_angle if self._revolute else configuration.set_length
        put(unknown, value)
        return 1.0
