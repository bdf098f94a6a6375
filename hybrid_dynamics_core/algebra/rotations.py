"""Quaternions of rotation matrices, and back. All are x, y, z, w."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ..ground.arrays import Array
from .live import stacked
from .scalar import Scalar, sqrt


def quaternion(rotation: Array) -> Array:
    """Unit quaternions with w >= 0 of rotation matrices.

    The largest component is computed first, so that half turns keep all digits. Where w is zero,
    the largest component is positive. A single matrix and a stack give the same bits.

    Args:
        rotation: (3, 3) or (N, 3, 3).

    Returns:
        (4,) or (N, 4), each x, y, z, w.
    """
    if rotation.ndim == 2:
        return np.array(_one_quaternion(rotation))
    entries = np.moveaxis(rotation, 0, -1)
    candidates: Array = np.array(_candidates(entries))
    squares = np.einsum("kkn->kn", candidates)
    largest = np.argmax(squares, axis=0)
    matrices = np.arange(len(rotation))
    x, y, z, w = candidates[largest, :, matrices].T
    scale = np.copysign(1.0 / _length(x, y, z, w), w)
    return np.stack(_times(scale, x, y, z, w), axis=-1)


def _one_quaternion(rotation: Array) -> list[float]:
    """The quaternion of one matrix, in floats: quicker than NumPy, for messages."""
    candidates = _candidates(rotation.tolist())
    squares = [candidates[k][k] for k in range(4)]
    x, y, z, w = candidates[squares.index(max(squares))]
    scale = math.copysign(1.0 / _length(x, y, z, w), w)
    return _times(scale, x, y, z, w)


def _times(scale: Scalar, *components: Scalar) -> list[Scalar]:
    return [scale * component for component in components]


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
    x, y, z, w = stacked(quaternion) / _length(*quaternion)
    xx, xy, xz, xw = x * x, x * y, x * z, x * w
    yy, yz, yw = y * y, y * z, y * w
    zz, zw = z * z, z * w
    ww = w * w
    return np.array(
        [
            [xx - yy - zz + ww, 2.0 * (xy - zw), 2.0 * (xz + yw)],
            [2.0 * (xy + zw), -xx + yy - zz + ww, 2.0 * (yz - xw)],
            [2.0 * (xz - yw), 2.0 * (yz + xw), -xx - yy + zz + ww],
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
