"""Triangle meshes: revolved bodies with sharp edges, rounded bodies round points, arrows.

Lengths in [m], no colours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from ..ground.arrays import Array
from ..scene.parts import across_axis

AROUND: Final = 40  # corners of a circle
SWEEP: Final = 4.6  # [rad] of an arrow round an axis
CHAMFER: Final = 0.12  # of the radius, at the edges of revolved bodies
_HEAD: Final = 0.55  # [rad] of the head of that arrow
_AROUND_RING: Final = 16  # corners of a circle across that arrow

Faces = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles.

    Attributes:
        vertices: (k, 3) corners.
        faces: (m, 3) indices of corners, counterclockwise as seen from outside.
    """

    vertices: Array
    faces: Faces

    def placed(self, rotation: Array, origin: Array) -> Mesh:
        """The mesh moved: `rotation` (3, 3) of its axes, then `origin` (3,)."""
        return Mesh(self.vertices @ rotation.T + origin, self.faces)


def join_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    faces = []
    start = 0
    for mesh in meshes:
        faces.append(mesh.faces + start)
        start += len(mesh.vertices)
    vertices = [mesh.vertices for mesh in meshes]
    return Mesh(np.vstack(vertices), np.vstack(faces))


# -- revolved bodies


def revolved(profile: Sequence[tuple[float, float]]) -> Mesh:
    """A body turned about z from a profile, from the bottom to the top, outside to the right.

    Every piece of the profile has corners of its own, so that its edges stay sharp in smooth
    shading.

    Args:
        profile: (radius, height) of its corners.

    Returns:
        The body.
    """
    return join_meshes([_revolved_piece(low, high) for low, high in pairwise(profile)])


def _revolved_piece(low: tuple[float, float], high: tuple[float, float]) -> Mesh:
    """One piece of a profile turned about z; a radius of zero is a tip."""
    angles = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rings = []
    for radius, height in (low, high):
        rings.append(np.column_stack([radius * circle, np.full(AROUND, height)]))
    here = np.arange(AROUND)
    after = (here + 1) % AROUND
    faces = []
    if high[0] == 0.0:
        faces.append(np.stack([here, after, AROUND + here], axis=1))
    else:
        if low[0] > 0.0:
            faces.append(np.stack([here, after, AROUND + after], axis=1))
        faces.append(np.stack([here, AROUND + after, AROUND + here], axis=1))
    return Mesh(np.vstack(rings), np.vstack(faces))


def cylinder(radius: float, start: Array, end: Array) -> Mesh:
    """A cylinder with broken edges between two points (3,)."""
    length = float(np.linalg.norm(end - start))
    edge = CHAMFER * min(radius, length)
    bottom = [(0.0, 0.0), (radius - edge, 0.0), (radius, edge)]
    top = [(radius, length - edge), (radius - edge, length), (0.0, length)]
    return revolved(bottom + top).placed(frame_along(end - start), start)


def tube(radius: float) -> Mesh:
    """A cylinder along z from 0 to 1, to be stretched."""
    return revolved([(0.0, 0.0), (radius, 0.0), (radius, 1.0), (0.0, 1.0)])


def arrow(radius: float) -> Mesh:
    """An arrow along z from 0 to 1: a shaft and a head."""
    shaft = [(0.0, 0.0), (radius, 0.0), (radius, 0.68)]
    head = [(2.4 * radius, 0.68), (0.0, 1.0)]
    return revolved(shaft + head)


# -- other bodies


def rounded(points: Array, radius: float) -> Mesh:
    """The hull of balls round points (k, 3): a ball, a capsule, a plate with round edges."""
    corners = (points[:, None] + radius * _BALL[None]).reshape(-1, 3)
    hull = ConvexHull(corners)
    faces = np.array(hull.simplices, dtype=np.int64)
    a, b, c = corners[faces[:, 0]], corners[faces[:, 1]], corners[faces[:, 2]]
    normals = np.cross(b - a, c - a)
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    used, indices = np.unique(faces, return_inverse=True)
    return Mesh(corners[used], indices.reshape(faces.shape))


def ring_arrow(radius: float) -> Mesh:
    """An arrow round z on a circle of radius 1, counterclockwise from x over SWEEP."""
    angles = np.linspace(0.0, SWEEP, 49)
    profile = [(0.0, 0.0)]
    profile += [(float(angle), radius) for angle in angles if angle <= SWEEP - _HEAD]
    profile += [(SWEEP - _HEAD, 2.6 * radius), (SWEEP, 0.0)]
    rings = [_ring(angle, size) for angle, size in profile]
    return join_meshes([_ring_piece(low, high) for low, high in pairwise(rings)])


def _ring(angle: float, size: float) -> Array:
    """(k, 3) a circle of a size across the circle of radius 1, at an angle of that."""
    around = np.linspace(0.0, 2.0 * np.pi, _AROUND_RING + 1)[:-1, None]
    outward = np.array([np.cos(angle), np.sin(angle), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return np.asarray(outward * (1.0 + size * np.cos(around)) + up * size * np.sin(around))


def _ring_piece(low: Array, high: Array) -> Mesh:
    """The surface between two circles."""
    count = len(low)
    here = np.arange(count)
    after = (here + 1) % count
    first = np.stack([here, count + after, after], axis=1)
    second = np.stack([here, count + here, count + after], axis=1)
    return Mesh(np.vstack([low, high]), np.vstack([first, second]))


# -- frames


def frame_along(direction: Array) -> Array:
    """(3, 3) a rotation whose z axis is along a direction (3,)."""
    axis = direction / np.linalg.norm(direction)
    return np.stack([*across_axis(axis), axis], axis=1)


def frame_open(axis: Array, toward: Array) -> Array:
    """(3, 3) a rotation whose z axis is along an axis (3,).

    A ring arrow in it is open toward a direction (3,) across the axis.
    """
    z = axis / np.linalg.norm(axis)
    open_to = toward / np.linalg.norm(toward)
    middle = 0.5 * (SWEEP + 2.0 * np.pi)  # of what the arrow leaves open, from x
    x = np.cos(middle) * open_to - np.sin(middle) * np.cross(z, open_to)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _ball(rings: int = 7, around: int = 20) -> Array:
    """Points (k, 3) of the unit sphere."""
    heights = np.linspace(0.0, np.pi, rings + 2)[1:-1]
    angles = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    points = [(0.0, 0.0, 1.0)]
    for height in heights:
        ring = np.sin(height)
        points += [(ring * np.cos(a), ring * np.sin(a), np.cos(height)) for a in angles]
    points.append((0.0, 0.0, -1.0))
    return np.array(points)


_BALL: Final = _ball()
