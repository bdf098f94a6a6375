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
    first = corners[:, 1] - corners[:, 0]
    second = corners[:, 2] - corners[:, 0]
    area = np.abs(_cross(first, second))
    is_large = area > _LARGE
    is_wide = width * height < _SLENDER * area
    return np.asarray(is_large & is_wide)


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
    lowest = corners[:, 2].min()
    highest = corners[:, 2].max()
    columns = _range(corners[:, 0], shape[1])
    rows = _range(corners[:, 1], shape[0])
    x = np.arange(columns.start, columns.stop) + 0.5
    step = max(1, _BAND // len(x))
    for start in range(rows.start, rows.stop, step):
        band = slice(start, min(start + step, rows.stop))
        y = np.arange(band.start, band.stop)[:, None] + 0.5
        right = gradient[0] * (x - origin[0])
        up = gradient[1] * (y - origin[1])
        plane = origin[2] + right + up
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
        up = side[0] * (y - corner[1])
        right = side[1] * (x - corner[0])
        outside |= up + reach < right
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
    forth = one[..., 0] * other[..., 1]
    back = one[..., 1] * other[..., 0]
    return np.asarray(forth - back)


def points_on(vertices: Array, faces: Faces) -> Iterator[tuple[Faces, Array]]:
    """Points on triangles, closer together than samples of the image.

    Args:
        vertices: (k, 3) vertices, the first two coordinates in samples.
        faces: (m, 3) indices of the vertices of each triangle.

    Yields:
        Indices (n,) of triangles, and points (n, 3) on them.
    """
    corners = _longest_first(vertices[faces])
    in_picture = corners[:, :, :2]
    base = in_picture[:, 1] - in_picture[:, 0]
    side = in_picture[:, 2] - in_picture[:, 0]
    length = np.linalg.norm(base, axis=1)
    area = np.abs(_cross(base, side))
    height = area / np.maximum(length, 1e-12)
    columns = _round_counts(length / _STEP)
    rows = _round_counts(height / _STEP)
    kinds = np.stack([columns, rows], axis=1)
    for kind in np.unique(kinds, axis=0):
        is_alike = (columns == kind[0]) & (rows == kind[1])
        alike = np.flatnonzero(is_alike)
        weights = _grid_weights(*kind)
        step = max(1, _CHUNK // len(weights))
        for k in range(0, len(alike), step):
            some = alike[k : k + step]
            points = weights @ corners[some]
            yield np.repeat(some, len(weights)), points.reshape(-1, 3)


def _grid_weights(columns: int, rows: int) -> Array:
    """Weights (n, 3) of a triangle's corners at the points of a grid over it."""
    across, along = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    first = (1 - along) * (1 - across)
    second = (1 - along) * across
    weights = np.stack([first, second, along], axis=2)
    return weights.reshape(-1, 3)


def _longest_first(corners: Array) -> Array:
    """Triangles (m, 3, 3), permuted so that the first side is the longest in the picture."""
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(sides[:, :, :2], axis=2)
    longest = np.argmax(lengths, axis=1)
    order = (longest[:, None] + np.arange(3)) % 3
    permuted = np.take_along_axis(corners, order[:, :, None], axis=1)
    return np.asarray(permuted)


def _round_counts(numbers: Array) -> Faces:
    """Numbers rounded up to few distinct integers, four per power of two."""
    powers = np.log2(np.maximum(numbers, 1.0))
    rounded = np.ceil(4.0 * powers) / 4.0
    counts = np.ceil(2.0**rounded)
    return np.asarray(counts.astype(int))
