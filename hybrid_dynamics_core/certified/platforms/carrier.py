"""Chains that carry a platform: a ball joint, on three slides, on a leg or on nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...algebra.vector import ZERO3
from ...closure.blocks.leg_blocks import BallJointBlock, UniversalJointBlock
from ...closure.blocks.three_spheres import slides_only
from ...closure.constraints.ball_cut import Ball, Orientation, find_ball
from ...closure.constraints.leg import Direction, Distance, Pivot, find_pivot
from ...closure.constraints.spatial import Chain
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ...mechanism.tree import floats, rows
from .hinge_leg import HingeLeg, hinge_leg


@dataclass(frozen=True)
class Carrier:
    """The chain that carries a platform.

    Attributes:
        chain: its bodies, the platform last.
        ball: the ball joint at its end.
        slides: coordinates of its three slides, if it has them.
        pivot: the universal joint of its leg, if it has one.
        hinge: its leg on a hinge, if it has one.
    """

    chain: Chain
    ball: Ball
    slides: tuple[int, ...] = ()
    pivot: Pivot | None = None
    hinge: HingeLeg | None = None

    @property
    def is_fixed(self) -> bool:
        """Whether the ball joint has a constant place."""
        return not self.slides and self.pivot is None and self.hinge is None

    @property
    def legs(self) -> list[Distance]:
        """The leg on a universal joint that is part of it."""
        if self.pivot is None:
            return []
        return [Distance("", self.pivot, Chain(self.chain.bodies, self.ball.centre))]

    @property
    def hinges(self) -> list[HingeLeg]:
        """The leg on a hinge that is part of it."""
        if self.hinge is None:
            return []
        return [self.hinge]

    def placed(
        self, rotation: Array, origin: Array, configuration: Configuration, guess: Sequence[float]
    ) -> tuple[Configuration, float]:
        """A configuration in which the platform has a pose.

        Args:
            rotation: rotation of the platform (3, 3).
            origin: its origin (3,) [m].
            configuration: the given coordinates.
            guess: all coordinates nearby [rad, m]; of two solutions the nearer one is chosen.

        Returns:
            The configuration, and a margin: positive if the joints reach the pose, negative if
            they do not.
        """
        wanted = Chain((), ZERO3, rows(rotation))
        turning = BallJointBlock(Orientation("", self.ball, self.chain, wanted))
        centre = rotation @ np.array(self.ball.centre) + origin
        base = configuration.copy()
        reach = self._reach(base, centre, guess)
        nearest, least, margin = base, np.inf, -1.0
        for branch in turning.signs:
            trial = base.copy()
            margin = float(turning.solve(trial, branch, guess))  # the same for both
            moves = [abs(float(trial.q[k]) - guess[k]) for k in self.ball.coordinates]
            if max(moves) < least:
                nearest, least = trial, max(moves)
        return nearest, min(margin, reach)

    def _reach(
        self,
        configuration: Configuration,
        centre: Array,
        guess: Sequence[float],
    ) -> float:
        """Bring the ball to a place (3,) [m], and return a margin."""
        goal = Chain((), floats(centre))
        if self.is_fixed:
            return 1.0
        if self.slides:
            return self._slide(configuration, centre)
        if self.hinge is not None:
            self.hinge.aim_at(goal, configuration, guess)
            return 1.0
        assert self.pivot is not None  # noqa: S101  a carrier has one of the three
        aimed = Direction("", self.pivot, self.ball.before, goal)
        return float(UniversalJointBlock(aimed).solve(configuration, 1.0, guess))

    def _slide(self, configuration: Configuration, centre: Array) -> float:
        """Set the slides so that the ball is at a place (3,) [m].

        Returns:
            The volume between the directions of the slides.
        """
        state = self.ball.before.at(configuration.with_zeros(self.slides))
        axes = {joint.body.coordinate: joint.axis for joint in state.joints}
        columns = [axes[k] for k in self.slides]
        directions = np.array(columns, dtype=float).T
        gap = centre - np.array(state.end, dtype=float)
        strokes = np.linalg.pinv(directions) @ gap
        for k, stroke in zip(
            self.slides,
            strokes.tolist(),
            strict=True,
        ):
            configuration.set_length(k, stroke)
        return abs(float(np.linalg.det(directions)))


def carrier_of(chain: Chain, unknown: frozenset[int]) -> Carrier | None:
    """A chain as a carrier; None if it is none."""
    ball = find_ball(chain, unknown)
    if ball is None:
        return None
    before = ball.before
    moving = unknown & before.coordinates
    slides = tuple(sorted(moving))
    if not moving:
        return Carrier(chain, ball)
    if len(slides) == 3 and slides_only(before, slides):
        return Carrier(chain, ball, slides=slides)
    pivot = find_pivot(before, moving)
    if pivot is not None and len(moving) == 2:
        return Carrier(chain, ball, pivot=pivot)
    to_centre = Chain(chain.bodies, ball.centre)
    hinge = hinge_leg(before, to_centre, unknown)
    if hinge is not None:
        return Carrier(chain, ball, hinge=hinge)
    return None
