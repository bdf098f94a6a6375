"""Quaternions of rotation matrices, and back. All are x, y, z, w."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ..ground.arrays import Array
from .scalar import Scalar, sqrt


def quaternion(rotation: Array) -> Array:
    """Unit quaternions with w >= 0 of rotation matrices.

    They are taken by way of their largest component, so that half turns keep all digits. Where w is
    zero, the largest component is positive. One matrix has the bits of a stack.

    Args:
        rotation: (3, 3) or (N, 3, 3).

    Returns:
        (4,) or (N, 4), each x, y, z, w.
    """
    if rotation.ndim == 2:
        return np.array(_one_quaternion(rotation))
    candidates: Array = np.array(_candidates(np.moveaxis(rotation, 0, -1)))
    squares = np.einsum("kkn->kn", candidates)
    largest = np.argmax(squares, axis=0)
    x, y, z, w = candidates[largest, :, np.arange(len(rotation))].T
    scale = np.copysign(1.0 / _length(x, y, z, w), w)
    return np.stack([scale * x, scale * y, scale * z, scale * w], axis=-1)


def _one_quaternion(rotation: Array) -> tuple[float, float, float, float]:
    """In floats: a message needs it quickly."""
    candidates = _candidates(rotation.tolist())
    squares = [candidates[k][k] for k in range(4)]
    x, y, z, w = candidates[squares.index(max(squares))]
    scale = math.copysign(1.0 / _length(x, y, z, w), w)
    return scale * x, scale * y, scale * z, scale * w


def canonical(quaternion: Array) -> Array:
    """One of the two quaternions of a rotation, always the same.

    The first component that is not zero is positive, in the order w, x, y, z.

    Args:
        quaternion: (..., 4), each x, y, z, w.

    Returns:
        (..., 4).
    """
    x, y, z, w = np.moveaxis(quaternion, -1, 0)
    leading = np.select([w != 0.0, x != 0.0, y != 0.0], [w, x, y], z)
    return np.asarray(np.copysign(1.0, leading)[..., None] * quaternion)


def rotation_angle(rotation: Array) -> float:
    """Angle [rad] of a rotation matrix (3, 3), from 0 to pi."""
    x, y, z, w = quaternion(rotation).tolist()
    return 2.0 * math.atan2(math.hypot(x, y, z), w)


def rotation_matrix(quaternion: Sequence[float] | Array) -> Array:
    """The rotation matrix (3, 3) of a quaternion x, y, z, w of any length above zero."""
    x, y, z, w = np.asarray(quaternion, dtype=float) / _length(*quaternion)
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    return np.array(
        [
            [xx - yy - zz + ww, 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), -xx + yy - zz + ww, 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), -xx - yy + zz + ww],
        ]
    )


def _candidates(rotation: Iterable[Iterable[Scalar]]) -> tuple[tuple[Scalar, ...], ...]:
    """Row k: 4 q_k times the quaternion q = x, y, z, w; (4, 4)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    xx = 1.0 + a - e - i
    yy = 1.0 - a + e - i
    zz = 1.0 - a - e + i
    ww = 1.0 + a + e + i
    return (
        (xx, b + d, c + g, h - f),
        (b + d, yy, f + h, c - g),
        (c + g, f + h, zz, d - b),
        (h - f, c - g, d - b, ww),
    )


def _length(x: Scalar, y: Scalar, z: Scalar, w: Scalar) -> Scalar:
    return sqrt(x * x + y * y + z * z + w * w)
