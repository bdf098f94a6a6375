"""Triangle meshes: bodies of revolution, rounded hulls of points, arrows.

Lengths are in [m]. Meshes have no colours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull

from ..ground.arrays import Array
from ..scene.parts import across_axis
from ..scene.visuals.primitives import Faces, joined, revolved

AROUND: Final = 40  # corners of a circle
CHAMFER: Final = 0.12  # share of the radius, at edges of bodies of revolution
# of an arrow around an axis
SWEEP: Final = 4.6  # [rad] its angle
_HEAD: Final = 0.55  # [rad] angle of its head
_AROUND_RING: Final = 16  # corners of its cross section

Corner = tuple[float, float]  # (radius, height)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh.

    Attributes:
        vertices: (k, 3) corners.
        faces: (m, 3) indices of corners, counterclockwise as seen from outside.
    """

    vertices: Array
    faces: Faces

    def placed(self, rotation: Array, origin: Array) -> Mesh:
        """The mesh rotated by `rotation` (3, 3), then moved by `origin` (3,)."""
        return Mesh(self.vertices @ rotation.T + origin, self.faces)


def join_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    parts = [(mesh.vertices, mesh.faces) for mesh in meshes]
    return Mesh(*joined(parts))


# -- bodies of revolution


def body_of_revolution(profile: Sequence[Corner]) -> Mesh:
    """A body of revolution about z from a profile, given from bottom to top.

    Each piece of the profile has its own vertices, so that edges stay sharp in smooth shading.

    Args:
        profile: corners (radius, height).

    Returns:
        The body.
    """
    pieces = [revolved(np.array(piece), AROUND) for piece in pairwise(profile)]
    return Mesh(*joined(pieces))


def _triangles(first: Faces, second: Faces, third: Faces) -> Faces:
    """(m, 3) of three corners (m,) each."""
    return np.stack([first, second, third], axis=1)


def cylinder(radius: float, start: Array, end: Array) -> Mesh:
    """A cylinder with chamfered edges between two points (3,)."""
    length = float(np.linalg.norm(end - start))
    edge = CHAMFER * min(radius, length)
    inner, upper = radius - edge, length - edge
    bottom = [(0.0, 0.0), (inner, 0.0), (radius, edge)]
    top = [(radius, upper), (inner, length), (0.0, length)]
    return body_of_revolution(bottom + top).placed(frame_along(end - start), start)


def tube(radius: float) -> Mesh:
    """A cylinder along z from 0 to 1, for scaling."""
    bottom = [(0.0, 0.0), (radius, 0.0)]
    top = [(radius, 1.0), (0.0, 1.0)]
    return body_of_revolution(bottom + top)


def arrow(radius: float) -> Mesh:
    """An arrow along z from 0 to 1: a shaft and a head."""
    shaft = [(0.0, 0.0), (radius, 0.0), (radius, 0.68)]
    head = [(2.4 * radius, 0.68), (0.0, 1.0)]
    return body_of_revolution(shaft + head)


# -- other bodies


def rounded(points: Array, radius: float) -> Mesh:
    """The hull of balls around points (k, 3): a ball, a capsule, a plate with round edges."""
    balls = points[:, None] + radius * _BALL[None]
    corners = balls.reshape(-1, 3)
    hull = ConvexHull(corners)
    faces = np.array(hull.simplices, dtype=np.int64)
    a, b, c = (corners[indices] for indices in faces.T)
    normals = np.cross(b - a, c - a)
    outward = np.einsum("ij,ij->i", normals, hull.equations[:, :3])
    inward = outward < 0.0
    faces[inward] = faces[inward][:, ::-1]
    used, indices = np.unique(faces, return_inverse=True)
    return Mesh(corners[used], indices.reshape(faces.shape))


def ring_arrow(radius: float) -> Mesh:
    """An arrow around z on a unit circle, counterclockwise from x by the angle SWEEP."""
    angles = np.linspace(0.0, SWEEP, 49)
    neck = SWEEP - _HEAD
    rings = [_ring(0.0, 0.0)]
    rings += [_ring(float(angle), radius) for angle in angles if angle <= neck]
    rings.append(_ring(neck, 2.6 * radius))
    rings.append(_ring(SWEEP, 0.0))
    pieces = [_ring_piece(low, high) for low, high in pairwise(rings)]
    return join_meshes(pieces)


def _ring(angle: float, size: float) -> Array:
    """(k, 3) a circle of radius `size`, normal to the unit circle at an angle."""
    angles = np.linspace(0.0, 2.0 * np.pi, _AROUND_RING + 1)
    around = angles[:-1, None]
    outward = np.array([np.cos(angle), np.sin(angle), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    across = outward * (1.0 + size * np.cos(around))
    return np.asarray(across + up * size * np.sin(around))


def _ring_piece(low: Array, high: Array) -> Mesh:
    """The surface between two cross sections."""
    count = len(low)
    here = np.arange(count)
    after = (here + 1) % count
    first = _triangles(here, count + after, after)
    second = _triangles(here, count + here, count + after)
    faces = np.vstack([first, second])
    return Mesh(np.vstack([low, high]), faces)


# -- frames


def frame_along(direction: Array) -> Array:
    """(3, 3) a rotation whose z axis is along a direction (3,)."""
    axis = direction / np.linalg.norm(direction)
    return np.stack([*across_axis(axis), axis], axis=1)


def frame_open(axis: Array, toward: Array) -> Array:
    """(3, 3) a rotation with z along an axis (3,), for a ring arrow.

    The gap of the ring is towards a direction (3,) normal to the axis.
    """
    z = axis / np.linalg.norm(axis)
    open_to = toward / np.linalg.norm(toward)
    middle = 0.5 * (SWEEP + 2.0 * np.pi)  # middle of the gap, from x
    across = np.cross(z, open_to)
    x = np.cos(middle) * open_to - np.sin(middle) * across
    return np.stack([x, np.cross(z, x), z], axis=1)


def _ball(rings: int = 7, around: int = 20) -> Array:
    """Points (k, 3) of the unit sphere."""
    polar_angles = np.linspace(0.0, np.pi, rings + 2)[1:-1]
    angles = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    points = [(0.0, 0.0, 1.0)]
    for polar_angle in polar_angles:
        radius, z = np.sin(polar_angle), np.cos(polar_angle)
        points += [(radius * np.cos(a), radius * np.sin(a), z) for a in angles]
    points.append((0.0, 0.0, -1.0))
    return np.array(points)


_BALL: Final = _ball()
