"""Inverse kinematics in closed form, for slides followed by joints whose axes meet.

That is how a platform's pose is written. Its coordinates follow from the pose one after the other,
and the legs follow from them by closure. Everything is in the frame of the base, each joint as it
stands at zero (product of exponentials).
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
        directions: of the slides (k, 3), base axes.
        axes: of the revolute joints (m, 3), base axes at zero.
        centre: point (3,) where the axes meet at zero [m].
        rotation: of the frame (3, 3) at zero.
        position: of the frame (3,) at zero [m].
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
        """Coordinates that bring the frame to a pose, in up to two ways.

        They are to be checked, since the pose may not be reachable.

        Args:
            position: of the frame (3,) [m].
            rotation: of the frame (3, 3); if None, the turns stay as in `seed`.
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
    """The pose chain of a frame, if its joints are `size` coordinates of that kind; else None."""
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
    """How many slides come first; None if not all do, or there are more than a pose has."""
    kinds = [body.type for body in bodies]
    k = kinds.count("prismatic")
    if "prismatic" in kinds[k:]:
        return None
    if k > 3 or len(kinds) - k > 3:
        return None
    return k


class _Line(NamedTuple):
    """A line in base axes: its direction (3,) and one of its points (3,) [m]."""

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
    """Whether an axis has the direction of the one before."""
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
    """Angles about up to three axes whose turns, in order, make a rotation, if any do."""
    if len(axes) == 0:
        return [[]]
    if len(axes) == 3:
        return _three_angles(axes, wanted)
    first = _first_angle(axes, wanted)
    remaining = _turn(axes[0], -first) @ wanted
    return [[first, *angles] for angles in _angles(axes[1:], remaining)]


def _first_angle(axes: Array, wanted: Array) -> float:
    """The angle about the first of one or two axes.

    It is seen at the second axis, which the second turn leaves alone, or at any other vector.
    """
    least = int(np.argmin(np.abs(axes[0])))
    other = np.eye(3)[least]
    if len(axes) == 2:
        other = axes[1]
    return _between(axes[0], other, wanted @ other)


def _three_angles(axes: Array, wanted: Array) -> list[list[float]]:
    """The same for three axes: the second angle has up to two values."""
    w1, w2, w3 = axes
    goal = wanted @ w3
    solutions = []
    for second in _heights(w1, w2, w3, float(w1 @ goal)):
        first = _between(w1, _turn(w2, second) @ w3, goal)
        remaining = _turn(w2, -second) @ _turn(w1, -first) @ wanted
        third = _first_angle(axes[2:], remaining)
        solutions.append([first, second, third])
    return solutions


def _heights(
    w1: Array,
    w2: Array,
    w3: Array,
    height: float,
) -> list[float]:
    """Angles about w2 at which w3 has the given component along w1."""
    along = float((w2 @ w3) * (w1 @ w2))
    a = float(w1 @ w3) - along
    b = float(w1 @ np.cross(w2, w3))
    c = height - along
    size = math.hypot(a, b)
    if abs(c) > size * (1.0 + 1e-12):
        return []
    middle = math.atan2(b, a)
    half = math.acos(max(-1.0, min(1.0, c / size)))
    return [_principal(middle + half), _principal(middle - half)]


def _between(axis: Array, start: Array, end: Array) -> float:
    """Angle about the axis from one vector to another, seen along it."""
    a = start - axis * (axis @ start)
    b = end - axis * (axis @ end)
    sine = float(axis @ np.cross(a, b))
    return math.atan2(sine, float(a @ b))


def _principal(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _turn(axis: Array, angle: float) -> Array:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array(axis_rotation(constant(axis), cosine, sine))
