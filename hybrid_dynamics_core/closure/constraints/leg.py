"""A leg on a universal joint: two revolute joints in a row whose axes meet, then what carries the leg's end.

The distance from the meeting point to the end does not depend on the two angles. So a point closure
splits into one equation of distance, without them, and two of direction: platform and legs then
close one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...algebra.scalar import Scalar
from ...algebra.vector import Vector, constant, dot, scale, sub
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Body
from .equations import Linearised, LoopEquations, Row
from .spatial import Chain, ChainState, chains_length

MEET = 1e-9  # [m] up to which two axes count as meeting
SQUARE = 1e-6  # sine of the angle below which they count as parallel


@dataclass(frozen=True)
class Pivot:
    """A universal joint in a chain: `before` ends in the meeting point O; `first` and `second` are its bodies.

    `after`: the rest of the chain, in the second body's frame; `centre`: O in that frame.
    """

    before: Chain
    first: Body
    second: Body
    after: Chain
    centre: Vector


def find_pivot(chain: Chain, only: frozenset[int]) -> Pivot | None:
    """The first pair of neighbouring revolute joints of the chain, both in `only`, whose axes meet in a point."""
    for k, (first, second) in enumerate(zip(chain.bodies, chain.bodies[1:], strict=False)):
        if (
            not {first.coordinate, second.coordinate} <= only
            or not first.type == second.type == "revolute"
        ):
            continue
        meeting = _meeting(first, second)
        if meeting is not None:
            after = Chain(chain.bodies[k + 2 :], chain.point)
            return Pivot(Chain(chain.bodies[:k], meeting[0]), first, second, after, meeting[1])
    return None


def _meeting(first: Body, second: Body) -> tuple[Vector, Vector] | None:
    """The meeting point in the frame before the first joint, and in the second body's frame; None if they miss."""
    a, b = np.array(first.axis), np.array(second.rotation) @ np.array(second.axis)
    offset = np.array(second.translation, dtype=float)
    normal = np.cross(a, b)
    size = float(normal @ normal)
    if size < SQUARE**2 or abs(float(offset @ normal)) > MEET:
        return None
    along = float(np.cross(offset, b) @ normal) / size  # the point a * along on the first axis
    point = a * along
    in_parent = np.array(first.rotation) @ point + np.array(first.translation)
    in_second = np.array(second.rotation).T @ (point - offset)
    return constant(in_parent), constant(in_second)


class Distance(LoopEquations):
    """(|end - O|^2 - |leg|^2) / 2 = 0: O the meeting point, leg its vector to the leg's end in the second body."""

    def __init__(self, name: str, pivot: Pivot, target: Chain) -> None:
        self.name, self.pivot, self.target = name, pivot, target
        self.length = chains_length(pivot.before, pivot.after, target)
        chains = (pivot.before, pivot.after, target)
        self.involved = (frozenset().union(*(c.coordinates for c in chains)),)

    def ends(self, configuration: Configuration) -> tuple[ChainState, ChainState, ChainState]:
        """Meeting point, leg vector, target point."""
        leg = self.pivot.after.at(configuration)
        leg.end = sub(leg.end, self.pivot.centre)
        leg.origins = [sub(origin, self.pivot.centre) for origin in leg.origins]
        return self.pivot.before.at(configuration), leg, self.target.at(configuration)

    def linearise(self, configuration: Configuration) -> Linearised:
        """Rows: D . J_target - D . J_O - leg . J_leg, over the length squared."""
        origin, leg, target = self.ends(configuration)
        gap = sub(target.end, origin.end)
        unit = 1.0 / self.length**2
        row: Row = {}
        for sign, vector, state in (
            (unit, gap, target),
            (-unit, gap, origin),
            (-unit, leg.end, leg),
        ):
            for k, (linear, _) in state.columns().items():
                row[k] = sign * dot(vector, linear)
        return Linearised([row], [0.5 * unit * (dot(gap, gap) - dot(leg.end, leg.end))])

    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:
        """Second derivative with joint accelerations zero."""
        origin, leg, target = self.ends(configuration)
        gap = sub(target.end, origin.end)
        speed = sub(target.velocity(rates)[0], origin.velocity(rates)[0])
        stretch = leg.velocity(rates)[0]
        total = dot(speed, speed) + dot(gap, sub(target.bias(rates)[0], origin.bias(rates)[0]))
        total = total - dot(stretch, stretch) - dot(leg.end, leg.bias(rates)[0])
        return [total / self.length**2]

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Meeting point and target."""
        origin, _, target = self.ends(configuration)
        return [*origin.end, *target.end]


class Direction(LoopEquations):
    """The two other parts of the point closure: along the motion that each angle of the pivot gives the leg's end."""

    def __init__(self, name: str, pivot: Pivot, whole: Chain, target: Chain) -> None:
        self.name, self.pivot, self.whole, self.target = name, pivot, whole, target
        self.length = chains_length(whole, target)
        self.involved = (whole.coordinates | target.coordinates,) * 2

    def linearise(self, configuration: Configuration) -> Linearised:
        """The difference of the end points and its Jacobian, projected."""
        leg, target = self.whole.at(configuration), self.target.at(configuration)
        along = self._along(leg)
        rows: list[Row] = [{}, {}]
        for sign, state in ((1.0, leg), (-1.0, target)):
            for k, (linear, _) in state.columns().items():
                for row, direction in zip(rows, along, strict=True):
                    row[k] = sign * dot(direction, linear)
        gap = sub(leg.end, target.end)
        return Linearised(rows, [dot(direction, gap) for direction in along])

    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:
        """The difference of the accelerations, projected; the direction's own rate meets a closed gap."""
        leg, target = self.whole.at(configuration), self.target.at(configuration)
        gap = sub(leg.bias(rates)[0], target.bias(rates)[0])
        return [dot(direction, gap) for direction in self._along(leg)]

    def _along(self, leg: ChainState) -> list[Vector]:
        columns = leg.columns()
        joints = (self.pivot.first.coordinate, self.pivot.second.coordinate)
        return [scale(1.0 / self.length**2, columns[k][0]) for k in joints]
