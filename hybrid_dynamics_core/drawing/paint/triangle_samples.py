"""Samples of an image that triangles cover, with their depths."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ...scene.visuals.primitives import Faces

_STEP: Final = 0.7  # [samples] distance of points on a triangle, to hit every sample
_CHUNK: Final = 2_000_000  # points processed at once
_BAND: Final = 200_000  # samples processed at once
_LARGE: Final = 4000.0  # samples of a parallelogram: triangles of half of it are filled by rows
_SLENDER: Final = 8.0  # samples of the bounding rectangle by those of the parallelogram


def are_large(vertices: Array, faces: Faces) -> NDArray[np.bool_]:
    """Mask (m,) of triangles that `bands` samples faster than `points_on`.

    Args:
        vertices: (k, 3) vertices, the first two coordinates in samples.
        faces: (m, 3) indices of the vertices of each triangle.
    """
    corners = vertices[faces][:, :, :2]
    width, height = np.ptp(corners, axis=1).T
    area = np.abs(_cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    return np.asarray((area > _LARGE) & (width * height < _SLENDER * area))


def bands(corners: Array, shape: tuple[int, int]) -> Iterator[tuple[slice, slice, Array]]:
    """Sample a triangle row by row.

    A sample belongs to the triangle where the triangle touches it, also beside the centre.

    Args:
        corners: (3, 3) corners, the first two coordinates in samples.
        shape: rows and columns of the image.

    Yields:
        Rows and columns of a band, and the depths there; outside the triangle -inf.
    """
    origin = corners[0]
    gradient = _depth_gradient(corners)
    lowest, highest = corners[:, 2].min(), corners[:, 2].max()
    columns = _range(corners[:, 0], shape[1])
    rows = _range(corners[:, 1], shape[0])
    x = np.arange(columns.start, columns.stop) + 0.5
    step = max(1, _BAND // len(x))
    for start in range(rows.start, rows.stop, step):
        band = slice(start, min(start + step, rows.stop))
        y = np.arange(band.start, band.stop)[:, None] + 0.5
        plane = origin[2] + gradient[0] * (x - origin[0]) + gradient[1] * (y - origin[1])
        depths = np.clip(plane, lowest, highest)  # those beside the triangle's edges too
        depths[_is_outside(corners[:, :2], x, y)] = -np.inf
        yield band, columns, depths


def _is_outside(corners: Array, x: Array, y: Array) -> NDArray[np.bool_]:
    """Mask (h, w) of samples that no part of a triangle touches.

    Args:
        corners: (3, 2) corners in samples.
        x: (w,) centres of samples.
        y: (h, 1) centres of samples.
    """
    sides = np.roll(corners, -1, axis=0) - corners
    turn = np.sign(_cross(sides[0], sides[1]))
    outside = np.zeros((len(y), len(x)), bool)
    for corner, side in zip(corners, turn * sides, strict=True):
        reach = 0.5 * np.abs(side).sum()  # of the corners of a sample
        outside |= side[0] * (y - corner[1]) + reach < side[1] * (x - corner[0])
    return outside


def _depth_gradient(corners: Array) -> Array:
    """Change (2,) of the depth in a triangle, per sample to the right and up."""
    sides = corners[1:] - corners[0]
    return np.asarray(np.linalg.solve(sides[:, :2], sides[:, 2]))


def _range(coordinates: Array, count: int) -> slice:
    """The samples between the least and the largest coordinate, of so many."""
    first = max(0, int(coordinates.min()))
    last = min(count - 1, int(coordinates.max()))
    return slice(first, last + 1)


def _cross(one: Array, other: Array) -> Array:
    """Cross products (...) of vectors (..., 2) in a plane."""
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])


def points_on(vertices: Array, faces: Faces) -> Iterator[tuple[Faces, Array]]:
    """Points on triangles, closer together than samples of the image.

    Args:
        vertices: (k, 3) vertices, the first two coordinates in samples.
        faces: (m, 3) indices of the vertices of each triangle.

    Yields:
        Indices (n,) of triangles, and points (n, 3) on them.
    """
    corners = _longest_first(vertices[faces])
    first, second, third = corners[:, 0], corners[:, 1], corners[:, 2]
    base = second[:, :2] - first[:, :2]
    length = np.linalg.norm(base, axis=1)
    side = third[:, :2] - first[:, :2]
    area = np.abs(base[:, 0] * side[:, 1] - base[:, 1] * side[:, 0])
    height = area / np.maximum(length, 1e-12)
    columns = _round_counts(length / _STEP)
    rows = _round_counts(height / _STEP)
    for kind in np.unique(np.stack([columns, rows], axis=1), axis=0):
        alike = np.flatnonzero((columns == kind[0]) & (rows == kind[1]))
        across, along = np.meshgrid(np.linspace(0, 1, kind[0] + 1), np.linspace(0, 1, kind[1] + 1))
        weights = np.stack([(1 - along) * (1 - across), (1 - along) * across, along], axis=2)
        weights = weights.reshape(-1, 3)
        step = max(1, _CHUNK // len(weights))
        for k in range(0, len(alike), step):
            some = alike[k : k + step]
            points = weights @ corners[some]
            yield np.repeat(some, len(weights)), points.reshape(-1, 3)


def _longest_first(corners: Array) -> Array:
    """Triangles (m, 3, 3), permuted so that the first side is the longest in the picture."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.argmax(np.linalg.norm(sides[:, :, :2], axis=2), axis=1)
    order = (longest[:, None] + np.arange(3)) % 3
    return np.asarray(np.take_along_axis(corners, order[:, :, None], axis=1))


def _round_counts(numbers: Array) -> Faces:
    """Numbers rounded up to few distinct integers, four per power of two."""
    powers = np.ceil(4.0 * np.log2(np.maximum(numbers, 1.0))) / 4.0
    return np.asarray(np.ceil(2.0**powers).astype(int))
