"""Sets of points: dimension of their span, end points, distinct points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..ground.arrays import Array

COINCIDENT: Final = 1e-6  # share of the mechanism's size: points closer than this coincide
FLAT: Final = 1e-5  # share of the largest singular value: a smaller one counts as zero
POINT: Final = 1e-12  # [m] singular value below which points coincide


def span_dimension(points: Array) -> int:
    """Dimension of the affine span of points (k, 3): 0 a point, 1 a line, 2 a plane, 3 space."""
    if len(points) < 2:
        return 0
    centred = points - points.mean(axis=0)
    values = np.linalg.svd(centred, compute_uv=False)
    if not values[0] > POINT:
        return 0
    least = FLAT * max(float(values[0]), POINT)
    return int((values > least).sum())


def ends_of_line(points: Array) -> Array:
    """(1 or 2, 3) the end points of collinear points."""
    if len(points) < 2:
        return points
    offsets = points - points[0]
    lengths = np.linalg.norm(offsets, axis=1)
    farthest = offsets[int(np.argmax(lengths))]
    along = offsets @ farthest
    first, last = int(np.argmin(along)), int(np.argmax(along))
    return points[[first, last]]


def distinct(points: Sequence[Array], size: float) -> Array:
    """(k, 3) points without duplicates; `size` is that of the mechanism [m]."""
    apart = COINCIDENT * size
    unique: list[Array] = []
    for point in points:
        if all(np.linalg.norm(point - other) > apart for other in unique):
            unique.append(point)
    return np.array(unique).reshape(-1, 3)
