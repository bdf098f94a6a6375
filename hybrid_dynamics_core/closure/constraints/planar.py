"""A planar loop: two chains of parallel revolute and in-plane prismatic joints that meet in a pin.

All vectors are in the plane of the loop, in the frame of the link where the two chains start.
Pivots and directions of joints are stored at zero coordinates. So a chain is a product of
exponentials in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import Scalar, Scalars
from ...algebra.vector import Vector, add, perp, scale, sub, turn
from ...mechanism.configuration import Configuration
from .equations import Linearised, LoopEquations, Row

ORIGIN: Vector = (0.0, 0.0)


@dataclass(frozen=True)
class PlanarJoint:
    """A joint of a planar loop.

    Attributes:
        coordinate: its index in s.
        revolute: whether it turns; otherwise it slides.
        sign: +1 if its axis is the normal of the plane, -1 if it is opposed.
        place: pivot [m] of a revolute joint, unit direction of a prismatic one; (2,), at zero.
    """

    coordinate: int
    revolute: bool
    sign: float
    place: Vector


@dataclass(frozen=True)
class PlanarGeometry:
    """Both chains of a planar loop and their end points (2,) [m] at zero."""

    chain_a: tuple[PlanarJoint, ...]
    chain_b: tuple[PlanarJoint, ...]
    point_a: Vector
    point_b: Vector

    @property
    def joints(self) -> tuple[PlanarJoint, ...]:
        """All joints of the loop, chain a first."""
        return self.chain_a + self.chain_b


@dataclass
class PlanarChainState:
    """A chain at a configuration.

    Attributes:
        joints: its joints.
        places: pivot [m] of each revolute joint, direction of each prismatic one.
        end: the end point (2,) [m].
    """

    joints: Sequence[PlanarJoint]
    places: list[Vector]
    end: Vector

    def columns(self) -> list[tuple[int, Vector]]:
        """Coordinate, and velocity of the end point per unit rate, joint by joint."""
        columns: list[tuple[int, Vector]] = []
        for joint, place in zip(self.joints, self.places, strict=True):
            velocity = place
            if joint.revolute:
                velocity = perp(sub(self.end, place))
            columns.append((joint.coordinate, scale(joint.sign, velocity)))
        return columns

    def bias(self, rates: Scalars) -> Vector:
        """Acceleration of the end point with all joint accelerations zero.

        The centripetal and Coriolis terms, from s'.
        """
        total: Vector = (0.0, 0.0)
        omega: Scalar = 0.0
        last: Vector | None = None
        for joint, place in zip(self.joints, self.places, strict=True):
            rate = joint.sign * rates[joint.coordinate]
            if not joint.revolute:
                total = add(total, scale(2.0 * omega * rate, perp(place)))
                continue
            if last is not None:
                total = sub(total, scale(omega * omega, sub(place, last)))
            omega = omega + rate
            last = place
        if last is None:
            return total
        return sub(total, scale(omega * omega, sub(self.end, last)))

    def marks(self) -> list[Scalar]:
        """Coordinates [m] of all pivots and of the end point."""
        marks: list[Scalar] = []
        for joint, place in zip(self.joints, self.places, strict=True):
            if joint.revolute:
                marks += place
        return [*marks, *self.end]


def widest(points: Sequence[Vector]) -> float:
    """Largest distance between two of some points [m]."""
    return max(norm(np.subtract(a, b)) for a, b in combinations(points, 2))


def planar_chain(
    joints: Sequence[PlanarJoint], point: Vector, configuration: Configuration
) -> PlanarChainState:
    """A chain with its end point (2,) [m] at zero, at a configuration."""
    c: Scalar = 1.0
    s: Scalar = 0.0
    # last pivot, its position at zero, and displacement of the slides after it
    pivot, at_zero, slid = ORIGIN, ORIGIN, ORIGIN
    places: list[Vector] = []
    for joint in joints:
        k = joint.coordinate
        if not joint.revolute:
            places.append(turn(c, s, joint.place))
            slid = add(slid, scale(joint.sign * configuration.q[k], joint.place))
            continue
        way = add(sub(joint.place, at_zero), slid)
        pivot = add(pivot, turn(c, s, way))
        places.append(pivot)
        at_zero, slid = joint.place, ORIGIN
        c, s = turn(configuration.c[k], joint.sign * configuration.s[k], (c, s))
    way = add(sub(point, at_zero), slid)
    return PlanarChainState(joints, places, add(pivot, turn(c, s, way)))


class PlanarPin(LoopEquations):
    """The two end points coincide: two equations."""

    def __init__(self, name: str, geometry: PlanarGeometry) -> None:
        self.name = name
        self.geometry = geometry
        pivots = [joint.place for joint in geometry.joints if joint.revolute]
        self.length = widest([*pivots, geometry.point_a, geometry.point_b]) or 1.0
        self.involved = (frozenset(joint.coordinate for joint in geometry.joints),) * 2

    @property
    def unit(self) -> float:
        """One over the length."""
        return 1.0 / self.length

    def chains(self, configuration: Configuration) -> tuple[PlanarChainState, PlanarChainState]:
        """Both chains at a configuration."""
        g = self.geometry
        return (
            planar_chain(g.chain_a, g.point_a, configuration),
            planar_chain(g.chain_b, g.point_b, configuration),
        )

    def linearise(self, configuration: Configuration) -> Linearised:
        """Difference of the end points."""
        a, b = self.chains(configuration)
        rows: list[Row] = [{}, {}]
        for factor, chain in ((self.unit, a), (-self.unit, b)):
            for coordinate, column in chain.columns():
                for row, value in zip(rows, column, strict=True):
                    row[coordinate] = factor * value
        gap = sub(a.end, b.end)
        return Linearised(rows, list(scale(self.unit, gap)))

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """Difference of the end points' accelerations with joint accelerations zero."""
        a, b = self.chains(configuration)
        gap = sub(a.bias(rates), b.bias(rates))
        return list(scale(self.unit, gap))

    def extent(self, configuration: Configuration) -> float:
        """Largest distance between pivots and pin [m]."""
        places: list[Vector] = []
        for chain in self.chains(configuration):
            places.append(chain.end)
            for joint, place in zip(chain.joints, chain.places, strict=True):
                if joint.revolute:
                    places.append(place)
        return widest(places)

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Pivots and ends."""
        a, b = self.chains(configuration)
        return [*a.marks(), *b.marks()]
