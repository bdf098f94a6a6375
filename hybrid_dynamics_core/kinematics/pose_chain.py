"""Closed-form inverse kinematics of chains of slides, then revolute joints whose axes meet.

Such a chain describes the pose of a platform. Its coordinates follow from the pose one after the
other, and the legs by closure. All vectors are in the base frame at zero coordinates, as in a
product of exponentials.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..algebra.vector import axis_rotation, constant
from ..description.model import Frame
from ..ground.arrays import Array
from ..mechanism.tree import Body, Tree

MEET = 1e-9  # [m] up to which axes count as meeting in one point
PARALLEL = 1e-6  # sine below which two axes count as parallel


@dataclass(frozen=True)
class PoseChain:
    """Slides, then revolute joints that meet in a point.

    Attributes:
        slides: coordinates of the slides (k,), in order from the base.
        turns: coordinates of the revolute joints (m,), in order from the base.
        directions: axes of the slides (k, 3), base axes.
        axes: axes of the revolute joints (m, 3) at zero, base axes.
        centre: point (3,) where the axes meet at zero [m].
        rotation: rotation of the frame (3, 3) at zero.
        position: position of the frame (3,) at zero [m].
    """

    slides: tuple[int, ...]
    turns: tuple[int, ...]
    directions: Array
    axes: Array
    centre: Array
    rotation: Array
    position: Array

    def solve(
        self,
        position: Array,
        rotation: Array | None,
        seed: Array,
    ) -> list[dict[int, float]]:
        """Up to two sets of coordinates that bring the frame to a pose.

        The caller must check them, since an unreachable pose is not detected here.

        Args:
            position: position of the frame (3,) [m].
            rotation: rotation of the frame (3, 3); if None, the turns stay as in `seed`.
            seed: all coordinates (n_s,) [rad, m].

        Returns:
            Values by coordinate [rad, m].
        """
        if rotation is None:
            options = [[float(seed[k]) for k in self.turns]]
        else:
            options = _angles(self.axes, rotation @ self.rotation.T)
        return [self._with_slides(position, angles) for angles in options]

    def _with_slides(
        self,
        position: Array,
        angles: list[float],
    ) -> dict[int, float]:
        """The given angles, and the slides that bring the frame nearest to a position."""
        turned = np.eye(3)
        for axis, angle in zip(self.axes, angles, strict=True):
            turned = turned @ _turn(axis, angle)
        arm = turned @ (self.position - self.centre)
        moved = position - arm - self.centre
        strokes: list[float] = []
        if self.slides:
            solution, *_ = np.linalg.lstsq(self.directions.T, moved, rcond=None)
            strokes = solution.tolist()
        coordinates = (*self.slides, *self.turns)
        return dict(zip(coordinates, [*strokes, *angles], strict=True))


def find_pose_chain(
    tree: Tree,
    frame: Frame,
    size: int,
) -> PoseChain | None:
    """The pose chain of a frame, if it has `size` coordinates of this structure; otherwise None."""
    end = tree.body_index(frame.link)
    bodies = [tree.bodies[i] for i in tree.path(end)]
    k = _count_slides(bodies)
    if len(bodies) != size or k is None:
        return None
    lines = [_axis_at_zero(tree, body) for body in bodies]
    directions = _directions(lines[:k])
    axes = _directions(lines[k:])
    centre = _meeting_point(lines[k:])
    if centre is None or np.linalg.matrix_rank(directions, tol=PARALLEL) < k:
        return None
    if _some_are_parallel(axes):
        return None
    rotation, origin = tree.zero_pose(end)
    coordinates = [body.coordinate for body in bodies]
    return PoseChain(
        slides=tuple(coordinates[:k]),
        turns=tuple(coordinates[k:]),
        directions=directions,
        axes=axes,
        centre=centre,
        rotation=rotation @ np.array(frame.rotation),
        position=rotation @ np.array(frame.translation) + origin,
    )


def _count_slides(bodies: Sequence[Body]) -> int | None:
    """The number of slides at the start of a chain.

    None if a slide follows a revolute joint, or if there are more than three of one type.
    """
    kinds = [body.type for body in bodies]
    k = kinds.count("prismatic")
    if "prismatic" in kinds[k:]:
        return None
    if k > 3 or len(kinds) - k > 3:
        return None
    return k


class _Line(NamedTuple):
    """A line in base axes: direction (3,) and a point (3,) [m]."""

    direction: Array
    point: Array


def _axis_at_zero(tree: Tree, body: Body) -> _Line:
    """The axis of a body's joint with all coordinates at zero."""
    rotation, origin = tree.zero_pose(tree.body_index(body.name))
    return _Line(rotation @ np.array(body.axis), origin)


def _directions(lines: Sequence[_Line]) -> Array:
    """The directions (N, 3) of lines."""
    directions = [line.direction for line in lines]
    return np.array(directions).reshape(len(lines), 3)


def _some_are_parallel(axes: Array) -> bool:
    """Whether two consecutive axes are parallel."""
    normals = [np.cross(a, b) for a, b in itertools.pairwise(axes)]
    return any(np.linalg.norm(normal) < PARALLEL for normal in normals)


def _meeting_point(lines: Sequence[_Line]) -> Array | None:
    """The point (3,) that all lines pass through [m], or None."""
    if not lines:
        return np.zeros(3)
    rows: list[Array] = []
    offsets: list[Array] = []
    for axis, point in lines:
        rows.append(np.eye(3) - np.outer(axis, axis))
        offsets.append(point - axis * (axis @ point))
    matrix = np.vstack(rows)
    right = np.concatenate(offsets)
    solution, *_ = np.linalg.lstsq(matrix, right, rcond=None)
    centre = solution.astype(np.float64)
    errors = matrix @ centre - right
    if float(np.abs(errors).max()) < MEET:
        return centre
    return None


def _angles(axes: Array, wanted: Array) -> list[list[float]]:
    """Angles about up to three axes whose product of rotations is a given one.

    Returns:
        All solutions, up to two; each with an angle [rad] for each axis.
    """
    if len(axes) == 0:
        return [[]]
    if len(axes) == 3:
        return _three_angles(axes, wanted)
    first = _first_angle(axes, wanted)
    remaining = _turn(axes[0], -first) @ wanted
    return [[first, *angles] for angles in _angles(axes[1:], remaining)]


def _first_angle(axes: Array, wanted: Array) -> float:
    """The angle [rad] about the first of one or two axes.

    The second rotation does not move its own axis. So `wanted` moves that axis as the first
    rotation does. Without a second rotation, any vector normal to the first axis shows the angle.
    """
    least = int(np.argmin(np.abs(axes[0])))
    probe = np.eye(3)[least]
    if len(axes) == 2:
        probe = axes[1]
    return _between(axes[0], probe, wanted @ probe)


def _three_angles(axes: Array, wanted: Array) -> list[list[float]]:
    """Angles about three axes whose product is a rotation; the second has up to two values.

    The third rotation does not move w3, so the first two take it to `goal`. The first rotation does
    not change the component along w1, so the second must produce it.
    """
    w1, w2, w3 = axes
    goal = wanted @ w3
    solutions = []
    for second in _angles_of_component(w1, w2, w3, float(w1 @ goal)):
        first = _between(w1, _turn(w2, second) @ w3, goal)
        remaining = _turn(w2, -second) @ _turn(w1, -first) @ wanted
        third = _first_angle(axes[2:], remaining)
        solutions.append([first, second, third])
    return solutions


def _angles_of_component(
    w1: Array,
    w2: Array,
    w3: Array,
    component: float,
) -> list[float]:
    """Angles [rad] about w2 at which w3 has a given component along w1: two, or none.

    By Rodrigues' formula the component is a cos(angle) + b sin(angle) + constant.
    """
    constant_part = float((w2 @ w3) * (w1 @ w2))
    a = float(w1 @ w3) - constant_part
    b = float(w1 @ np.cross(w2, w3))
    c = component - constant_part
    amplitude = math.hypot(a, b)
    if abs(c) > amplitude * (1.0 + 1e-12):
        return []
    middle = math.atan2(b, a)
    half = math.acos(max(-1.0, min(1.0, c / amplitude)))
    return [_principal(middle + half), _principal(middle - half)]


def _between(axis: Array, start: Array, end: Array) -> float:
    """Angle [rad] about an axis from one vector to another, by their components normal to it."""
    a = start - axis * (axis @ start)
    b = end - axis * (axis @ end)
    sine = float(axis @ np.cross(a, b))
    return math.atan2(sine, float(a @ b))


def _principal(angle: float) -> float:
    """The same angle between -pi and pi [rad]."""
    return math.remainder(angle, 2.0 * math.pi)


def _turn(axis: Array, angle: float) -> Array:
    """The rotation (3, 3) about an axis (3,) by an angle [rad]."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array(axis_rotation(constant(axis), cosine, sine))
