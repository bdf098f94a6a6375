"""Legs on hinges: their end moves on a circle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...algebra.scalar import Scalar
from ...algebra.vector import Vector, add, cross, dot, scale, sub
from ...closure.constraints.equations import LoopEquations
from ...closure.constraints.spatial import Chain, ChainJoint, SpatialClosure
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Body

APART = (0.5, -0.5)  # [m] places of the two points on the axis


@dataclass(frozen=True)
class HingeLeg:
    """A leg on a hinge, pinned to a platform in a point.

    Attributes:
        chain: the bodies of the leg; all coordinates but the hinge's are given.
        hinge: the body that the hinge carries.
        carrier: the chain of the platform, to the same point.
    """

    chain: Chain
    hinge: Body
    carrier: Chain

    @property
    def tip(self) -> Vector:
        """The point on the platform (3,) [m]."""
        return self.carrier.point

    def straight_end(self, configuration: Configuration) -> Vector:
        """The leg's end (3,) with the hinge at zero [m]."""
        here = configuration.with_zeros([self.hinge.coordinate])
        return self.chain.at(here).end

    def feet(self, configuration: Configuration) -> tuple[Vector, Vector]:
        """Two points (3,) of the hinge's axis [m]."""
        joint = self._joint(configuration)
        first, second = APART
        one = add(joint.origin, scale(first, joint.axis))
        return one, add(joint.origin, scale(second, joint.axis))

    def aim(
        self,
        configuration: Configuration,
        guess: Sequence[float],
    ) -> None:
        """Turn the hinge of a configuration so that the leg ends at its tip."""
        self.aim_at(self.carrier, configuration, guess)

    def aim_at(
        self,
        target: Chain,
        configuration: Configuration,
        guess: Sequence[float],
    ) -> None:
        """Turn the hinge of a configuration so that the leg points to the end of a chain."""
        goal = target.at(configuration).end
        joint = self._joint(configuration)
        bar = sub(self.straight_end(configuration), joint.origin)
        wanted = sub(goal, joint.origin)
        across = cross(joint.axis, bar)
        sine: Scalar = dot(across, wanted)
        cosine: Scalar = dot(across, cross(joint.axis, wanted))
        size = (sine * sine + cosine * cosine) ** 0.5
        k = self.hinge.coordinate
        configuration.set_direction(
            k,
            cosine / size,
            sine / size,
            guess[k],
        )

    def _joint(self, configuration: Configuration) -> ChainJoint:
        here = configuration.with_zeros([self.hinge.coordinate])
        joint = self.chain.at(here).joint_of(self.hinge.coordinate)
        assert joint is not None  # noqa: S101  the hinge is in the chain
        return joint


def hinge_legs(
    loops: Sequence[LoopEquations],
    unknown: frozenset[int],
) -> tuple[HingeLeg, ...]:
    """The legs on hinges among loops."""
    legs = []
    for loop in loops:
        if isinstance(loop, SpatialClosure) and loop.kind == "point":
            legs += _legs_of(loop, unknown)
    return tuple(legs)


def _legs_of(
    loop: SpatialClosure,
    unknown: frozenset[int],
) -> list[HingeLeg]:
    """The leg of a loop, or none."""
    for chain, carrier in (
        (loop.a, loop.b),
        (loop.b, loop.a),
    ):
        leg = hinge_leg(chain, carrier, unknown)
        if leg is not None:
            return [leg]
    return []


def hinge_leg(
    chain: Chain,
    carrier: Chain,
    unknown: frozenset[int],
) -> HingeLeg | None:
    """A chain as a leg on a hinge to the end of another chain; None if it is none."""
    moving = [body for body in chain.bodies if body.coordinate in unknown]
    if len(moving) != 1 or not moving[0].is_revolute or moving[0].chart is not None:
        return None
    return HingeLeg(chain, moving[0], carrier)
