"""Inverse kinematics in closed form, where the end effector is carried by slides and then by joints that meet.

That is how a platform's pose is written: its coordinates follow from the pose one after the other,
and the legs follow from them by closure. Everything is in the frame of the base, each joint as it
stands at zero (product of exponentials).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..algebra.vector import axis_rotation, constant
from ..description.model import Frame
from ..ground.arrays import Array
from ..mechanism.tree import Tree

MEET = 1e-9  # [m] up to which axes count as meeting in one point
PARALLEL = 1e-6  # sine below which two axes count as parallel


@dataclass(frozen=True)
class PoseChain:
    """Slides `directions` (k, 3), then axes (m, 3) that meet in `centre`; `rotation`, `position` of the frame at zero.

    `slides`, `turns`: the coordinates, in order from the base.
    """

    slides: tuple[int, ...]
    turns: tuple[int, ...]
    directions: Array
    axes: Array
    centre: Array
    rotation: Array
    position: Array

    def solve(self, position: Array, rotation: Array | None, seed: Array) -> list[dict[int, float]]:
        """Coordinates that bring the frame to a pose, up to two ways; to be checked, as the pose may not be reachable.

        Without `rotation` the turns stay as in `seed` (all coordinates).
        """
        if rotation is None:
            options = [[float(seed[k]) for k in self.turns]]
        else:
            options = _angles(self.axes, rotation @ self.rotation.T)
        return [self._with_slides(position, angles) for angles in options]

    def _with_slides(self, position: Array, angles: list[float]) -> dict[int, float]:
        turned = np.eye(3)
        for axis, angle in zip(self.axes, angles, strict=True):
            turned = turned @ _turn(axis, angle)
        arm = turned @ (self.position - self.centre)
        moved = position - arm - self.centre
        strokes = (
            np.linalg.lstsq(self.directions.T, moved, rcond=None)[0]
            if len(self.slides)
            else np.zeros(0)
        )
        return {
            **dict(zip(self.slides, strokes.tolist(), strict=True)),
            **dict(zip(self.turns, angles, strict=True)),
        }


def find_pose_chain(tree: Tree, frame: Frame, size: int) -> PoseChain | None:
    """The pose chain of a frame, if its joints are `size` coordinates of that kind; None otherwise."""
    bodies = [tree.bodies[i] for i in tree.path(tree.body_index(frame.link))]
    kinds = [b.type for b in bodies]
    slides = kinds.count("prismatic")
    if len(bodies) != size or "prismatic" in kinds[slides:] or slides > 3 or size - slides > 3:
        return None
    lines = []
    for body in bodies:
        rotation, origin = tree.zero_pose(tree.body_index(body.name))
        lines.append((rotation @ np.array(body.axis), origin))
    directions = np.array([axis for axis, _ in lines[:slides]]).reshape(slides, 3)
    axes = np.array([axis for axis, _ in lines[slides:]]).reshape(size - slides, 3)
    centre = _meeting_point(lines[slides:])
    if centre is None or np.linalg.matrix_rank(directions, tol=PARALLEL) < slides:
        return None
    if any(np.linalg.norm(np.cross(a, b)) < PARALLEL for a, b in itertools.pairwise(axes)):
        return None
    rotation, origin = tree.zero_pose(tree.body_index(frame.link))
    coordinates = [b.coordinate for b in bodies]
    return PoseChain(
        tuple(coordinates[:slides]),
        tuple(coordinates[slides:]),
        directions,
        axes,
        centre,
        rotation @ np.array(frame.rotation),
        rotation @ np.array(frame.translation) + origin,
    )


def _meeting_point(lines: list[tuple[Array, Array]]) -> Array | None:
    """The point that all lines (axis, point) pass through."""
    if not lines:
        return np.zeros(3)
    rows = np.vstack([np.eye(3) - np.outer(axis, axis) for axis, _ in lines])
    right = np.concatenate([point - axis * (axis @ point) for axis, point in lines])
    point: Array = np.linalg.lstsq(rows, right, rcond=None)[0]
    return point if float(np.abs(rows @ point - right).max()) < MEET else None


def _angles(axes: Array, wanted: Array) -> list[list[float]]:
    """Angles about up to three axes whose turns, in order, make the rotation `wanted` (if they can)."""
    if len(axes) == 0:
        return [[]]
    if len(axes) < 3:
        other = axes[1] if len(axes) == 2 else np.eye(3)[int(np.argmin(np.abs(axes[0])))]
        first = _between(axes[0], other, wanted @ other)
        rest = _turn(axes[0], -first) @ wanted
        return [[first, *angles] for angles in _angles(axes[1:], rest)]
    w1, w2, w3 = axes
    goal = wanted @ w3
    return [
        [first, second, _angles(axes[2:], _turn(w2, -second) @ _turn(w1, -first) @ wanted)[0][0]]
        for second in _heights(w1, w2, w3, float(w1 @ goal))
        for first in [_between(w1, _turn(w2, second) @ w3, goal)]
    ]


def _heights(w1: Array, w2: Array, w3: Array, height: float) -> list[float]:
    """Angles about w2 at which w3 has the given component along w1."""
    along = float((w2 @ w3) * (w1 @ w2))
    a, b, c = float(w1 @ w3) - along, float(w1 @ np.cross(w2, w3)), height - along
    size = math.hypot(a, b)
    if abs(c) > size * (1.0 + 1e-12):
        return []
    middle, half = math.atan2(b, a), math.acos(max(-1.0, min(1.0, c / size)))
    return [_principal(middle + half), _principal(middle - half)]


def _between(axis: Array, start: Array, end: Array) -> float:
    """Angle about the axis from one vector to another, seen along it."""
    a, b = start - axis * (axis @ start), end - axis * (axis @ end)
    return math.atan2(float(axis @ np.cross(a, b)), float(a @ b))


def _principal(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _turn(axis: Array, angle: float) -> Array:
    return np.array(axis_rotation(constant(axis), math.cos(angle), math.sin(angle)))
