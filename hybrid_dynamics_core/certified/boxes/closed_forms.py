"""Closed forms of loops over cells of active coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.scalar import Scalar
from ...algebra.vector import Vector
from ...closure.closed_motion import ClosedMotion
from ...description.model import Frame
from ...dynamics.spanning import TreeDynamics
from ...ground.arrays import Array
from ...kernels.differentiate import jacobian
from ...kernels.graph import Graph
from ...mechanism.configuration import given_configuration
from ...programs import Model
from ...programs.kinematics import frame_pose
from ..interval import Interval
from .graph_values import GraphValues, columns

Flags = NDArray[np.bool_]
Components = dict[tuple[int, int], Interval]  # by vector and component


class Verdicts(NamedTuple):
    """What closed forms prove of N cells.

    Attributes:
        closes: whether all loops close in each configuration, and none is singular (N,).
        is_open: whether some loop closes in none (N,).
        place_lower: lower bounds of the frame's places (N, 3) [m].
        place_upper: upper bounds (N, 3).
    """

    closes: Flags
    is_open: Flags
    place_lower: Array
    place_upper: Array


class ClosedForms:
    """The closed forms of a robot's loops over intervals.

    A block closes where its margin is positive, and in no place where it is negative. There its two
    solutions differ: circles, lines or spheres cross and do not touch, so that it is regular.
    """

    def __init__(
        self, model: Model, signs: Sequence[float], guess: Sequence[float], frame: Frame
    ) -> None:
        """Trace the closure, up to the first block that closes by iteration.

        Args:
            model: tree and plan.
            signs: branch signs of the blocks, then the charts of ball and free joints.
            guess: all coordinates (n_s,) of a closed configuration [rad, m].
            frame: the frame whose places are wanted.
        """
        graph = Graph()
        plan = model.plan
        u = [graph.input(0, k) for k in range(len(plan.given))]
        self.is_closed_form = not any(block.iterates for block in plan.blocks)
        guards: list[Scalar] = []
        place: Vector = ()
        if self.is_closed_form:
            motion = ClosedMotion(model.tree, plan, u, signs, guess)
            margins = [block.margin for block in motion.blocks]
            guards = motion.guards
            _, place = frame_pose(
                TreeDynamics(model.tree, motion.configuration),
                frame,
            )
        else:
            margins = _first_margins(model, u, signs, guess)
        self._margins = _Sloped(graph, margins, u)
        self._guards = GraphValues(graph, guards)
        self._place = GraphValues(graph, list(place))

    def at(self, lower: Array, upper: Array) -> Verdicts:
        """What is proved of cells (N, n)."""
        count = len(lower)
        inputs = _inputs(lower, upper)
        closes = np.full(count, self.is_closed_form)
        is_open = np.zeros(count, dtype=bool)
        for margin in self._margins.at(lower, upper):
            closes &= margin.lower > 0.0
            is_open |= margin.upper < 0.0
        for guard in self._guards.at(inputs, count):
            closes &= guard.lower > 0.0
        place_lower = np.full((count, 3), np.nan)
        place_upper = np.full((count, 3), np.nan)
        for axis, value in enumerate(self._place.at(inputs, count)):
            place_lower[:, axis] = value.lower
            place_upper[:, axis] = value.upper
        return Verdicts(closes, is_open, place_lower, place_upper)


class _Sloped:
    """Outputs that are enclosed twice: directly, and by the mean value theorem."""

    def __init__(
        self,
        graph: Graph,
        outputs: Sequence[Scalar],
        u: Sequence[Scalar],
    ) -> None:
        slopes = jacobian(outputs, u)
        self._values = GraphValues(graph, outputs)
        self._slopes = GraphValues(graph, list(chain.from_iterable(slopes)))

    def at(
        self,
        lower: Array,
        upper: Array,
    ) -> list[Interval]:
        """The outputs in cells (N, n)."""
        count = len(lower)
        middle = 0.5 * (lower + upper)
        inputs, centre = _inputs(lower, upper), _inputs(middle, middle)
        moves = [inputs[key] - centre[key] for key in inputs]
        slopes = iter(self._slopes.at(inputs, count))
        plain = self._values.at(inputs, count)
        results = []
        for value, total in zip(
            plain,
            self._values.at(centre, count),
            strict=True,
        ):
            about = total
            for move in moves:
                about = about + next(slopes) * move
            lowest = np.fmax(value.lower, about.lower)
            highest = np.fmin(value.upper, about.upper)
            results.append(Interval(lowest, highest))
        return results


def _inputs(lower: Array, upper: Array) -> Components:
    return {(0, k): value for k, value in enumerate(columns(lower, upper))}


def _first_margins(
    model: Model, u: Sequence[Scalar], signs: Sequence[float], guess: Sequence[float]
) -> list[Scalar]:
    """Margins of the blocks before the first that closes by iteration."""
    plan = model.plan
    branch, charts = plan.split(signs)
    given = dict(zip(plan.given, u, strict=True))
    configuration = given_configuration(model.tree, given, charts)
    margins: list[Scalar] = []
    for block, sign in zip(plan.blocks, branch, strict=True):
        if block.iterates:
            break
        margins.append(block.solve(configuration, sign, guess))
    return margins
