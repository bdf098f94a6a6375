"""One angle from the others in an equation of angles: parallel links, parallelograms."""

from __future__ import annotations

from ...algebra.scalar import Scalar, Scalars, cos, sin
from ...algebra.vector import Vector, constant, turn
from ...mechanism.configuration import Configuration, with_turns
from ..constraints.angle_sum import AngleSum
from ..constraints.equations import Equation
from .block_solver import BlockSolver


class AngleBlock(BlockSolver):
    """One angle by addition; its cosine and sine by the addition theorems.

    Attributes:
        angles: the equation.
        others: the other coordinates with their signs. Their sum and the offset are the angle.
        offset: the constant part of the angle [rad].
    """

    meets_guards = True

    def __init__(self, angles: AngleSum, unknown: int, mode: str) -> None:
        self.angles = angles
        self.equations = (Equation(angles, 0),)
        self.unknowns = (unknown,)
        self.modes = (mode,)
        signs = dict(angles.turns)
        sign_of_unknown = signs.pop(unknown)
        self.others = [(k, -sign * sign_of_unknown) for k, sign in signs.items()]
        self.offset = -angles.offset * sign_of_unknown

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Always closes."""
        offset = (cos(self.offset), sin(self.offset))
        direction: Vector = constant(offset)
        angle: Scalar = self.offset
        for k, sign in self.others:
            direction = turn(configuration.c[k], sign * configuration.s[k], direction)
            angle = angle + sign * configuration.q[k]
        (unknown,) = self.unknowns
        configuration.q[unknown] = with_turns(angle, guess[unknown])
        configuration.c[unknown], configuration.s[unknown] = direction
        return 1.0
