"""Spatial loops: two chains from a common link, and the equations that tie their ends.

All vectors are in the frame of that link, whose own motion drops out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import Scalar, Scalars
from ...algebra.transform import IDENTITY, compose
from ...algebra.vector import (
    IDENTITY3,
    ZERO3,
    Rotation,
    Vector,
    add,
    cross,
    dot,
    matmul,
    scale,
    sub,
    transpose,
)
from ...description.model import Closure
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ...mechanism.joint_transform import Column, jacobian_column, through_joint
from ...mechanism.tree import Body, Tree, floats, rows
from .equations import Linearised, LoopEquations, Row

PARALLEL = 1e-9  # sine of the angle below which two axes count as parallel in distances
# pairs (axis of a, axis of b) that stay at right angles, by kind
_PAIRS = {
    "point": (),
    "axis": ((0, 2), (1, 2)),
    "frame": (),
}
# axes that must not be opposed
_PARALLEL_AXES = {
    "point": (),
    "axis": (2,),
    "frame": (0, 1, 2),
}
_SIZES = {"point": 3, "axis": 5, "frame": 6}


@dataclass(frozen=True)
class Chain:
    """Bodies from a link outward, and a frame on the last one.

    Attributes:
        bodies: the bodies, the nearest first.
        point: origin of the frame on the last body, or on the link itself if there is none [m].
        rotation: rotation of that frame.
    """

    bodies: tuple[Body, ...]
    point: Vector
    rotation: Rotation = IDENTITY3

    @property
    def coordinates(self) -> frozenset[int]:
        """Coordinates of its joints."""
        return frozenset(body.coordinate for body in self.bodies)

    @property
    def offsets(self) -> list[float]:
        """Distances [m] from joint to joint and to the frame, at zero."""
        vectors = [*(body.translation for body in self.bodies), self.point]
        return [norm(vector) for vector in vectors]

    def at(self, configuration: Configuration) -> ChainState:
        """The chain at a configuration."""
        pose = IDENTITY
        joints: list[ChainJoint] = []
        for body in self.bodies:
            pose, axis = through_joint(pose, body, configuration)
            _, origin = pose
            joints.append(ChainJoint(body, axis, origin))
        rotation, end = compose(pose, (self.rotation, self.point))
        return ChainState(joints, end, rotation)


class ChainJoint(NamedTuple):
    """A joint of a chain at a configuration.

    Attributes:
        body: the body that it carries.
        axis: its axis (3,).
        origin: origin of the body, after the joint (3,) [m].
    """

    body: Body
    axis: Vector
    origin: Vector


class ChainState(NamedTuple):
    """A chain at a configuration, in the frame of the link where it starts.

    Attributes:
        joints: its joints.
        end: origin of the frame at the end (3,) [m].
        rotation: rotation of that frame.
    """

    joints: list[ChainJoint]
    end: Vector
    rotation: Rotation

    def relative_to(self, point: Vector) -> ChainState:
        """The same chain, with places relative to another origin."""
        joints = [joint._replace(origin=sub(joint.origin, point)) for joint in self.joints]
        return ChainState(joints, sub(self.end, point), self.rotation)

    def joint_of(self, coordinate: int) -> ChainJoint | None:
        """The joint of a coordinate; None if it is not in the chain."""
        for joint in self.joints:
            if joint.body.coordinate == coordinate:
                return joint
        return None

    def columns(self) -> dict[int, Column]:
        """Velocity of the end per unit rate, by coordinate."""
        columns: dict[int, Column] = {}
        for body, axis, origin in self.joints:
            columns[body.coordinate] = jacobian_column(body, axis, origin, self.end)
        return columns

    def velocity(self, rates: Scalars) -> Column:
        """Linear velocity of the end and angular velocity, from s'."""
        linear: Vector = ZERO3
        angular: Vector = ZERO3
        for k, (v, w) in self.columns().items():
            linear = add(linear, scale(rates[k], v))
            angular = add(angular, scale(rates[k], w))
        return linear, angular

    def bias(self, rates: Scalars) -> Column:
        """Linear acceleration of the end and angular acceleration, from s' with s'' = 0."""
        omega: Vector = ZERO3
        alpha: Vector = ZERO3
        accel: Vector = ZERO3
        last: Vector = ZERO3
        for body, axis, origin in self.joints:
            accel = add(accel, _carried(omega, alpha, sub(origin, last)))
            last = origin
            rate = scale(rates[body.coordinate], axis)
            if body.is_revolute:
                alpha = add(alpha, cross(omega, rate))
                omega = add(omega, rate)
            else:
                accel = add(accel, scale(2.0, cross(omega, rate)))
        last_arm = sub(self.end, last)
        return add(accel, _carried(omega, alpha, last_arm)), alpha


def _carried(omega: Vector, alpha: Vector, arm: Vector) -> Vector:
    """Acceleration of the tip of an arm on a body, relative to the body's origin."""
    tangential = cross(alpha, arm)
    centripetal = cross(omega, cross(omega, arm))
    return add(tangential, centripetal)


def closure_chains(tree: Tree, closure: Closure) -> tuple[Chain, Chain]:
    """The two chains of a closure, from the last link they share."""
    a = tree.body_index(closure.link_a)
    b = tree.body_index(closure.link_b)
    path_a, path_b, _ = tree.branches(a, b)
    return (
        _chain(tree, path_a, closure.point_a, closure.rotation_a),
        _chain(tree, path_b, closure.point_b, closure.rotation_b),
    )


def _chain(tree: Tree, path: Sequence[int], point: Array, rotation: Array) -> Chain:
    bodies = tuple(tree.bodies[i] for i in path)
    return Chain(bodies, floats(point), rows(rotation))


def chains_length(*chains: Chain) -> float:
    """A typical length of a loop [m]: its longest stretched chain; 1 if it has no length."""
    return max(_stretched_length(chain) for chain in chains) or 1.0


def _stretched_length(chain: Chain) -> float:
    *between_joints, to_frame = chain.offsets
    return sum(between_joints) + to_frame


class _Line(NamedTuple):
    """A joint axis in space, or a point: a line with direction zero."""

    point: Array
    direction: Array

    def distance(self, other: _Line) -> float:
        """Shortest distance to another line [m]."""
        between = other.point - self.point
        normal = np.cross(self.direction, other.direction)
        size = norm(normal)
        if size > PARALLEL:
            return abs(float(between @ normal)) / size
        along = self.direction
        if not along.any():
            along = other.direction
        across = between - (between @ along) * along
        return norm(across)


def extent_of(states: Sequence[ChainState]) -> float:
    """Largest distance [m] between the axes of revolute joints and the ends of chains.

    Args:
        states: chains from one link, floats.
    """
    lines: list[_Line] = []
    for state in states:
        lines.append(_Line(np.array(state.end, dtype=float), np.zeros(3)))
        for joint in state.joints:
            if joint.body.is_revolute:
                origin = np.array(joint.origin, dtype=float)
                lines.append(_Line(origin, np.array(joint.axis, dtype=float)))
    return max(a.distance(b) for a, b in combinations(lines, 2))


class SpatialClosure(LoopEquations):
    """Equations that the end points coincide.

    For the kind axis their z axes are parallel too, for the kind frame all axes.
    """

    def __init__(self, name: str, kind: str, a: Chain, b: Chain) -> None:
        self.name = name
        self.kind = kind
        self.a = a
        self.b = b
        self.pairs = _PAIRS[kind]
        self.length = chains_length(a, b)
        self.involved = (a.coordinates | b.coordinates,) * _SIZES[kind]

    def linearise(self, configuration: Configuration) -> Linearised:
        """Difference of the end points, then the equations of orientation.

        These are cosines of axes at right angles, or the rotation vector between the frames.
        """
        a = self.a.at(configuration)
        b = self.b.at(configuration)
        gap = sub(a.end, b.end)
        residual = list(scale(1.0 / self.length, gap))
        normals: list[Vector] = []
        for i, j in self.pairs:
            x = transpose(a.rotation)[i]
            y = transpose(b.rotation)[j]
            residual.append(dot(x, y))
            normals.append(cross(x, y))
        if self.kind == "frame":
            residual += rotation_between(a.rotation, b.rotation)
            normals += IDENTITY3
        jacobian: list[Row] = [{} for _ in residual]
        for sign, state in ((1.0, a), (-1.0, b)):
            for k, (linear, angular) in state.columns().items():
                translation = scale(1.0 / self.length, linear)
                turns = [dot(angular, normal) for normal in normals]
                for row, entry in zip(jacobian, (*translation, *turns), strict=True):
                    row[k] = sign * entry
        return Linearised(jacobian, residual)

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """Differences of the ends' accelerations with joint accelerations zero."""
        a = self.a.at(configuration)
        b = self.b.at(configuration)
        accel_a, alpha_a = a.bias(rates)
        accel_b, alpha_b = b.bias(rates)
        accel = sub(accel_a, accel_b)
        result: list[Scalar] = list(scale(1.0 / self.length, accel))
        # at a closed configuration the frames turn together, so no other term remains
        if self.kind == "frame":
            result += sub(alpha_a, alpha_b)
        if self.pairs:
            _, omega_a = a.velocity(rates)
            _, omega_b = b.velocity(rates)
            for i, j in self.pairs:
                x = transpose(a.rotation)[i]
                y = transpose(b.rotation)[j]
                x_turns = cross(cross(omega_a, x), y)
                y_turns = cross(x, cross(omega_b, y))
                turning = add(x_turns, y_turns)
                of_alpha = dot(sub(alpha_a, alpha_b), cross(x, y))
                of_omega = dot(sub(omega_a, omega_b), turning)
                result.append(of_alpha + of_omega)
        return result

    def extent(self, configuration: Configuration) -> float:
        """Largest distance between axes and pin [m]."""
        return extent_of([self.a.at(configuration), self.b.at(configuration)])

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Joint origins and ends of both chains, and the orientations of the ends."""
        marks: list[Scalar] = []
        for chain in (self.a, self.b):
            state = chain.at(configuration)
            origins = [joint.origin for joint in state.joints]
            for vector in (*origins, state.end, *state.rotation):
                marks += vector
        return marks

    def guards(self, configuration: Configuration) -> list[Scalar]:
        """Cosines between axes that must be parallel; negative if they are opposed."""
        axes = _PARALLEL_AXES[self.kind]
        if not axes:
            return []
        a = transpose(self.a.at(configuration).rotation)
        b = transpose(self.b.at(configuration).rotation)
        return [dot(a[i], b[i]) for i in axes]


def rotation_between(a: Rotation, b: Rotation) -> Vector:
    """2 tan(angle / 2) times the axis of the rotation from b to a.

    At zero its rate is the difference of the angular velocities. It vanishes for the identity only,
    so Newton's method does not end at half a turn. Sines and cosines of single axes would.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matmul(a, transpose(b))
    factor = 2.0 / (1.0 + xx + yy + zz)
    axis = (zy - yz, xz - zx, yx - xy)
    return scale(factor, axis)
