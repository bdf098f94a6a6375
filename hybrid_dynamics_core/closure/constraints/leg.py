"""A leg on a universal joint, whose two axes meet in a point O.

The distance from O to the leg's end does not depend on the two angles. So a point closure splits
into one equation of distance, without the angles, and two of direction. The platform is solved
first, then each leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import Scalar, Scalars
from ...algebra.vector import Vector, constant, dot, scale, sub
from ...mechanism.configuration import Configuration
from ...mechanism.joint_transform import Column
from ...mechanism.tree import Body
from .equations import Linearised, LoopEquations, Row
from .spatial import Chain, ChainState, chains_length, extent_of

MEET = 1e-9  # [m] up to which two axes count as meeting
PARALLEL = 1e-6  # sine of the angle below which two axes count as parallel


@dataclass(frozen=True)
class Pivot:
    """A universal joint in a chain.

    Attributes:
        before: the chain up to the meeting point O of the two axes.
        first: the body of its first joint.
        second: the body of its second joint.
        after: the remaining chain, in the second body's frame.
        centre: O in that frame (3,) [m].
    """

    before: Chain
    first: Body
    second: Body
    after: Chain
    centre: Vector

    @property
    def leg_has_length(self) -> bool:
        """Whether the leg can have a length above zero; a leg that ends in O has no direction."""
        if any(not body.is_revolute for body in self.after.bodies):
            return True
        first, *others = [*(body.translation for body in self.after.bodies), self.after.point]
        vectors = [sub(first, self.centre), *others]
        return any(norm(vector) > MEET for vector in vectors)

    @property
    def coordinates(self) -> tuple[int, int]:
        """The coordinates of its two joints."""
        return self.first.coordinate, self.second.coordinate


def find_pivot(chain: Chain, only: frozenset[int]) -> Pivot | None:
    """The first universal joint of a chain whose two coordinates are both in `only`."""
    for k, (first, second) in enumerate(pairwise(chain.bodies)):
        if not {first.coordinate, second.coordinate} <= only:
            continue
        if not (first.is_revolute and second.is_revolute) or second.chart is not None:
            continue
        meeting = meeting_point(first, second)
        if meeting is not None:
            in_parent, in_second = meeting
            before = Chain(chain.bodies[:k], in_parent)
            after = Chain(chain.bodies[k + 2 :], chain.point)
            pivot = Pivot(before, first, second, after, in_second)
            if pivot.leg_has_length:
                return pivot
    return None


def meeting_point(first: Body, second: Body) -> tuple[Vector, Vector] | None:
    """Meeting point of two axes, in the frame before the first joint and in the second body's."""
    a = np.array(first.axis)
    b = np.array(second.rotation) @ np.array(second.axis)
    offset = np.array(second.translation)
    normal = np.cross(a, b)
    size = normal @ normal
    if size < PARALLEL**2 or abs(float(offset @ normal)) > MEET:
        return None
    along = np.cross(offset, b) @ normal / size
    point = a * along  # on the first axis
    in_parent = np.array(first.rotation) @ point + np.array(first.translation)
    in_second = np.array(second.rotation).T @ (point - offset)
    return constant(in_parent), constant(in_second)


class Distance(LoopEquations):
    """(|end - O|^2 - |leg|^2) / 2 = 0.

    O is the meeting point of the pivot, leg the vector from it to the leg's end in the second body.
    """

    def __init__(self, name: str, pivot: Pivot, target: Chain) -> None:
        self.name = name
        self.pivot = pivot
        self.target = target
        chains = (pivot.before, pivot.after, target)
        self.length = chains_length(*chains)
        coordinates = [chain.coordinates for chain in chains]
        self.involved = (frozenset().union(*coordinates),)

    @property
    def unit(self) -> float:
        """One over the squared length."""
        return 1.0 / self.length**2

    def ends(self, configuration: Configuration) -> tuple[ChainState, ChainState, ChainState]:
        """Meeting point, leg vector, target point."""
        leg = self.pivot.after.at(configuration).relative_to(self.pivot.centre)
        return self.pivot.before.at(configuration), leg, self.target.at(configuration)

    def linearise(self, configuration: Configuration) -> Linearised:
        """Rows: D . J_target - D . J_O - leg . J_leg, over the length squared."""
        origin, leg, target = self.ends(configuration)
        gap = sub(target.end, origin.end)
        row: Row = {}
        terms = (
            (self.unit, gap, target),
            (-self.unit, gap, origin),
            (-self.unit, leg.end, leg),
        )
        for factor, vector, state in terms:
            for k, (linear, _) in state.columns().items():
                row[k] = factor * dot(vector, linear)
        difference = dot(gap, gap) - dot(leg.end, leg.end)
        return Linearised([row], [0.5 * self.unit * difference])

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """Second derivative with joint accelerations zero."""
        origin, leg, target = self.ends(configuration)
        gap = sub(target.end, origin.end)
        velocity = sub(_linear(target.velocity(rates)), _linear(origin.velocity(rates)))
        leg_velocity = _linear(leg.velocity(rates))
        total = dot(velocity, velocity)
        acceleration = sub(_linear(target.bias(rates)), _linear(origin.bias(rates)))
        total = total + dot(gap, acceleration)
        total = total - dot(leg_velocity, leg_velocity) - dot(leg.end, _linear(leg.bias(rates)))
        return [total * self.unit]

    def extent(self, configuration: Configuration) -> float:
        """Largest distance between axes, meeting point, and target [m]."""
        before = self.pivot.before.at(configuration)
        return extent_of([before, self.target.at(configuration)])

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Meeting point and target."""
        origin, _, target = self.ends(configuration)
        return [*origin.end, *target.end]


class Direction(LoopEquations):
    """The two equations of direction of a point closure.

    The gap is projected onto the velocities that the pivot's two angles give to the leg's end.
    """

    def __init__(self, name: str, pivot: Pivot, leg: Chain, target: Chain) -> None:
        self.name = name
        self.pivot = pivot
        self.leg = leg
        self.target = target
        self.length = chains_length(leg, target)
        self.involved = (leg.coordinates | target.coordinates,) * 2

    @property
    def unit(self) -> float:
        """One over the squared length."""
        return 1.0 / self.length**2

    def linearise(self, configuration: Configuration) -> Linearised:
        """The difference of the end points and its Jacobian, projected."""
        leg = self.leg.at(configuration)
        target = self.target.at(configuration)
        directions = self._directions(leg)
        rows: list[Row] = [{}, {}]
        for sign, state in ((1.0, leg), (-1.0, target)):
            for k, (linear, _) in state.columns().items():
                for row, direction in zip(rows, directions, strict=True):
                    row[k] = sign * dot(direction, linear)
        gap = sub(leg.end, target.end)
        return Linearised(rows, [dot(direction, gap) for direction in directions])

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """The difference of the accelerations, projected.

        Rates of the directions drop out, since they are multiplied by the gap, which is zero.
        """
        leg = self.leg.at(configuration)
        target = self.target.at(configuration)
        gap = sub(_linear(leg.bias(rates)), _linear(target.bias(rates)))
        return [dot(direction, gap) for direction in self._directions(leg)]

    def extent(self, configuration: Configuration) -> float:
        """Largest distance between axes and pin [m]."""
        return extent_of([self.leg.at(configuration), self.target.at(configuration)])

    def _directions(self, leg: ChainState) -> list[Vector]:
        columns = leg.columns()
        return [scale(self.unit, _linear(columns[k])) for k in self.pivot.coordinates]


def _linear(motion: Column) -> Vector:
    """The linear part of a motion."""
    linear, _ = motion
    return linear
