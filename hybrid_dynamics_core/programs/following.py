"""Closure from a nearby closed configuration, predicted with R and checked with R at both ends.

On its assembly mode a mechanism moves smoothly. A short move agrees with its prediction by R at the
start, and with that by R at the end. A move that does not may be a jump to another mode. It has the
status `JUMP`, and must be followed in smaller steps.
"""

from __future__ import annotations

from ..algebra.scalar import Scalar, Scalars, absolute
from ..algebra.vector import dot, sub
from ..closure.closed_motion import ClosedMotion
from ..kernels.status import JUMP
from ..kernels.trace import Check
from .model import Inputs, Model

CORRECTION = 0.25  # largest correction, as a share of the predicted move
SLACK = 1e-9  # [rad or m] tolerance of a correction for rounding
LARGEST = 0.5  # [rad or m] longest predicted move of a passive coordinate
HALF_TURN = 3.14  # [rad] largest move of an angle without ambiguity


class Step:
    """Move from a start to given coordinates.

    Attributes:
        move: change of the given coordinates (n,) [rad, m].
        predicted: change of all coordinates (n_s,), by R at the start.
        guess: predicted coordinates (n_s,) at the end.
    """

    def __init__(self, model: Model, x: Inputs) -> None:
        self._model = model
        self._start = x.start
        given = model.plan.given
        self.move = sub(x.u, [x.start[k] for k in given])
        self.predicted = list(x.predicted)
        for row in _rows(x.start_map, len(given)):
            self.predicted.append(dot(tuple(row), self.move))
        for k, length in zip(given, self.move, strict=True):
            self.predicted[k] = length
        self.guess = [a + b for a, b in zip(x.start, self.predicted, strict=True)]

    def checks(self, motion: ClosedMotion) -> list[Check]:
        """Checks of a smooth move, and of given angles within half a turn of the start."""
        hindsight = motion.rates(self.move)
        moved = sub(motion.configuration.q, self._start)
        passive = [k for k in range(motion.size) if k not in motion.given]
        size: Scalar = 0.0
        for k in passive:
            size = _larger(size, absolute(self.predicted[k]))
        bound = CORRECTION * size + SLACK
        checks = [Check(LARGEST - size, 0.0, JUMP)]
        for k in passive:
            for expected in (self.predicted[k], hindsight[k]):
                error = absolute(moved[k] - expected)
                checks.append(Check(bound - error, 0.0, JUMP))
        for k, length in zip(motion.given, self.move, strict=True):
            if self._model.tree.is_revolute(k):
                checks.append(Check(HALF_TURN - absolute(length), 0.0, JUMP))
        return checks


def _rows(flat: Scalars, length: int) -> list[Scalars]:
    return [flat[k : k + length] for k in range(0, len(flat), length)]


def _larger(a: Scalar, b: Scalar) -> Scalar:
    return 0.5 * (a + b + absolute(a - b))
