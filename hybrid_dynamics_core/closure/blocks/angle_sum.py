"""One angle from the others of a sum of angles: parallel links, parallelograms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ...algebra.scalar import Scalar
from ...algebra.vector import Vector, constant, turn
from ...mechanism.configuration import Configuration
from ..constraints.angle_sum import AngleSum
from ..constraints.equations import Equation
from .block_solver import BlockSolver


class AngleBlock(BlockSolver):
    """One angle by addition; its cosine and sine by the addition theorems."""

    settles_on_reference = True

    def __init__(self, angles: AngleSum, unknown: int, mode: str) -> None:
        self.angles = angles
        self.equations = (Equation(angles, 0),)
        self.unknowns = (unknown,)
        self.modes = (mode,)
        sign_of_unknown = dict(angles.turns)[unknown]
        self._others = [(k, -sign * sign_of_unknown) for k, sign in angles.turns if k != unknown]
        self._offset = -angles.offset * sign_of_unknown

    def settle(self, configuration: Configuration, near: Mapping[int, float]) -> None:
        """Shift the constant by whole turns, so that the angle lies within pi of `near`."""
        angle = self._offset + sum(sign * configuration.q[k] for k, sign in self._others)
        wanted = near.get(self.unknowns[0], 0.0)
        self._offset -= 2.0 * math.pi * round((angle - wanted) / (2.0 * math.pi))

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,  # noqa: ARG002
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """Always closes."""
        direction: Vector = constant((math.cos(self._offset), math.sin(self._offset)))
        angle: Scalar = self._offset
        for k, sign in self._others:
            direction = turn(configuration.c[k], sign * configuration.s[k], direction)
            angle = angle + sign * configuration.q[k]
        (unknown,) = self.unknowns
        configuration.q[unknown] = angle
        configuration.c[unknown], configuration.s[unknown] = direction
        return 1.0
