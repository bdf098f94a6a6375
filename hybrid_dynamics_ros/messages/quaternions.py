"""Unit quaternions of rotation matrices, of one or of many."""

from __future__ import annotations

from typing import Any

import numpy as np

from .joint_samples import FloatArray

Entry = Any  # float, or an array with one entry a matrix


def quaternion(rotation: FloatArray) -> FloatArray:
    """Unit quaternions x, y, z, w with w >= 0 of rotation matrices.

    They are found by way of their largest component.

    Args:
        rotation: (3, 3) or (N, 3, 3).

    Returns:
        (4,) or (N, 4).
    """
    if rotation.ndim == 2:
        squares, candidates = _candidates(rotation.tolist())
        largest = max(range(4), key=squares.__getitem__)
        x, y, z, w = candidates[largest]
    else:
        squares, candidates = _candidates(np.moveaxis(rotation, 0, -1))
        largest_of = np.argmax(np.array(squares), axis=0)
        x, y, z, w = np.array(candidates)[largest_of, :, np.arange(len(rotation))].T
    size = np.sqrt(x * x + y * y + z * z + w * w)
    scale = np.copysign(1.0 / size, w)
    return np.array([scale * x, scale * y, scale * z, scale * w]).T


def _candidates(rotation: Any) -> tuple[tuple[Entry, ...], tuple[tuple[Entry, ...], ...]]:
    """4 x^2, 4 y^2, 4 z^2 and 4 w^2; and the quaternion times 4 x, 4 y, 4 z and 4 w."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    x_square = 1.0 + a - e - i
    y_square = 1.0 - a + e - i
    z_square = 1.0 - a - e + i
    w_square = 1.0 + a + e + i
    xy, xz, yz = b + d, c + g, f + h
    xw, yw, zw = h - f, c - g, d - b
    candidates = (
        (x_square, xy, xz, xw),
        (xy, y_square, yz, yw),
        (xz, yz, z_square, zw),
        (xw, yw, zw, w_square),
    )
    return (x_square, y_square, z_square, w_square), candidates
