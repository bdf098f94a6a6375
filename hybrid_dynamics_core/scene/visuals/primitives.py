"""Primitive shapes as triangles, counterclockwise seen from outside.

Vertices at sharp edges are duplicated, so that smooth shading preserves the edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array

Faces = NDArray[np.int64]
Triangles = tuple[Array, Faces]  # vertices (k, 3), and their indices by triangle (m, 3)
_AROUND: Final = 48  # corners of a circle
_RINGS: Final = 12  # rings between the equator and a pole


def triangles_of(shape: str, size: Sequence[float]) -> Triangles:
    """The surface of a primitive shape, centred at the origin.

    Args:
        shape: box, cylinder, sphere, capsule or ellipsoid.
        size: its sizes, as in `Visual` [m].
    """
    if shape == "box":
        return _box(0.5 * np.array(size))
    if shape == "cylinder":
        radius, length = size
        half = 0.5 * length
        rims = np.array([[radius, -half], [radius, half]])
        side = revolved(rims)
        bottom = revolved(np.array([[0.0, -half], [radius, -half]]))
        top = revolved(np.array([[radius, half], [0.0, half]]))
        return joined([side, bottom, top])
    if shape == "capsule":
        radius, length = size
        return _ball(radius, 0.5 * length)
    vertices, faces = _ball(1.0, 0.0)
    return vertices * np.array(size), faces


def _box(half: Array) -> Triangles:
    """A box, from half of its edges (3,)."""
    x, y, z = np.eye(3)
    sides: list[Triangles] = []
    # u, v and the outward normal are right-handed
    for u, v, normal in ((x, y, z), (y, z, x), (z, x, y), (y, x, -z), (z, y, -x), (x, z, -y)):
        corners = [normal - u - v, normal + u - v, normal + u + v, normal - u + v]
        faces = np.array([[0, 1, 2], [0, 2, 3]])
        sides.append((np.array(corners) * half, faces))
    return joined(sides)


def _ball(radius: float, half: float) -> Triangles:
    """A sphere, with its halves moved by `half` along z in opposite directions."""
    angles = np.linspace(-0.5 * np.pi, 0.0, _RINGS + 1)
    lower = np.stack([radius * np.cos(angles), radius * np.sin(angles) - half], axis=1)
    upper = lower[::-1] * (1.0, -1.0)
    return revolved(np.vstack([lower, upper]))


def revolved(profile: Array, around: int = _AROUND) -> Triangles:
    """A surface of revolution about z.

    Args:
        profile: radii and heights (n, 2), from bottom to top [m].
        around: number of corners of a circle.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    radii, heights = profile.T
    x = np.outer(radii, np.cos(angles))
    y = np.outer(radii, np.sin(angles))
    z = np.repeat(heights[:, None], around, axis=1)
    vertices = np.stack([x, y, z], axis=2).reshape(-1, 3)
    # vertices come ring by ring; two triangles join each one to the ring above
    here = np.arange(len(vertices) - around)
    ring, corner = np.divmod(here, around)
    beside = ring * around + (corner + 1) % around
    lower = np.stack([here, beside, beside + around], axis=1)
    upper = np.stack([here, beside + around, here + around], axis=1)
    # a ring without radius is a tip, whose triangles have no area
    has_radius = radii > 0.0
    return vertices, np.vstack([lower[has_radius[ring]], upper[has_radius[ring + 1]]])


def joined(parts: Sequence[Triangles]) -> Triangles:
    """Several surfaces as one."""
    faces: list[Faces] = []
    start = 0
    for vertices, indices in parts:
        faces.append(indices + start)
        start += len(vertices)
    return np.vstack([vertices for vertices, _ in parts]), np.vstack(faces)
