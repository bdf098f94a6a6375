"""The place at which a joint that closes a loop is compared, which no choice of frames changes.

A hinge has no point along its axis, and two welded links may be cut anywhere. So the place is taken
from the axes of the neighbouring joints in the loop, where these say one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...description.model import Closure, RobotDescription
from ...ground.arrays import Array, frozen
from ...mechanism.tree import Body, Tree
from .spatial import Chain, closure_chains

Chains = tuple[Chain, Chain]
# sine of the angle between axes that count as parallel, since numbers in files are rounded
PARALLEL = 1e-6


class Line(NamedTuple):
    """Axis of a joint, or the centre of a ball joint, in the frame of a closure.

    Attributes:
        point: a point of it (3,) [m].
        direction: unit vector along it (3,); zero for a centre.
    """

    point: Array
    direction: Array

    def foot(self, other: Line) -> Array:
        """The point (3,) that is nearest to another line; of parallels, nearest to its point."""
        between = other.point - self.point
        normal = np.cross(self.direction, other.direction)
        square = float(normal @ normal)
        if square > PARALLEL**2:
            along = float(np.cross(between, other.direction) @ normal) / square
        else:
            along = float(between @ self.direction)
        foot: Array = self.point + along * self.direction
        return foot

    def is_parallel(self, other: Line) -> bool:
        """Whether the feet of two lines are not determined."""
        both = norm(self.direction) * norm(other.direction)
        return both > 0.0 and norm(np.cross(self.direction, other.direction)) <= PARALLEL


def placed(tree: Tree, robot: RobotDescription, closure: Closure) -> Closure:
    """The closure with its ends, which coincide where the loop is closed, moved to its place."""
    if closure.kind not in ("axis", "frame"):
        return closure
    lines = _neighbours(tree, robot, closure_chains(tree, closure))
    move = _along_axis(lines)
    if closure.kind == "frame":
        move = _between(lines)
    return replace(
        closure,
        point_a=frozen(closure.point_a + closure.rotation_a @ move),
        point_b=frozen(closure.point_b + closure.rotation_b @ move),
    )


def _along_axis(lines: Sequence[Line]) -> Array:
    """The mean of the points of the z axis that are nearest to the neighbours (3,) [m]."""
    axis = Line(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    feet = [axis.foot(line) for line in lines if not axis.is_parallel(line)]
    return _mean(feet)


def _between(lines: Sequence[Line]) -> Array:
    """The middle of the common perpendicular of the neighbours (3,) [m]."""
    origin = Line(np.zeros(3), np.zeros(3))
    feet = [line.foot(origin) for line in lines]
    if len(lines) == 2 and not lines[0].is_parallel(lines[1]):
        feet = [lines[0].foot(lines[1]), lines[1].foot(lines[0])]
    return _mean(feet)


def _mean(points: Sequence[Array]) -> Array:
    """The mean of some points (3,), zero without any."""
    total: Array = np.zeros(3)
    for point in points:
        total = total + point / len(points)
    return total


def _neighbours(tree: Tree, robot: RobotDescription, chains: Chains) -> list[Line]:
    """Axes of the joints on both links of a closure, in its frame; slides have none."""
    lines: list[Line] = []
    for chain, other in (chains, chains[::-1]):
        if chain.bodies:
            body = chain.bodies[-1]
            origin, axis = np.zeros(3), np.array(body.axis)
        elif other.bodies:
            body = other.bodies[0]
            origin, axis = np.array(body.translation), np.array(body.rotation) @ np.array(body.axis)
        else:
            continue
        direction = _direction(tree, robot, body, axis)
        if direction is not None:
            rotation: Array = np.array(chain.rotation).T
            point = rotation @ (origin - np.array(chain.point))
            lines.append(Line(point, rotation @ direction))
    return lines


def _direction(tree: Tree, robot: RobotDescription, body: Body, axis: Array) -> Array | None:
    """The direction of a joint's line, zero for a ball joint; None if it has no line."""
    if body.coordinate in turns_of(tree, robot, "ball"):
        return np.zeros(3)
    if not body.is_revolute or body.coordinate in turns_of(tree, robot, "free"):
        return None
    return axis


def turns_of(tree: Tree, robot: RobotDescription, kind: str) -> frozenset[int]:
    """The angular coordinates of all ball joints, or of all free joints."""
    coordinates: set[int] = set()
    for joint, turns in zip(robot.freely_turning, tree.turns, strict=True):
        if joint.type == kind:
            coordinates.update(turns)
    return frozenset(coordinates)
