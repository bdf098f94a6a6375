"""Constant distances of a mechanism, between joints and pins on the same link.

Links that only slide on each other count as one. Between two places on them, the component of the
distance normal to the slides is constant.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.independence import length, norm
from ..algebra.live import is_live
from ..description.model import Closure, RobotDescription
from ..ground.arrays import Array
from ..mechanism.tree import Body, Tree
from .constraints.closure_place import PARALLEL, turns_of

_POINT = np.zeros(3)  # direction of a place that is a point
_ORIGIN = np.zeros(3)


class Place(NamedTuple):
    """Axis of a revolute joint, or a pin, on a link.

    Attributes:
        link: index of the link's body, -1 for the base.
        point: a point of the axis, or the pin, in the frame of the link (3,) [m].
        direction: unit vector along the axis (3,); zero for a pin.
    """

    link: int
    point: Array
    direction: Array


@dataclass(frozen=True)
class _Standing:
    """Pose of a link within a group of links that only slide on each other.

    Attributes:
        group: index of the group.
        pose: pose (4, 4) of the link in the frame of the group, with all slides at zero.
        slides: by coordinate: direction (3,) of a slide between frame and link.
    """

    group: int
    pose: Array
    slides: Mapping[int, Array] = field(default_factory=dict)

    def place(self, place: Place) -> Place:
        """A place of the link, in the frame of the group."""
        rotation, origin = self.pose[:3, :3], self.pose[:3, 3]
        return Place(self.group, rotation @ place.point + origin, rotation @ place.direction)


class FixedDistances:
    """Joints and pins of all loops, and the largest constant distance between them."""

    def __init__(self, tree: Tree, robot: RobotDescription) -> None:
        self._tree = tree
        self._robot = robot
        self._standings = _standings(tree, robot)
        self._of_free_joints = turns_of(tree, robot, "free")
        self._of_balls = turns_of(tree, robot, "ball")
        self._closures = {closure.name: closure for closure in robot.closures}

    def largest(self, names: Iterable[str] | None = None) -> float:
        """The largest constant distance [m] between joints and pins of closures, or 0.

        Args:
            names: names of the closures; None for all.
        """
        if names is None:
            names = self._closures
        places: dict[tuple[object, int], Place] = {}
        for name in names:
            if name in self._closures:
                places.update(self._places(self._closures[name]))
        pairs = combinations(places.values(), 2)
        return max((self._between(a, b) for a, b in pairs), default=0.0)

    def _places(self, closure: Closure) -> Iterator[tuple[tuple[object, int], Place]]:
        """Joints and pin of a loop on both of their links, by (joint or pin, link)."""
        a = self._tree.body_index(closure.link_a)
        b = self._tree.body_index(closure.link_b)
        path_a, path_b, ancestor = self._tree.branches(a, b)
        path = path_a + path_b
        for k in path:
            body = self._tree.bodies[k]
            is_joint = body.coordinate not in self._of_free_joints
            if body.is_revolute and is_joint:
                axis = self._axis(body)
                on_parent = np.array(body.rotation) @ axis
                origin = np.array(body.translation)
                yield (k, k), Place(k, _ORIGIN, axis)
                yield (k, body.parent), Place(body.parent, origin, on_parent)
        if closure.kind == "frame":
            return
        normal = self._common_axis(path, ancestor)
        for link, frame in zip((a, b), closure.frames(), strict=True):
            direction = frame.rotation[:, 2]
            if closure.kind != "axis":
                rotation, _ = self._tree.zero_pose(link, ancestor)
                direction = rotation.T @ normal
            yield (closure.name, link), Place(link, frame.translation, direction)

    def _axis(self, body: Body) -> Array:
        """The axis of a revolute joint, zero for one of a ball joint: all of them meet."""
        if body.coordinate in self._of_balls:
            return _POINT
        return np.array(body.axis)

    def _common_axis(self, path: list[int], ancestor: int) -> Array:
        """Common direction (3,) of a loop's revolute joints, in an ancestor; zero without one."""
        axes: list[Array] = []
        for k in path:
            body = self._tree.bodies[k]
            if body.is_revolute:
                rotation, _ = self._tree.zero_pose(k, ancestor)
                axes.append(rotation @ np.array(body.axis))
        if not axes or any(norm(np.cross(axes[0], axis)) > PARALLEL for axis in axes):
            return _POINT
        return axes[0]

    def _between(self, a: Place, b: Place) -> Any:
        """The constant distance of two places [m]; 0 if they turn relative to each other."""
        one = self._standings[a.link]
        other = self._standings[b.link]
        if one.group != other.group:
            return 0.0
        start = one.place(a)
        end = other.place(b)
        directions = [start.direction, end.direction]
        slides = {**one.slides, **other.slides}
        # slides on the way to both are not between them
        between = one.slides.keys() ^ other.slides.keys()
        directions += [slides[k] for k in between]
        return _length_across(end.point - start.point, directions)


def _length_across(vector: Array, directions: list[Array]) -> Any:
    """Length of a vector's component normal to directions, which are unit vectors or zero."""
    if is_live(vector) or any(map(is_live, directions)):
        return _live_length_across(vector, directions)
    _, sizes, basis = np.linalg.svd(np.array(directions), full_matrices=False)
    spanned = basis[sizes > PARALLEL]
    return norm(vector - spanned.T @ (spanned @ vector))


def _live_length_across(vector: Array, directions: list[Array]) -> Any:
    """The same of live numbers, by orthogonalisation of the directions one after the other."""
    basis: list[Array] = []
    for direction in directions:
        remainder = _across(direction, basis)
        if norm(remainder) > PARALLEL:
            basis.append(remainder / length(remainder))
    return length(_across(vector, basis))


def _across(vector: Array, basis: list[Array]) -> Array:
    """The component of a vector normal to orthogonal unit vectors."""
    for axis in basis:
        vector = vector - (axis @ vector) * axis
    return vector


def _inverse(pose: Array) -> Array:
    """The inverse (4, 4) of a pose."""
    if not is_live(pose):
        return np.asarray(np.linalg.inv(pose), dtype=np.float64)
    rotation = pose[:3, :3].T
    return _pose(rotation, -(rotation @ pose[:3, 3]))


def _pose(rotation: ArrayLike, origin: ArrayLike) -> Array:
    """A pose as a matrix (4, 4)."""
    pose = np.eye(4)
    if is_live(np.array(rotation)) or is_live(np.array(origin)):
        pose = pose.astype(object)
    pose[:3, :3] = rotation
    pose[:3, 3] = origin
    return pose


def _standings(tree: Tree, robot: RobotDescription) -> dict[int, _Standing]:
    """By link: its pose in its group of links that slide on each other or are welded."""
    standings = {-1: _Standing(-1, np.eye(4))}
    for index, body in enumerate(tree.bodies):
        standings[index] = _Standing(index, np.eye(4))
        if not body.is_revolute:
            standings[index] = _on_slide(standings[body.parent], body)
    for closure in robot.closures:
        if closure.kind == "frame":
            first = tree.body_index(closure.link_a)
            second = tree.body_index(closure.link_b)
            poses = [_pose(frame.rotation, frame.translation) for frame in closure.frames()]
            weld = poses[0] @ _inverse(poses[1])
            standings.update(_welded(standings, first, second, weld))
    return standings


def _on_slide(parent: _Standing, body: Body) -> _Standing:
    """The standing of a link on a slide of its parent."""
    pose = parent.pose @ _pose(body.rotation, body.translation)
    slide = pose[:3, :3] @ np.array(body.axis)
    return _Standing(parent.group, pose, {**parent.slides, body.coordinate: slide})


def _welded(
    standings: Mapping[int, _Standing], first: int, second: int, weld: Array
) -> dict[int, _Standing]:
    """The standings after the second link's group is merged into that of the first.

    Args:
        standings: standings of all links.
        first: a link.
        second: a link of another group.
        weld: pose (4, 4) of the second in the first.
    """
    one, other = standings[first], standings[second]
    if one.group == other.group:
        return {}
    move = one.pose @ weld @ _inverse(other.pose)
    result: dict[int, _Standing] = {}
    for link, standing in standings.items():
        if standing.group == other.group:
            slides = dict(one.slides)
            directions = {**other.slides, **standing.slides}
            for k in other.slides.keys() ^ standing.slides.keys():
                slides[k] = move[:3, :3] @ directions[k]
            result[link] = _Standing(one.group, move @ standing.pose, slides)
    return result
