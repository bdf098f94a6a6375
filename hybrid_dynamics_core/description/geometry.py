"""Constant geometry of a description: poses, rotations, axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..algebra.independence import length
from ..algebra.rotations import rotation_matrix
from ..algebra.scalar import cos, sin, sqrt
from ..algebra.vector import constant
from ..ground.arrays import Array, frozen

IDENTITY = frozen(np.eye(3))
_ORIGIN = frozen(np.zeros(3))
_AXES = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
}
_ORTHONORMAL = 1e-13  # rounding of products of rotations
_GIMBAL_LOCK = 1e-9  # cosine of the pitch below which the axes of roll and yaw coincide


@dataclass(frozen=True, eq=False)
class Transform:
    """The pose of an inner frame in an outer frame; it takes inner to outer coordinates.

    Attributes:
        rotation: (3, 3).
        translation: (3,) [m].
    """

    rotation: Array = field(default_factory=lambda: IDENTITY)
    translation: Array = field(default_factory=lambda: _ORIGIN)

    def __matmul__(self, inner: Transform) -> Transform:
        """The pose in the outer frame of `inner`, a pose in the inner frame."""
        if self.is_identity():
            return inner
        rotation = snapped(self.rotation @ inner.rotation)
        return Transform(rotation, self.point(inner.translation))

    def point(self, point: Array) -> Array:
        """A point (3,) [m] of the inner frame, in outer coordinates."""
        if self.is_identity():
            return point
        return frozen(self.translation + self.rotation @ point)

    def inverse(self) -> Transform:
        """The pose of the outer frame in the inner frame."""
        rotation = self.rotation.T
        return Transform(frozen(rotation), frozen(-(rotation @ self.translation)))

    def is_identity(self) -> bool:
        """Whether rotation and translation are exactly the identity."""
        is_turned = not np.array_equal(self.rotation, IDENTITY)
        is_shifted = self.translation.any()
        return not (is_turned or is_shifted)


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation matrix (3, 3) of fixed-axis roll, pitch, yaw [rad]: Rz(yaw) Ry(pitch) Rx(roll).

    This is the convention of URDF.
    """
    cr = cos(roll)
    sr = sin(roll)
    cp = cos(pitch)
    sp = sin(pitch)
    cy = cos(yaw)
    sy = sin(yaw)
    return snapped(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_of(rotation: Array) -> Array:
    """Fixed-axis roll, pitch, yaw (3,) [rad] of a rotation matrix (3, 3).

    At a pitch of +-pi/2 only yaw - roll, or yaw + roll, is determined. The yaw is then zero.
    """
    cos_pitch = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], cos_pitch)
    if cos_pitch < _GIMBAL_LOCK:
        roll = math.atan2(-rotation[1, 2], rotation[1, 1])
        return np.array([roll, pitch, 0.0])
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    return np.array([roll, pitch, yaw])


def rotation_about(axis: Array, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit axis (3,) by an angle [rad]."""
    x, y, z = axis
    skew = np.array(
        [
            [0, -z, y],
            [z, 0, -x],
            [-y, x, 0],
        ]
    )
    sine = sin(angle)
    versine = 1.0 - cos(angle)
    # Rodrigues' formula
    return snapped(np.eye(3) + sine * skew + versine * skew @ skew)


def rotation_with_z_axis(axis: Array) -> Array:
    """A rotation matrix (3, 3) whose z axis is the unit vector `axis` (3,)."""
    # the coordinate axis farthest from parallel, to avoid cancellation
    farthest = int(np.argmin(np.abs(axis)))
    side = np.eye(3)[farthest]
    x = side - (side @ axis) * axis
    x = x / length(x)
    y = np.cross(axis, x)
    return snapped(np.column_stack([x, y, axis]))


def rpy_to_axis(axis: Array) -> list[float]:
    """Roll, pitch, yaw [rad] of a frame whose z axis is a unit vector (3,)."""
    angles: list[float] = rpy_of(rotation_with_z_axis(axis)).tolist()
    return angles


def rotation_from_quaternion(quaternion: Array) -> Array:
    """Rotation matrix (3, 3) of a quaternion w, x, y, z of any length above zero."""
    w, x, y, z = quaternion / np.max(np.abs(quaternion))  # so that no square overflows
    return snapped(rotation_matrix((x, y, z, w)))


def nearest_rotation(matrix: Array) -> Array:
    """The rotation matrix (3, 3) nearest to a matrix of rounded numbers.

    A matrix that is a rotation up to the last digits is returned unchanged.
    """
    if np.abs(matrix @ matrix.T - IDENTITY).max() <= _ORTHONORMAL:
        return snapped(matrix)
    left, _, right = np.linalg.svd(matrix)
    return snapped(left @ right)


def snapped(matrix: Sequence[Sequence[float]] | Array) -> Array:
    """A read-only copy; entries within rounding of 0 or +-1 are made exact."""
    return frozen([constant(row) for row in matrix])


def unit_axis(axis: str | list[float]) -> Array:
    """A unit vector (3,) from 'x', '-y' and the like, or from a vector of any length.

    Raises:
        ValueError: the vector has no length.
    """
    if isinstance(axis, str):
        sign = -1.0 if axis.startswith("-") else 1.0
        letter = axis[-1]
        return frozen([sign * component for component in _AXES[letter]])
    size = sqrt(sum(component * component for component in axis))
    if size == 0.0:
        raise ValueError("the axis has no length; give a direction such as [0, 0, 1]")
    return frozen(constant([component / size for component in axis]))
