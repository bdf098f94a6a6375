"""The place at which both ends of a closing joint are compared, whatever frames a file chose.

A hinge may be compared at any point of its axis, and two welded links may be cut anywhere. So the
place is taken from the axes of the neighbouring joints in the loop, if they determine one.
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
# sine of the angle up to which axes count as parallel, since numbers in files are rounded
PARALLEL = 1e-6


class Line(NamedTuple):
    """Axis of a joint, or the centre of a ball joint, in the frame of a closure.

    Attributes:
        point: a point (3,) of the axis, or the centre [m].
        direction: unit vector (3,) along the axis; zero for a centre.
    """

    point: Array
    direction: Array

    def foot(self, other: Line) -> Array:
        """The point (3,) of this line nearest to another one, or to its `point` if parallel [m]."""
        between = other.point - self.point
        normal = np.cross(self.direction, other.direction)
        square = normal @ normal
        if square > PARALLEL**2:
            along = np.cross(between, other.direction) @ normal / square
        else:
            along = between @ self.direction
        foot: Array = self.point + along * self.direction
        return foot

    def is_parallel(self, other: Line) -> bool:
        """Whether two axes are parallel, so that no point of them is nearest; a centre never is."""
        are_axes = norm(self.direction) * norm(other.direction) > 0.0
        sine = norm(np.cross(self.direction, other.direction))
        return are_axes and sine <= PARALLEL


def placed(tree: Tree, robot: RobotDescription, closure: Closure) -> Closure:
    """The closure with both ends moved to its place; they still coincide in a closed loop."""
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
    """The mean (3,) of the points of the z axis that are nearest to the neighbours [m]."""
    axis = Line(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    feet = [axis.foot(line) for line in lines if not axis.is_parallel(line)]
    return _mean(feet)


def _between(lines: Sequence[Line]) -> Array:
    """The middle (3,) of the common perpendicular of two neighbours, or else their mean [m]."""
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
        elif other.bodies:  # the link carries the first joint of the other side
            body = other.bodies[0]
            origin = np.array(body.translation)
            axis = np.array(body.rotation) @ np.array(body.axis)
        else:
            continue
        direction = _direction(tree, robot, body, axis)
        if direction is not None:
            rotation: Array = np.array(chain.rotation).T
            point = rotation @ (origin - np.array(chain.point))
            lines.append(Line(point, rotation @ direction))
    return lines


def _direction(tree: Tree, robot: RobotDescription, body: Body, axis: Array) -> Array | None:
    """The direction (3,) of a joint's line, zero for a ball joint; None if it has no line."""
    if body.coordinate in turns_of(tree, robot, "ball"):
        return np.zeros(3)
    if not body.is_revolute or body.coordinate in turns_of(tree, robot, "free"):
        return None
    return axis


def turns_of(tree: Tree, robot: RobotDescription, kind: str) -> frozenset[int]:
    """The angular coordinates of all ball joints, or of all free joints, by the kind of joint."""
    coordinates: set[int] = set()
    for joint, turns in zip(robot.freely_turning, tree.turns, strict=True):
        if joint.type == kind:
            coordinates.update(turns)
    return frozenset(coordinates)
