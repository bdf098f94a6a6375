"""Blocks of the closure plan that are a platform on legs.

Three slides and a ball joint carry the platform, or a leg and a ball joint. A leg on a
universal joint keeps one distance. A leg on a hinge moves its end on a circle, which keeps two: to
two points of the hinge's axis. So six distances determine the poses of the platform.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...algebra.vector import ZERO3, dot, sub
from ...closure.blocks.block_solver import BlockSolver
from ...closure.constraints.equations import loops_of
from ...closure.constraints.leg import Distance
from ...closure.constraints.spatial import Chain
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Tree
from ..enclosed import enclosed, joined, stacked
from .carrier import Carrier, carrier_of
from .hinge_leg import HingeLeg, hinge_legs
from .platform import LegIntervals

LEGS = 6
TURNING_LEGS = 3  # of a platform that turns about a fixed point
CLEAR = 1e-6  # margin of the ball joint, or determinant of the slides, below which it is singular


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
        legs = LegIntervals(stacked(feet), stacked(tips), joined(squares))
        if not self.carrier.is_fixed:
            return legs
        ball = self.carrier.ball
        centre = joined(ball.before.at(here).end)
        return LegIntervals(legs.feet - centre, legs.tips - joined(ball.centre), legs.squares)


def leg_platform(block: BlockSolver) -> LegPlatform | None:
    """A block as a platform on six legs; None if it is none."""
    unknown = frozenset(block.unknowns)
    loops = loops_of(block.equations)
    legs = tuple(loop for loop in loops if isinstance(loop, Distance))
    hinges = hinge_legs(loops, unknown)
    equations = len(legs) + 3 * len(hinges)
    if not loops or not equations == len(block.equations) == len(block.unknowns):
        return None
    chains = [leg.target for leg in legs]
    chains += [hinge.carrier for hinge in hinges]
    if any(_moves(leg, unknown) for leg in legs):
        return None
    carrier = _common_carrier(chains, unknown)
    if carrier is None:
        return None
    all_legs = (*carrier.legs, *legs)
    all_hinges = (*carrier.hinges, *hinges)
    wanted = LEGS
    if carrier.is_fixed:
        wanted = TURNING_LEGS
    if len(all_legs) + 2 * len(all_hinges) != wanted:
        return None
    return LegPlatform(carrier, all_legs, all_hinges)


def _common_carrier(chains: Sequence[Chain], unknown: frozenset[int]) -> Carrier | None:
    """The carrier of a platform to which all these chains lead; None if there is none."""
    bodies = chains[0].bodies
    if any(chain.bodies != bodies for chain in chains):
        return None
    return carrier_of(Chain(bodies, ZERO3), unknown)


def _moves(leg: Distance, unknown: frozenset[int]) -> bool:
    """Whether the foot or the length of a leg depends on the unknowns."""
    chains = (leg.pivot.before, leg.pivot.after)
    return any(chain.coordinates & unknown for chain in chains)
