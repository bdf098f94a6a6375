"""Sets of points: what they span, their ends, the distinct ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..ground.arrays import Array

SAME: Final = 1e-6  # of the size of the mechanism: points nearer than this are one


def rank(points: Array) -> int:
    """Dimension of what points (k, 3) span: 0 one place, 1 a line, 2 a plane, 3 space."""
    if len(points) < 2:
        return 0
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return int((values > 1e-5 * max(float(values[0]), 1e-12)).sum()) if values[0] > 1e-12 else 0


def ends_of(points: Array) -> Array:
    """(1 or 2, 3): the ends of points on a line."""
    if len(points) < 2:
        return points
    along = points - points[0]
    way = along @ along[int(np.argmax(np.linalg.norm(along, axis=1)))]
    return points[[int(np.argmin(way)), int(np.argmax(way))]]


def distinct(points: Sequence[Array], size: float) -> Array:
    """(k, 3) points without those that are already there."""
    kept: list[Array] = []
    for point in points:
        if all(np.linalg.norm(point - other) > SAME * size for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 3)
