"""Triangle meshes: turned bodies with sharp edges, rounded bodies round points, arrows.

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
CHAMFER: Final = 0.12  # of the radius, at the edges of turned bodies


@dataclass(frozen=True, eq=False)
class Mesh:
    """Corners (k, 3) and triangles (m, 3) that turn counterclockwise as seen from outside."""

    vertices: Array
    faces: NDArray[np.int64]

    def placed(self, rotation: Array, origin: Array) -> Mesh:
        """The mesh moved: `rotation` (3, 3) of its axes, then `origin` (3,)."""
        return Mesh(self.vertices @ rotation.T + origin, self.faces)


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
    return Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))


def turned(profile: Sequence[tuple[float, float]]) -> Mesh:
    """A body turned about z from a profile of (radius, height), from the bottom to the top, outside to the right.

    Every piece of the profile has corners of its own, so that its edges stay sharp in smooth
    shading.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    here = np.arange(AROUND)
    after = (here + 1) % AROUND
    rings = []
    for (r0, z0), (r1, z1) in pairwise(profile):
        low = np.column_stack([r0 * circle, np.full(AROUND, z0)])
        high = np.column_stack([r1 * circle, np.full(AROUND, z1)])
        faces = []
        if r0 > 0.0:
            faces.append(np.stack([here, after, AROUND + after], axis=1))
        if r1 > 0.0:
            faces.append(np.stack([here, AROUND + after, AROUND + here], axis=1))
        if r1 == 0.0:
            faces = [np.stack([here, after, AROUND + here], axis=1)]
        rings.append(Mesh(np.vstack([low, high]), np.vstack(faces)))
    return joined(rings)


def cylinder(radius: float, start: Array, end: Array) -> Mesh:
    """A cylinder with broken edges between two points (3,)."""
    length = float(np.linalg.norm(end - start))
    edge = CHAMFER * min(radius, length)
    bottom = [(0.0, 0.0), (radius - edge, 0.0), (radius, edge)]
    top = [(radius, length - edge), (radius - edge, length), (0.0, length)]
    return turned(bottom + top).placed(frame_along(end - start), start)


def tube(radius: float) -> Mesh:
    """A cylinder along z from 0 to 1, to be stretched."""
    return turned([(0.0, 0.0), (radius, 0.0), (radius, 1.0), (0.0, 1.0)])


def rounded(points: Array, radius: float) -> Mesh:
    """The hull of balls round points (k, 3): a ball, a capsule, a plate with round edges."""
    corners = (points[:, None] + radius * _BALL[None]).reshape(-1, 3)
    hull = ConvexHull(corners)
    faces = np.array(hull.simplices, dtype=np.int64)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    used, names = np.unique(faces, return_inverse=True)
    return Mesh(corners[used], names.reshape(faces.shape))


def arrow(radius: float) -> Mesh:
    """An arrow along z from 0 to 1: a shaft and a head."""
    return turned([(0.0, 0.0), (radius, 0.0), (radius, 0.68), (2.4 * radius, 0.68), (0.0, 1.0)])


def turn_arrow(radius: float) -> Mesh:
    """An arrow round z on a circle of radius 1, counterclockwise from x over SWEEP."""
    angles = np.linspace(0.0, SWEEP, 49)
    head = 0.55
    around = np.linspace(0.0, 2.0 * np.pi, 17)[:-1]
    rings, sizes = [], np.where(angles <= SWEEP - head, radius, 0.0)
    places = [
        (float(angle), radius) for angle, size in zip(angles, sizes, strict=True) if size > 0.0
    ]
    places = [(0.0, 0.0), *places, (SWEEP - head, 2.6 * radius), (SWEEP, 0.0)]
    for angle, size in places:
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        ring = (
            out * (1.0 + size * np.cos(around)[:, None])
            + np.array([0.0, 0.0, 1.0]) * size * np.sin(around)[:, None]
        )
        rings.append(ring)
    count, here = len(around), np.arange(len(around))
    after = (here + 1) % count
    pieces = []
    for low, high in pairwise(rings):
        faces = [
            np.stack([here, count + after, after], axis=1),
            np.stack([here, count + here, count + after], axis=1),
        ]
        pieces.append(Mesh(np.vstack([low, high]), np.vstack(faces)))
    return joined(pieces)


def frame_along(direction: Array) -> Array:
    """(3, 3) a rotation whose z axis is along a direction (3,)."""
    axis = direction / np.linalg.norm(direction)
    return np.stack([*across_axis(axis), axis], axis=1)


def frame_open(axis: Array, toward: Array) -> Array:
    """(3, 3) a rotation whose z axis is along an axis (3,); a turn arrow is open toward a direction (3,) across it."""
    z, open_to = axis / np.linalg.norm(axis), toward / np.linalg.norm(toward)
    middle = 0.5 * (SWEEP + 2.0 * np.pi)  # of what the arrow leaves open, from x
    x = np.cos(middle) * open_to - np.sin(middle) * np.cross(z, open_to)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _ball(rings: int = 7, around: int = 20) -> Array:
    """Points (k, 3) of the unit sphere."""
    heights = np.linspace(0.0, np.pi, rings + 2)[1:-1]
    angles = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    points = [
        (np.sin(h) * np.cos(a), np.sin(h) * np.sin(a), np.cos(h)) for h in heights for a in angles
    ]
    return np.array([(0.0, 0.0, 1.0), *points, (0.0, 0.0, -1.0)])


_BALL: Final = _ball()
