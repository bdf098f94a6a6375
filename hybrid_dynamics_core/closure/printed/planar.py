"""Correction of loops that are planar up to the printed digits of their file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ...algebra.independence import norm
from ...description.model import Closure, Joint, RobotDescription
from ...ground.arrays import Array, frozen
from ...mechanism.tree import build_tree
from ..constraints.parallelogram import EQUAL, PARALLELOGRAM
from ..constraints.planar_loops import APART
from ..constraints.plane import PARALLEL, ROUNDED
from .loop import DrawnLoop, loops_by_hinge, notes_on, with_changed

EXACT = 1e-14  # [rad] a smaller turn is the rounding of numbers
DRAWN_EQUAL = 1e-3  # difference of opposite bars, over the longest, in drawings that cannot move


def snapped(robot: RobotDescription, equal_bars: float = ROUNDED) -> RobotDescription:
    """The description in which loops that are planar within `ROUNDED` are exactly planar.

    Angles such as 1.5708 tilt an axis by some 1e-6 rad. The joint is turned back, together with the
    links that it carries. Notes give the joints and angles.

    Args:
        robot: a description; not changed.
        equal_bars: difference of opposite bars, over the longest, up to which a loop becomes a
            parallelogram.
    """
    if not robot.closures:
        return robot
    tree = build_tree(robot)
    every = [_Loop(robot, tree, closure.name) for closure in robot.closures]
    loops = [loop for loop in every if loop.is_near_plane]
    turned: dict[str, str] = {}  # the loop of each joint that was turned
    settled = robot
    for group in loops_by_hinge(loops):
        if any(loop.tilt(loop.normal) > PARALLEL for loop in group):
            settled = _with_joints_in_plane(settled, group, turned)
    notes = _notes_of_turns(robot, settled, turned)
    robot = replace(settled, notes=(*robot.notes, *notes))
    tree = build_tree(robot)
    for name in [loop.closure.name for loop in loops]:
        loop = _Loop(robot, tree, name)
        robot = _with_ends_in_plane(robot, loop, loop.normal)
        aligned = _Loop(robot, tree, name)
        robot = _with_equal_bars(
            robot,
            aligned,
            loop.normal,
            equal_bars,
        )
    return robot


def _notes_of_turns(
    drawn: RobotDescription, robot: RobotDescription, turned: Mapping[str, str]
) -> Iterator[str]:
    """Notes on the angle by which each joint was turned."""
    for name, loop in turned.items():
        change = robot.joints[name].rotation - drawn.joints[name].rotation
        tilt = norm(change) / np.sqrt(2.0)  # [rad] for small angles
        text = f"turned by {tilt:.2g} rad, into the plane of loop '{loop}'"
        yield from notes_on(drawn, f"joints.{name}.origin", text, tilt)


class _Loop(DrawnLoop):
    """A loop that may be planar."""

    def bars(self, normal: Array) -> list[Array]:
        """Sides of the polygon of pivots: along chain a to the pin, back along chain b, and across.

        Vectors (3,) [m], projected onto the plane of a normal; an empty list if a joint slides.
        """
        if any(self.robot.joints[name].type != "revolute" for name in self.joints):
            return []
        flat = np.eye(3) - np.outer(normal, normal)
        sides: list[list[Array]] = []
        points = (self.closure.point_a, self.closure.point_b)
        for path, end, point in zip(self.paths, self.ends, points, strict=True):
            rotation, origin = end
            places = [self.origins[name] for name in path]
            places.append(rotation @ point + origin)
            sides.append([flat @ place for place in places])
        out, back = sides
        first = [end - start for start, end in pairwise(out)]
        second = [start - end for start, end in pairwise(back)]
        return [*first, *reversed(second), out[0] - back[0]]

    @property
    def normal(self) -> Array:
        """Axis (3,) of its first hinge; zero if it has no hinge."""
        if not self.hinges:
            return np.zeros(3)
        return self.axis(self.hinges[0])

    @property
    def is_near_plane(self) -> bool:
        """Whether the loop is planar up to printed digits."""
        return bool(self.hinges) and self.tilt(self.normal) <= ROUNDED

    def tilt(self, normal: Array) -> float:
        """Largest angle [rad] between a joint's motion and the plane of this normal."""
        tilts: list[float] = []
        for name in self.joints:
            axis = self.axis(name)
            target = in_plane(self.robot.joints[name], axis, normal)
            tilts.append(norm(axis - target))
        return max(tilts, default=0.0)


def in_plane(joint: Joint, axis: Array, normal: Array) -> Array:
    """The axis (3,) nearest to a given one with which a joint moves in the plane of a normal."""
    along = float(axis @ normal)
    if joint.type == "revolute":
        hinge: Array = float(np.copysign(1.0, along)) * normal
        return hinge
    flat = axis - along * normal
    size = norm(flat)
    if size == 0.0:
        return axis
    result: Array = flat / size
    return result


def _with_joints_in_plane(
    robot: RobotDescription, loops: Sequence[_Loop], turned: dict[str, str]
) -> RobotDescription:
    """The description with the joints of a group of loops turned into one plane.

    Joints are turned from the base outward, since each turns all links behind it.
    """
    loop_of = {name: loop.closure.name for loop in reversed(loops) for name in loop.joints}
    joints = dict(robot.joints)
    frames = {robot.base: np.eye(3)}  # rotations of the links at zero, in base axes
    tree = build_tree(robot)
    first = next(k for k, one in enumerate(tree.bodies) if one.joint in loop_of and one.is_revolute)
    rotation, _ = tree.zero_pose(first)
    normal = rotation @ np.array(tree.bodies[first].axis)
    for body in tree.bodies:
        joint = joints[body.joint]
        parent = frames[joint.parent]
        rotation = parent @ joint.rotation
        if joint.name in loop_of:
            axis = rotation @ joint.axis
            target = in_plane(joint, axis, normal)
            if norm(axis - target) > EXACT:
                rotation = _turn(axis, target) @ rotation
                in_parent = frozen(parent.T @ rotation)
                joints[joint.name] = replace(joint, rotation=in_parent)
                turned.setdefault(joint.name, loop_of[joint.name])
        frames[joint.child] = rotation
    return replace(robot, joints=joints)


def _with_ends_in_plane(robot: RobotDescription, loop: _Loop, normal: Array) -> RobotDescription:
    """The description with the ends of a closure in one plane and their frames aligned."""
    closure = loop.closure
    (rotation_a, origin_a), (rotation_b, origin_b) = loop.ends
    place_a = rotation_a @ closure.point_a + origin_a
    place_b = rotation_b @ closure.point_b + origin_b
    gap = float((place_a - place_b) @ normal)
    changes: dict[str, Any] = {}
    notes: list[str] = []
    key = robot.closure_key(closure.name)
    size = max(norm(place_a), norm(place_b))
    if APART < abs(gap) <= ROUNDED * size:
        move = rotation_b.T @ (gap * normal)
        changes["point_b"] = frozen(closure.point_b + move)
        notes += notes_on(robot, key, f"moved by {abs(gap):.2g} m along its axis", abs(gap))
    tilt, frames = _frames_turned_alike(closure, rotation_a, rotation_b, normal)
    if PARALLEL < tilt <= ROUNDED:
        changes |= frames
        notes += notes_on(robot, key, f"its frames were turned by {tilt:.2g} rad to fit", tilt)
    if not changes:
        return robot
    return with_changed(robot, closure, changes, notes)


def _with_equal_bars(
    robot: RobotDescription, loop: _Loop, normal: Array, allowed: float
) -> RobotDescription:
    """The description with the pin of a parallelogram moved so that opposite bars are equal.

    Bars that differ by more than is allowed, a share of the longest, stay unequal.
    """
    closure = loop.closure
    bars = loop.bars(normal)
    if closure.assembly not in (None, PARALLELOGRAM) or len(bars) != 4:
        return robot
    lengths = [norm(bar) for bar in bars]
    longest = max(lengths)
    one_pair = abs(lengths[0] - lengths[2])
    other_pair = abs(lengths[1] - lengths[3])
    off = max(one_pair, other_pair)
    if not EQUAL * longest < off <= allowed * longest:
        return robot
    last = len(loop.paths[0]) - 1
    (rotation_a, _), (rotation_b, _) = loop.ends
    changes: dict[str, Any] = {}
    ends = (
        (last, 1.0, "point_a", rotation_a),
        (last + 1, -1.0, "point_b", rotation_b),
    )
    for index, sense, name, rotation in ends:
        bar = bars[index % 4]
        opposite = lengths[(index + 2) % 4]
        longer = bar * (opposite / norm(bar) - 1.0)
        point = getattr(closure, name)
        changes[name] = frozen(point + rotation.T @ (sense * longer))
    text = f"its opposite bars differ by {off:.2g} m; the pin was moved so that they are equal"
    notes = notes_on(robot, robot.closure_key(closure.name), text, off)
    return with_changed(robot, closure, changes, notes)


def _frames_turned_alike(
    closure: Closure, rotation_a: Array, rotation_b: Array, normal: Array
) -> tuple[float, Mapping[str, Array]]:
    """Correct a closure's frames so that the normal is the same in both.

    Returns:
        The angle of the correction [rad], and the new rotations by key.
    """
    if closure.kind not in ("axis", "frame"):
        return 0.0, {}
    in_a = (rotation_a @ closure.rotation_a).T @ normal
    in_b = (rotation_b @ closure.rotation_b).T @ normal
    if closure.kind == "frame":
        turn = _turn(in_b, in_a)
        return norm(in_a - in_b), {"rotation_b": frozen(closure.rotation_b @ turn.T)}
    frames: dict[str, Array] = {}
    tilts: list[float] = []
    ends = (
        ("rotation_a", closure.rotation_a, in_a),
        ("rotation_b", closure.rotation_b, in_b),
    )
    for name, rotation, inside in ends:
        axis = np.array([0.0, 0.0, np.copysign(1.0, inside[2])])
        tilts.append(norm(inside - axis))
        frames[name] = frozen(rotation @ _turn(inside, axis).T)
    return max(tilts), frames


def _turn(start: Array, end: Array) -> Array:
    """The smallest rotation (3, 3) that takes one unit vector to another one nearby."""
    x, y, z = np.cross(start, end)
    entries = [
        [0.0, -z, y],
        [z, 0.0, -x],
        [-y, x, 0.0],
    ]
    cross = np.array(entries)
    rotation: Array = np.eye(3) + cross + cross @ cross / (1.0 + float(start @ end))
    return rotation
