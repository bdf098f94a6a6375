"""A planar loop: two chains of parallel revolute and in-plane prismatic joints that meet in a pin.

Everything is written in the plane of the loop, in the frame of the link where the two chains part.
A joint is kept as it stands with all coordinates at zero (pivot or direction), so a chain is a
product of plane motions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...algebra.scalar import Scalar
from ...algebra.vector import Vector, add, constant, perp, scale, sub, turn
from ...description.model import Closure
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Body, Tree
from .equations import Linearised, LoopEquations, Row

_End = tuple[int, Array, Array]  # body, point and rotation on it
Turns = tuple[tuple[int, float], ...]  # (coordinate, +1 or -1)
FEW_DIGITS = 5e-3  # [rad] 1.57 and 3.14 are nearer than this to what they stand for
# [m] along the loop's axis up to which two points count as one: printed numbers are rounded
APART = 1e-6
PARALLEL = 1e-9  # sine of the angle up to which two constant axes count as parallel


@dataclass(frozen=True)
class PlanarJoint:
    """`place`: pivot [m] of a revolute joint, unit direction of a prismatic one, at zero; `sign` of the axis."""

    coordinate: int
    revolute: bool
    sign: float
    place: Vector


@dataclass(frozen=True)
class PlanarGeometry:
    """Both chains of a planar loop and their end points at zero."""

    chain_a: tuple[PlanarJoint, ...]
    chain_b: tuple[PlanarJoint, ...]
    point_a: Vector
    point_b: Vector

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

    def then(self, joint: PlanarJoint, configuration: Configuration) -> PlanarMotion:
        """The motion of what comes after the joint."""
        k = joint.coordinate
        if not joint.revolute:
            step = turn(self.c, self.s, scale(joint.sign * configuration.q[k], joint.place))
            return PlanarMotion(self.c, self.s, add(self.t, step))
        c, s = turn(configuration.c[k], joint.sign * configuration.s[k], (self.c, self.s))
        return PlanarMotion(c, s, sub(self.move(joint.place), turn(c, s, joint.place)))


@dataclass
class ChainKinematics:
    """A chain at a configuration: per joint its pivot (None if prismatic) and direction; the end point."""

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


def chain_kinematics(
    joints: Sequence[PlanarJoint], point: Vector, configuration: Configuration
) -> ChainKinematics:
    """Pivots, directions and end point of one chain."""
    motion = PlanarMotion()
    pivots: list[Vector | None] = []
    directions: list[Vector | None] = []
    for joint in joints:
        pivots.append(motion.move(joint.place) if joint.revolute else None)
        directions.append(None if joint.revolute else turn(motion.c, motion.s, joint.place))
        motion = motion.then(joint, configuration)
    return ChainKinematics(joints, pivots, directions, motion.move(point))


class PlanarPin(LoopEquations):
    """The two end points coincide: two equations."""

    def __init__(self, name: str, geometry: PlanarGeometry) -> None:
        self.name, self.geometry = name, geometry
        places = [j.place for j in geometry.joints if j.revolute] + [
            geometry.point_a,
            geometry.point_b,
        ]
        self.length = float(np.max(np.ptp(np.array(places), axis=0))) or 1.0
        self.involved = (frozenset(j.coordinate for j in geometry.joints),) * 2

    def chains(self, configuration: Configuration) -> tuple[ChainKinematics, ChainKinematics]:
        """Both chains at a configuration."""
        g = self.geometry
        return chain_kinematics(g.chain_a, g.point_a, configuration), chain_kinematics(
            g.chain_b, g.point_b, configuration
        )

    def linearise(self, configuration: Configuration) -> Linearised:
        """Difference of the end points."""
        a, b = self.chains(configuration)
        unit = 1.0 / self.length
        rows: list[Row] = [{}, {}]
        for sign, chain in ((unit, a), (-unit, b)):
            for coordinate, column in chain.columns():
                for row, value in zip(rows, column, strict=True):
                    row[coordinate] = sign * value
        return Linearised(rows, list(scale(unit, sub(a.end, b.end))))

    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:
        """Difference of the end points' accelerations with joint accelerations zero."""
        a, b = self.chains(configuration)
        return list(scale(1.0 / self.length, sub(a.bias(rates), b.bias(rates))))

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Pivots and ends."""
        return [
            x
            for chain in self.chains(configuration)
            for p in (*chain.pivots, chain.end)
            if p is not None
            for x in p
        ]


class AngleSum(LoopEquations):
    """offset + sum of +-angles = 0 modulo a turn: the end links of a planar loop, or two bars, stay parallel."""

    length = 1.0

    def __init__(self, name: str, turns: Turns, offset: float) -> None:
        sums: dict[int, float] = {}
        for k, sign in turns:
            sums[k] = sums.get(k, 0.0) + sign
        self.name, self.offset = name, offset
        self.turns = tuple((k, sign) for k, sign in sums.items() if sign)
        self.involved = (frozenset(k for k, _ in self.turns),)

    def _sum(self, configuration: Configuration) -> tuple[Scalar, Scalar]:
        """Cosine and sine of the sum."""
        c, s = constant((math.cos(self.offset), math.sin(self.offset)))
        for k, sign in self.turns:
            c, s = turn(configuration.c[k], sign * configuration.s[k], (c, s))
        return c, s

    def linearise(self, configuration: Configuration) -> Linearised:
        """A constant row; the residual is the sine of the sum."""
        return Linearised([dict(self.turns)], [self._sum(configuration)[1]])

    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:  # noqa: ARG002
        """None: the relation between the angles is linear."""
        return [0.0]

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """The angles themselves."""
        return [x for k, _ in self.turns for x in (configuration.c[k], configuration.s[k])]

    def gaps(self, configuration: Configuration) -> list[float]:
        """The angle itself: its sine vanishes at half a turn too, where a search would stay."""
        c, s = self._sum(configuration)
        return [math.atan2(float(s), float(c))]

    def guards(self, configuration: Configuration) -> list[Scalar]:
        """Parallel, not opposed."""
        return [self._sum(configuration)[0]]


def planar_equations(tree: Tree, closure: Closure) -> list[LoopEquations]:
    """The equations of a closure whose loop is planar.

    ValueError with the reason where it is not.
    """
    one, other = _ordered_ends(tree, closure)
    path_a, path_b, ancestor = tree.branches(one[0], other[0])
    basis = plane_basis(tree, path_a + path_b, ancestor)
    ends = []
    for body, point, rotation in (one, other):
        turned, origin = tree.zero_pose(body, ancestor)
        ends.append((basis @ (turned @ point + origin), basis @ turned @ rotation))
    (end_a, frame_a), (end_b, frame_b) = ends
    gap = abs(float(end_a[2] - end_b[2]))
    if gap > APART:
        size = max(float(np.linalg.norm(end)) for end in (end_a, end_b))
        hint = (
            " (angles of few digits do that: 1.57 in place of pi/2)"
            if gap < FEW_DIGITS * size
            else ""
        )
        raise ValueError(f"its ends are {gap:.3g} m apart along the loop's axis{hint}")
    geometry = PlanarGeometry(
        tuple(_planar_joint(tree, i, ancestor, basis) for i in path_a),
        tuple(_planar_joint(tree, i, ancestor, basis) for i in path_b),
        constant(end_a[:2]),
        constant(end_b[:2]),
    )
    equations: list[LoopEquations] = [PlanarPin(closure.name, geometry)]
    if closure.kind == "axis" and np.linalg.norm(np.cross(frame_a[:, 2], frame_b[:, 2])) > PARALLEL:
        raise ValueError("its two axes are not parallel")
    if closure.kind == "axis" and abs(frame_a[2, 2]) < 1.0 - PARALLEL:
        raise ValueError("its axis is not the loop's")
    if closure.kind == "frame":
        if np.linalg.norm(frame_a[2] - frame_b[2]) > PARALLEL:
            raise ValueError("its frames are tilted out of the loop's plane against each other")
        apart = frame_a @ frame_b.T  # a turn about the normal
        offset = math.atan2(apart[1, 0], apart[0, 0])
        turns = [(j.coordinate, j.sign) for j in geometry.chain_a if j.revolute]
        turns += [(j.coordinate, -j.sign) for j in geometry.chain_b if j.revolute]
        equations.append(AngleSum(closure.name, tuple(turns), offset))
    return equations


def _ordered_ends(tree: Tree, closure: Closure) -> tuple[_End, _End]:
    """The end with more joints before it first; of equal ones, that with the earlier coordinate.

    The first joint's axis and the order of the ends say what counterclockwise is: that must not
    depend on the order in which a file names the ends, keys of a mapping.
    """
    a: _End = (tree.body_index(closure.link_a), closure.point_a, closure.rotation_a)
    b: _End = (tree.body_index(closure.link_b), closure.point_b, closure.rotation_b)
    path_a, path_b, _ = tree.branches(a[0], b[0])

    def rank(path: list[int]) -> tuple[int, int]:
        return -len(path), min((tree.bodies[i].coordinate for i in path), default=0)

    return (a, b) if rank(path_a) <= rank(path_b) else (b, a)


def _outside(axes: Sequence[tuple[Body, Array]], normal: Array) -> list[str]:
    """Joints that do not move in the plane of this normal."""
    return [
        body.joint
        for body, axis in axes
        if (
            np.linalg.norm(np.cross(normal, axis))
            if body.type == "revolute"
            else abs(normal @ axis)
        )
        > PARALLEL
    ]


def _require_one_direction(
    axes: Sequence[tuple[Body, Array]], outside: Sequence[Sequence[str]]
) -> None:
    """Raise where two joints turn about different axes and nothing tells which of them is the wrong one."""
    turning = [(body.joint, axis) for body, axis in axes if body.type == "revolute"]
    if len(turning) == 2 and [*outside[0], *outside[1]] == [turning[1][0], turning[0][0]]:
        ways = " and ".join(f"'{name}' about [{_told(axis)}]" for name, axis in turning)
        raise ValueError(
            f"joints turn about different axes, {ways}; mend the rpy of one's origin, or its axis"
        )


def _told(axis: Array) -> str:
    return ", ".join(f"{x + 0.0:.3g}" for x in axis.round(12))


def _and(names: Sequence[str]) -> str:
    return " and ".join(f"'{name}'" for name in names)


def plane_basis(tree: Tree, bodies: list[int], ancestor: int) -> Array:
    """Rows: two in-plane axes and the normal, in the ancestor's frame; the normal is the first revolute axis."""
    axes = [(tree.bodies[i], tree.zero_pose(i, ancestor)[0] @ tree.bodies[i].axis) for i in bodies]
    normals = [axis for body, axis in axes if body.type == "revolute"]
    if not normals:
        raise ValueError("it has no revolute joint")
    outside = [_outside(axes, normal) for normal in normals]
    if outside[0]:
        _require_one_direction(axes, outside)
        most = min(range(len(normals)), key=lambda k: len(outside[k]))
        inside = [body.joint for body, _ in axes if body.joint not in outside[most]]
        does = "joint {} does" if len(outside[most]) == 1 else "joints {} do"
        raise ValueError(
            f"{does.format(_and(outside[most]))} not move in the plane of {_and(inside)}, with axes"
            f" [{_told(normals[most])}]; mend the rpy of its origin, or its axis"
        )
    normal = normals[0]
    first = (
        np.eye(3)[int(np.argmin(np.abs(normal)))]
        if max(abs(normal)) < 1.0
        else np.roll(np.abs(normal), 1)
    )
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


def _planar_joint(tree: Tree, index: int, ancestor: int, basis: Array) -> PlanarJoint:
    body = tree.bodies[index]
    rotation, origin = tree.zero_pose(index, ancestor)
    axis = basis @ rotation @ np.array(body.axis)
    if body.type == "revolute":
        return PlanarJoint(
            body.coordinate, True, 1.0 if axis[2] > 0 else -1.0, constant((basis @ origin)[:2])
        )
    return PlanarJoint(body.coordinate, False, 1.0, constant(axis[:2]))
