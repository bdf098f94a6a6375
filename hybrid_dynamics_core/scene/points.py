"""Sets of points: what they span, their ends, the distinct ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..ground.arrays import Array

COINCIDENT: Final = 1e-6  # of the size of the mechanism: points nearer than this are one
FLAT: Final = 1e-5  # of the largest singular value: a smaller one spans no direction
POINT: Final = 1e-12  # [m] largest singular value of points at one place


def span_dimension(points: Array) -> int:
    """Dimension of what points (k, 3) span: 0 one place, 1 a line, 2 a plane, 3 space."""
    if len(points) < 2:
        return 0
    centred = points - points.mean(axis=0)
    values = np.linalg.svd(centred, compute_uv=False)
    if not values[0] > POINT:
        return 0
    least = FLAT * max(float(values[0]), POINT)
    return int((values > least).sum())


def ends_of_line(points: Array) -> Array:
    """(1 or 2, 3): the ends of points on a line."""
    if len(points) < 2:
        return points
    offsets = points - points[0]
    lengths = np.linalg.norm(offsets, axis=1)
    farthest = offsets[int(np.argmax(lengths))]
    along = offsets @ farthest
    first, last = int(np.argmin(along)), int(np.argmax(along))
    return points[[first, last]]


def distinct(points: Sequence[Array], size: float) -> Array:
    """(k, 3) points without those that are already there; `size` is that of the mechanism [m]."""
    apart = COINCIDENT * size
    unique: list[Array] = []
    for point in points:
        if all(np.linalg.norm(point - other) > apart for other in unique):
            unique.append(point)
    return np.array(unique).reshape(-1, 3)
