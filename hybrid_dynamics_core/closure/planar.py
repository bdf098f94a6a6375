"""A planar loop: two chains of parallel revolute and in-plane prismatic joints that meet in a pin.

Everything is written in the plane of the loop, in the frame of the link where the two chains part. A joint is
kept as it stands with all coordinates at zero (pivot or direction), so a chain is a product of plane motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..algebra.scalar import Scalar
from ..algebra.vector import Vector, add, constant, perp, scale, sub, turn
from ..description.model import Array, Closure
from ..mechanism.tree import Tree
from .posture import Posture

PARALLEL = 1e-9  # sine of the angle up to which two constant axes count as parallel


@dataclass(frozen=True)
class PlanarJoint:
    """`place`: pivot [m] of a revolute joint, unit direction of a prismatic one, at zero; `sign` of the axis."""

    coordinate: int
    revolute: bool
    sign: float
    place: Vector


@dataclass(frozen=True)
class PlanarLoop:
    """The constant geometry. `length` [m] makes the loop's equations dimensionless."""

    name: str
    chain_a: tuple[PlanarJoint, ...]
    chain_b: tuple[PlanarJoint, ...]
    point_a: Vector
    point_b: Vector
    length: float

    @property
    def joints(self) -> tuple[PlanarJoint, ...]:
        """All joints of the loop, chain a first."""
        return self.chain_a + self.chain_b


@dataclass
class PlanarMotion:
    """A plane displacement x -> turn(c, s, x) + t."""

    c: Scalar = 1.0
    s: Scalar = 0.0
    t: Vector = (0.0, 0.0)

    def move(self, x: Vector) -> Vector:
        """Where the point x of the zero configuration is now."""
        return add(turn(self.c, self.s, x), self.t)

    def then(self, joint: PlanarJoint, posture: Posture) -> PlanarMotion:
        """The motion of what comes after the joint."""
        k = joint.coordinate
        if not joint.revolute:
            step = turn(self.c, self.s, scale(joint.sign * posture.q[k], joint.place))
            return PlanarMotion(self.c, self.s, add(self.t, step))
        c, s = turn(posture.c[k], joint.sign * posture.s[k], (self.c, self.s))
        return PlanarMotion(c, s, sub(self.move(joint.place), turn(c, s, joint.place)))


@dataclass
class ChainKinematics:
    """A chain at a posture: per joint its pivot (None if prismatic) and direction; the end point."""

    joints: Sequence[PlanarJoint]
    pivots: list[Vector | None]
    directions: list[Vector | None]
    end: Vector

    def columns(self) -> list[tuple[int, Vector]]:
        """(coordinate, velocity of the end point per unit rate), joint by joint."""
        result = []
        for joint, pivot, direction in zip(self.joints, self.pivots, self.directions, strict=True):
            column = direction if pivot is None else perp(sub(self.end, pivot))
            result.append((joint.coordinate, scale(joint.sign, column)))  # type: ignore[arg-type]
        return result

    def bias(self, rates: Sequence[Scalar]) -> Vector:
        """Acceleration of the end point with all joint accelerations zero: centripetal and Coriolis terms."""
        total: Vector = (0.0, 0.0)
        omega: Scalar = 0.0
        last: Vector | None = None
        for joint, pivot, direction in zip(self.joints, self.pivots, self.directions, strict=True):
            rate = joint.sign * rates[joint.coordinate]
            if pivot is None:
                total = add(total, scale(2.0 * omega * rate, perp(direction)))  # type: ignore[arg-type]
                continue
            if last is not None:
                total = sub(total, scale(omega * omega, sub(pivot, last)))
            omega, last = omega + rate, pivot
        return total if last is None else sub(total, scale(omega * omega, sub(self.end, last)))


def chain_kinematics(joints: Sequence[PlanarJoint], point: Vector, posture: Posture) -> ChainKinematics:
    """Pivots, directions and end point of one chain."""
    motion = PlanarMotion()
    pivots: list[Vector | None] = []
    directions: list[Vector | None] = []
    for joint in joints:
        pivots.append(motion.move(joint.place) if joint.revolute else None)
        directions.append(None if joint.revolute else turn(motion.c, motion.s, joint.place))
        motion = motion.then(joint, posture)
    return ChainKinematics(joints, pivots, directions, motion.move(point))


def planar_loop(tree: Tree, closure: Closure) -> PlanarLoop:
    """The plane form of a closure. ValueError with the reason where the loop is not planar."""
    a, b = tree.body_index(closure.link_a), tree.body_index(closure.link_b)
    path_a, path_b = tree.path(a), tree.path(b)
    shared = sum(1 for x, y in zip(path_a, path_b, strict=False) if x == y)
    ancestor = path_a[shared - 1] if shared else -1
    path_a, path_b = path_a[shared:], path_b[shared:]
    basis = _plane_basis(tree, path_a + path_b, ancestor)
    points = []
    for body, point in ((a, closure.point_a), (b, closure.point_b)):
        rotation, origin = tree.zero_pose(body, ancestor)
        points.append(basis @ (rotation @ point + origin))
    chain_a = tuple(_planar_joint(tree, i, ancestor, basis) for i in path_a)
    chain_b = tuple(_planar_joint(tree, i, ancestor, basis) for i in path_b)
    point_a, point_b = (constant(p[:2]) for p in points)
    if abs(points[0][2] - points[1][2]) > 1e-6:
        raise ValueError(f"its pin is {abs(points[0][2] - points[1][2]):.3g} m apart along the loop's axis")
    places = [j.place for j in (*chain_a, *chain_b) if j.revolute] + [point_a, point_b]
    length = float(np.max(np.ptp(np.array(places), axis=0)))
    return PlanarLoop(closure.name, chain_a, chain_b, point_a, point_b, length or 1.0)


def _plane_basis(tree: Tree, bodies: list[int], ancestor: int) -> Array:
    """Rows: two in-plane axes and the normal, in the ancestor's frame; the normal is the first revolute axis."""
    axes = [(tree.bodies[i], tree.zero_pose(i, ancestor)[0] @ tree.bodies[i].axis) for i in bodies]
    normals = [axis for body, axis in axes if body.type == "revolute"]
    if not normals:
        raise ValueError("it has no revolute joint")
    normal = normals[0]
    for body, axis in axes:
        off = np.linalg.norm(np.cross(normal, axis)) if body.type == "revolute" else abs(normal @ axis)
        if off > PARALLEL:
            raise ValueError(f"joint '{body.joint}' does not move in the plane of the loop")
    first = np.eye(3)[int(np.argmin(np.abs(normal)))] if max(abs(normal)) < 1.0 else np.roll(np.abs(normal), 1)
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


def _planar_joint(tree: Tree, index: int, ancestor: int, basis: Array) -> PlanarJoint:
    body = tree.bodies[index]
    rotation, origin = tree.zero_pose(index, ancestor)
    axis = basis @ rotation @ np.array(body.axis)
    if body.type == "revolute":
        return PlanarJoint(body.coordinate, True, 1.0 if axis[2] > 0 else -1.0, constant((basis @ origin)[:2]))
    return PlanarJoint(body.coordinate, False, 1.0, constant(axis[:2]))
