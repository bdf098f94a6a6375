"""Correction of loops whose hinges turn about one point up to the printed digits of their file.

Such a loop has more equations than it needs: distances from the common point stay by themselves.
If rounded numbers let axes miss the point by a little, these equations would hold the loop fast.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...description.model import Closure, RobotDescription
from ...ground.arrays import Array, frozen
from ...mechanism.tree import Tree, build_tree
from ..constraints.plane import ROUNDED
from .loop import DrawnLoop, loops_by_hinge, notes_on, with_changed

# least share of the axes that is across any direction: nearly parallel ones meet in no point
LEAST_ACROSS = 1e-2
EXACT = 1e-13  # share of a loop's extent that is the rounding of numbers
Pose = tuple[Array, Array]


class _Line(NamedTuple):
    """A point (3,) [m] of a hinge's axis, and its direction (3,), at zero in base axes."""

    point: Array
    direction: Array

    def move_to(self, centre: Array) -> Array:
        """The shortest way (3,) from the axis to a point [m]."""
        way = centre - self.point
        across: Array = way - float(way @ self.direction) * self.direction
        return across


def with_common_centres(robot: RobotDescription) -> RobotDescription:
    """The description in which loops that are spherical within `ROUNDED` are exactly spherical.

    Joints are moved so that their axes meet in one point, together with the links that they carry.
    Notes give the joints and distances.

    Args:
        robot: a description; not changed.
    """
    tree = build_tree(robot)
    loops: list[_Loop] = []
    for closure in robot.closures:
        loop = _Loop(robot, tree, closure.name)
        if loop.has_hinges_only and _centre([loop]) is not None:
            loops.append(loop)
    for group in loops_by_hinge(loops):
        centre = _centre(group)
        if centre is None or all(loop.is_spherical(centre, EXACT) for loop in group):
            continue
        robot = _with_hinges_through(robot, tree, group, centre)
        for loop in group:
            robot = _with_ends_on_sphere(robot, loop.closure.name, centre)
    return robot


class _Loop(DrawnLoop):
    """A loop that may be spherical."""

    def __init__(self, robot: RobotDescription, tree: Tree, name: str) -> None:
        super().__init__(robot, tree, name)
        a, b = (tree.body_index(frame.link) for frame in self.closure.frames())
        _, _, ancestor = tree.branches(a, b)
        self.to_base = tree.zero_pose(ancestor)

    @property
    def has_hinges_only(self) -> bool:
        """Whether all of its joints, the cut one included, only turn about an axis or a point."""
        return len(self.hinges) == len(self.joints) > 1 and self.closure.kind != "planar"

    @property
    def places(self) -> list[Pose]:
        """Rotations and origins of the closure's two frames."""
        return [_inside(self.to_base, end) for end in self.closure_frames]

    @property
    def lines(self) -> list[_Line]:
        """Axes of its hinges, that of a cut hinge from both sides."""
        lines: list[_Line] = []
        for name in self.joints:
            rotation, origin = _inside(self.to_base, (self.rotations[name], self.origins[name]))
            lines.append(_Line(origin, rotation @ self.robot.joints[name].axis))
        if self.closure.kind == "axis":
            lines += [_Line(origin, rotation[:, 2]) for rotation, origin in self.places]
        return lines

    def is_spherical(self, centre: Array, allowed: float) -> bool:
        """Whether it turns about a point; `allowed` is a share of its largest distance from it."""
        places = [line.point for line in self.lines]
        moves = [line.move_to(centre) for line in self.lines]
        fitted = _fitted(self.closure, self.places, centre)
        for (_, place), new in zip(self.places, fitted, strict=True):
            places.append(place)
            moves.append(new - place)
        extent = max(norm(place - centre) for place in places)
        return max(norm(move) for move in moves) <= allowed * extent


def _centre(loops: Sequence[_Loop]) -> Array | None:
    """The point (3,) [m] about which some loops turn up to printed digits; None if none."""
    lines: list[_Line] = []
    for loop in loops:
        lines += loop.lines
    centre = _common_point(lines)
    if centre is None or not all(loop.is_spherical(centre, ROUNDED) for loop in loops):
        return None
    return centre


def _common_point(lines: Sequence[_Line]) -> Array | None:
    """The point (3,) with the least sum of squared distances from lines [m], if it is distinct."""
    across: Array = np.zeros((3, 3))
    moment: Array = np.zeros(3)
    for line in lines:
        flat: Array = np.eye(3) - np.outer(line.direction, line.direction)
        across = across + flat / len(lines)
        moment = moment + flat @ line.point / len(lines)
    if np.linalg.eigvalsh(across)[0] < LEAST_ACROSS:
        return None
    centre: Array = np.array(np.linalg.solve(across, moment))
    return centre


def _fitted(closure: Closure, places: Sequence[Pose], centre: Array) -> tuple[Array, Array]:
    """Origins of a closure's ends at which they meet by turns about a centre alone [m]."""
    (turn_a, a), (turn_b, b) = places
    if closure.kind == "axis":
        along = float((a - centre) @ turn_a[:, 2])
        return centre + along * turn_a[:, 2], centre + along * turn_b[:, 2]
    if closure.kind == "frame":
        return a, centre + turn_b @ turn_a.T @ (a - centre)
    radius = norm(b - centre)
    if radius == 0.0:
        return centre, centre
    return a, centre + norm(a - centre) / radius * (b - centre)


def _inside(outer: Pose, inner: Pose) -> Pose:
    """A pose in the frame in which the outer one is given."""
    rotation, origin = outer
    return rotation @ inner[0], rotation @ inner[1] + origin


def _with_hinges_through(
    robot: RobotDescription, tree: Tree, loops: Sequence[_Loop], centre: Array
) -> RobotDescription:
    """The description with the joints of loops moved so that their axes pass through a point.

    Joints are moved from the base outward, since each moves all links behind it.
    """
    loop_of = {name: loop.closure.name for loop in reversed(loops) for name in loop.joints}
    joints = dict(robot.joints)
    poses: dict[str, Pose] = {robot.base: (np.eye(3), np.zeros(3))}
    notes = list(robot.notes)
    for body in tree.bodies:
        joint = joints[body.joint]
        parent = poses[joint.parent]
        rotation, origin = _inside(parent, (joint.rotation, joint.translation))
        if joint.name in loop_of:
            move = _Line(origin, rotation @ joint.axis).move_to(centre)
            origin = origin + move
            place = joint.translation + parent[0].T @ move
            joints[joint.name] = replace(joint, translation=frozen(place))
            text = f"moved by {norm(move):.2g} m, so that the axes of loop"
            text += f" '{loop_of[joint.name]}' meet in one point"
            notes += notes_on(robot, f"joints.{joint.name}.origin", text, norm(move))
        poses[joint.child] = rotation, origin
    return replace(robot, joints=joints, notes=tuple(notes))


def _with_ends_on_sphere(robot: RobotDescription, name: str, centre: Array) -> RobotDescription:
    """The description with the ends of a closure moved to where turns about a centre join them."""
    loop = _Loop(robot, build_tree(robot), name)
    closure = loop.closure
    new_places = _fitted(closure, loop.places, centre)
    changes: dict[str, Array] = {}
    size = 0.0
    ends = zip(("point_a", "point_b"), loop.ends, loop.places, new_places, strict=True)
    for key, (link_rotation, _), (_, old), new in ends:
        move = new - old
        turn = loop.to_base[0] @ link_rotation
        changes[key] = frozen(getattr(closure, key) + turn.T @ move)
        size = max(size, norm(move))
    text = f"its ends were moved by {size:.2g} m, to one distance from the point of all axes"
    notes = notes_on(robot, robot.closure_key(name), text, size)
    return with_changed(robot, closure, changes, notes)
