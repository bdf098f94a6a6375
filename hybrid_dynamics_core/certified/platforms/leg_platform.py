"""Blocks of the closure plan that are a platform on legs.

Three slides and a ball joint carry the platform, and their coordinates are unknown. A leg on a
universal joint keeps one distance. A leg on a hinge moves its end on a circle, which keeps two: to
two points of the hinge's axis. So six distances determine the poses of the platform.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...algebra.vector import ZERO3, dot, sub
from ...closure.blocks.block_solver import BlockSolver
from ...closure.blocks.leg_blocks import BallJointBlock
from ...closure.blocks.three_spheres import slides_only
from ...closure.constraints.ball_cut import Ball, Orientation, find_ball
from ...closure.constraints.equations import loops_of
from ...closure.constraints.leg import Distance
from ...closure.constraints.spatial import Chain
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Tree, rows
from ..enclosed import enclosed, joined, stacked
from .hinge_leg import HingeLeg, hinge_legs
from .platform import LegIntervals

LEGS = 6
CLEAR = 1e-6  # margin of the ball joint, or determinant of the slides, below which it is singular


@dataclass(frozen=True)
class Carrier:
    """The chain that carries a platform.

    Attributes:
        chain: its bodies, the platform last.
        slides: coordinates of its three slides.
        ball: the ball joint at its end.
    """

    chain: Chain
    slides: tuple[int, ...]
    ball: Ball

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
        nearest, least, margin = configuration, np.inf, -1.0
        for branch in turning.signs:
            trial = configuration.with_zeros(self.slides)
            margin = float(turning.solve(trial, branch, guess))
            moves = [abs(float(trial.q[k]) - guess[k]) for k in self.ball.coordinates]
            if max(moves) < least:
                nearest, least = trial, max(moves)
        return nearest, min(margin, self._slide(nearest, centre))

    def _slide(self, configuration: Configuration, centre: Array) -> float:
        """Set the slides, which are at zero, so that the ball is at a place (3,) [m].

        Returns:
            The volume between the directions of the slides.
        """
        state = self.ball.before.at(configuration)
        axes = {joint.body.coordinate: joint.axis for joint in state.joints}
        directions = np.array([axes[k] for k in self.slides], dtype=float).T
        gap = centre - np.array(state.end, dtype=float)
        strokes = np.linalg.pinv(directions) @ gap
        for k, stroke in zip(self.slides, strokes.tolist(), strict=True):
            configuration.set_length(k, stroke)
        return abs(float(np.linalg.det(directions)))


@dataclass(frozen=True)
class LegPlatform:
    """A platform on six legs.

    Attributes:
        carrier: the chain that carries the platform.
        legs: the equations of its legs on universal joints.
        hinges: its legs on hinges.
    """

    carrier: Carrier
    legs: tuple[Distance, ...]
    hinges: tuple[HingeLeg, ...]

    def intervals(
        self, tree: Tree, configuration: Configuration, given: Sequence[int]
    ) -> LegIntervals:
        """The geometry of the legs with outward rounding.

        Args:
            tree: the spanning tree.
            configuration: values of all coordinates but the unknowns.
            given: coordinates whose values are exact.
        """
        here = enclosed(tree, configuration, given)
        feet, tips, squares = [], [], []
        for leg in self.legs:
            feet.append(joined(leg.pivot.before.at(here).end))
            bar = leg.pivot.after.at(here).relative_to(leg.pivot.centre)
            tips.append(joined(leg.target.point))
            squares.append(dot(bar.end, bar.end))
        for hinge in self.hinges:
            for foot in hinge.feet(here):
                bar_end = sub(hinge.straight_end(here), foot)
                feet.append(joined(foot))
                tips.append(joined(hinge.tip))
                squares.append(dot(bar_end, bar_end))
        return LegIntervals(stacked(feet), stacked(tips), joined(squares))


def leg_platform(block: BlockSolver) -> LegPlatform | None:
    """A block as a platform on six legs; None if it is none."""
    unknown = frozenset(block.unknowns)
    loops = loops_of(block.equations)
    legs = tuple(loop for loop in loops if isinstance(loop, Distance))
    hinges = hinge_legs(loops, unknown)
    distances = len(legs) + 2 * len(hinges)
    equations = len(legs) + 3 * len(hinges)
    if distances != LEGS or not equations == len(block.equations) == len(block.unknowns):
        return None
    chains = [leg.target.bodies for leg in legs] + [hinge.carrier.bodies for hinge in hinges]
    if any(bodies != chains[0] for bodies in chains) or any(_moves(leg, unknown) for leg in legs):
        return None
    carrier = _carrier(Chain(chains[0], ZERO3), unknown)
    if carrier is None:
        return None
    return LegPlatform(carrier, legs, hinges)


def _carrier(chain: Chain, unknown: frozenset[int]) -> Carrier | None:
    """A chain of three slides and a ball joint; None if it is none."""
    ball = find_ball(chain, unknown)
    if ball is None:
        return None
    moving = unknown & chain.coordinates
    slides = tuple(sorted(moving.difference(ball.coordinates)))
    if len(slides) != 3 or not slides_only(ball.before, slides):
        return None
    return Carrier(chain, slides, ball)


def _moves(leg: Distance, unknown: frozenset[int]) -> bool:
    """Whether the foot or the length of a leg depends on the unknowns."""
    chains = (leg.pivot.before, leg.pivot.after)
    return any(chain.coordinates & unknown for chain in chains)
