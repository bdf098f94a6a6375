"""Loops in space: two chains from the link where they part, and the equations that tie their ends.

Everything is written in the frame of that link, whose own motion does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...algebra.scalar import Scalar
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
from ...mechanism.configuration import Configuration
from ...mechanism.joint_transform import Column, jacobian_column, through_joint
from ...mechanism.tree import Body, Tree, rows
from .equations import Linearised, LoopEquations, Row


@dataclass(frozen=True)
class Chain:
    """Bodies from a link outward, and a frame on the last one (on the link itself if there are none)."""

    bodies: tuple[Body, ...]
    point: Vector
    rotation: Rotation = IDENTITY3

    @property
    def coordinates(self) -> frozenset[int]:
        """Coordinates of its joints."""
        return frozenset(b.coordinate for b in self.bodies)

    def at(self, configuration: Configuration) -> ChainState:
        """The chain at a configuration."""
        pose = IDENTITY
        axes: list[Vector] = []
        origins: list[Vector] = []
        for body in self.bodies:
            pose, axis = through_joint(pose, body, configuration)
            axes.append(axis)
            origins.append(pose[1])
        rotation, end = compose(pose, (self.rotation, self.point))
        return ChainState(self, axes, origins, end, rotation)


@dataclass
class ChainState:
    """A chain at a configuration, in the frame of the link where it starts.

    Attributes:
        chain: the chain.
        axes: axis of each joint.
        origins: origin of each body, after its joint [m].
        end: origin of the frame at the end [m].
        rotation: rotation of that frame.
    """

    chain: Chain
    axes: list[Vector]
    origins: list[Vector]
    end: Vector
    rotation: Rotation

    def columns(self) -> dict[int, Column]:
        """Velocity of the end per unit rate, by coordinate."""
        columns: dict[int, Column] = {}
        for body, axis, origin in zip(self.chain.bodies, self.axes, self.origins, strict=True):
            columns[body.coordinate] = jacobian_column(body, axis, origin, self.end)
        return columns

    def velocity(self, rates: Sequence[Scalar]) -> tuple[Vector, Vector]:
        """Linear velocity of the end and angular velocity."""
        linear, angular = ZERO3, ZERO3
        for k, (v, w) in self.columns().items():
            linear, angular = add(linear, scale(rates[k], v)), add(angular, scale(rates[k], w))
        return linear, angular

    def bias(self, rates: Sequence[Scalar]) -> tuple[Vector, Vector]:
        """Linear acceleration of the end and angular acceleration with all joint accelerations zero."""
        omega, alpha, accel = ZERO3, ZERO3, ZERO3
        last = ZERO3
        for body, axis, origin in zip(self.chain.bodies, self.axes, self.origins, strict=True):
            accel = add(accel, _carried(omega, alpha, sub(origin, last)))
            last = origin
            step = scale(rates[body.coordinate], axis)
            if body.type == "revolute":
                alpha, omega = add(alpha, cross(omega, step)), add(omega, step)
            else:
                accel = add(accel, scale(2.0, cross(omega, step)))
        return add(accel, _carried(omega, alpha, sub(self.end, last))), alpha


def _carried(omega: Vector, alpha: Vector, arm: Vector) -> Vector:
    return add(cross(alpha, arm), cross(omega, cross(omega, arm)))


def closure_chains(tree: Tree, closure: Closure) -> tuple[Chain, Chain]:
    """The two chains of a closure, from the last link they share."""
    a, b = tree.body_index(closure.link_a), tree.body_index(closure.link_b)
    path_a, path_b, _ = tree.branches(a, b)
    return (
        Chain(_bodies(tree, path_a), tuple(map(float, closure.point_a)), rows(closure.rotation_a)),
        Chain(_bodies(tree, path_b), tuple(map(float, closure.point_b)), rows(closure.rotation_b)),
    )


def _bodies(tree: Tree, path: list[int]) -> tuple[Body, ...]:
    return tuple(tree.bodies[i] for i in path)


def chains_length(*chains: Chain) -> float:
    """A length [m] typical of the loop: the farthest any origin or end is from the start, at zero."""
    sizes = [1e-3]
    for chain in chains:
        total = sum(
            float(np.linalg.norm(np.array(b.translation, dtype=float))) for b in chain.bodies
        )
        sizes.append(total + float(np.linalg.norm(np.array(chain.point, dtype=float))))
    return max(sizes)


# pairs (column of the rotation of a, column of the rotation of b) that stay at right angles
_PAIRS = {"point": (), "axis": ((0, 2), (1, 2)), "frame": ()}
_SIZES = {"point": 3, "axis": 5, "frame": 6}


class SpatialClosure(LoopEquations):
    """The ends' points coincide; for kind axis their z axes, for kind frame all axes are parallel."""

    def __init__(self, name: str, kind: str, a: Chain, b: Chain) -> None:
        self.name, self.kind, self.a, self.b = name, kind, a, b
        self.pairs = _PAIRS[kind]
        self.length = chains_length(a, b)
        self.involved = (a.coordinates | b.coordinates,) * _SIZES[kind]

    def linearise(self, configuration: Configuration) -> Linearised:
        """Difference of the end points, then cosines of axes at right angles, or the turn between the frames."""
        a, b = self.a.at(configuration), self.b.at(configuration)
        residual = list(scale(1.0 / self.length, sub(a.end, b.end)))
        normals: list[Vector] = []
        for i, j in self.pairs:
            x, y = transpose(a.rotation)[i], transpose(b.rotation)[j]
            residual.append(dot(x, y))
            normals.append(cross(x, y))
        if self.kind == "frame":
            residual += _turn_between(a.rotation, b.rotation)
            normals += IDENTITY3
        rows_: list[Row] = [{} for _ in residual]
        for sign, state in ((1.0, a), (-1.0, b)):
            for k, (linear, angular) in state.columns().items():
                parts = (*scale(1.0 / self.length, linear), *(dot(angular, n) for n in normals))
                for row, part in zip(rows_, parts, strict=True):
                    row[k] = sign * part
        return Linearised(rows_, residual)

    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:
        """Differences of the ends' accelerations with joint accelerations zero."""
        a, b = self.a.at(configuration), self.b.at(configuration)
        (accel_a, alpha_a), (accel_b, alpha_b) = a.bias(rates), b.bias(rates)
        result: list[Scalar] = list(scale(1.0 / self.length, sub(accel_a, accel_b)))
        if (
            self.kind == "frame"
        ):  # at a closed configuration the frames turn together, so no other term is left
            result += sub(alpha_a, alpha_b)
        if self.pairs:
            omega_a, omega_b = a.velocity(rates)[1], b.velocity(rates)[1]
            for i, j in self.pairs:
                x, y = transpose(a.rotation)[i], transpose(b.rotation)[j]
                turning = add(cross(cross(omega_a, x), y), cross(x, cross(omega_b, y)))
                result.append(
                    dot(sub(alpha_a, alpha_b), cross(x, y)) + dot(sub(omega_a, omega_b), turning)
                )
        return result

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Joint origins and ends of both chains, and how the ends lie."""
        states = [chain.at(configuration) for chain in (self.a, self.b)]
        return [
            x for state in states for v in (*state.origins, state.end, *state.rotation) for x in v
        ]

    def guards(self, configuration: Configuration) -> list[Scalar]:
        """Axes that the equations make parallel must not be opposed."""
        if self.kind == "point":
            return []
        a, b = (transpose(chain.at(configuration).rotation) for chain in (self.a, self.b))
        return [dot(a[i], b[i]) for i in ((2,) if self.kind == "axis" else (0, 1, 2))]


def _turn_between(a: Rotation, b: Rotation) -> Vector:
    """2 tan(angle / 2) times the axis of the turn from b to a: its rate is the difference of angular velocities at 0.

    Unlike sines and cosines of single axes it vanishes for no other turn, so Newton does not end
    half round.
    """
    turn = matmul(a, transpose(b))
    factor = 2.0 / (1.0 + turn[0][0] + turn[1][1] + turn[2][2])
    return scale(
        factor, (turn[2][1] - turn[1][2], turn[0][2] - turn[2][0], turn[1][0] - turn[0][1])
    )
