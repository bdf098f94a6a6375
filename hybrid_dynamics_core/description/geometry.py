"""Constant geometry of a description: rotations, axes, inertia tensors and their checks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..algebra.vector import constant
from ..ground.arrays import Array, frozen

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
TRIANGLE_SLACK = 1e-9  # relative: rounding of printed moments, not physics
IDENTITY = frozen(np.eye(3))


@dataclass(frozen=True, eq=False)
class Transform:
    """A pose: `rotation` (3, 3) and `translation` (3,) [m] take coordinates of the frame to those around it."""

    rotation: Array = field(default_factory=lambda: IDENTITY)
    translation: Array = field(default_factory=lambda: frozen(np.zeros(3)))

    def __matmul__(self, inner: Transform) -> Transform:
        """The pose of `inner`, which is given in this frame, in the frame around."""
        if self.is_identity():
            return inner
        return Transform(snapped(self.rotation @ inner.rotation), self.point(inner.translation))

    def point(self, point: Array) -> Array:
        """A point of this frame in the frame around."""
        if self.is_identity():
            return point
        return frozen(self.translation + self.rotation @ point)

    def is_identity(self) -> bool:
        """Whether nothing is moved at all."""
        return bool(np.array_equal(self.rotation, IDENTITY) and not self.translation.any())


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Fixed-axis roll, pitch, yaw [rad] as a rotation matrix (3, 3).

    Rz(yaw) Ry(pitch) Rx(roll), as in URDF.
    """
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return snapped(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_of(rotation: Array) -> Array:
    """Fixed-axis roll, pitch, yaw [rad] of a rotation matrix (3, 3): R = Rz(yaw) Ry(pitch) Rx(roll).

    Where the pitch is a right angle, only yaw - roll or yaw + roll is settled: the yaw is taken as
    zero.
    """
    level = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], level)
    if level < 1e-9:
        return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    return np.array([roll, pitch, math.atan2(rotation[1, 0], rotation[0, 0])])


def rotation_about(axis: Array, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit axis by an angle [rad]."""
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return snapped(np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * skew @ skew)


def snapped(matrix: list[list[float]] | Array) -> Array:
    """The matrix with rounding dust next to 0 and +-1 removed, read-only."""
    return frozen([constant(row) for row in matrix])


def unit_axis(axis: str | list[float]) -> Array:
    """A unit vector (3,) from 'x', '-y', ... or from a vector of any length.

    ValueError if it has none.
    """
    if isinstance(axis, str):
        sign = -1.0 if axis.startswith("-") else 1.0
        return frozen([sign * v for v in AXES[axis[-1]]])
    length = math.sqrt(sum(v * v for v in axis))
    if length == 0.0:
        raise ValueError("the axis has no length; give a direction such as [0, 0, 1]")
    return frozen(constant([v / length for v in axis]))


def rotation_to_axis(axis: Array) -> Array:
    """A rotation matrix (3, 3) whose z axis is the unit vector `axis`."""
    side = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = side - (side @ axis) * axis
    x /= np.linalg.norm(x)
    return snapped(np.column_stack([x, np.cross(axis, x), axis]))


def check_inertia(inertia: Array, relative: float) -> None:
    """ValueError unless the tensor can belong to a rigid body: symmetric, moments >= 0, triangle inequality.

    `relative`: what the printed numbers may be off, of the largest moment.
    """
    if not np.array_equal(inertia, inertia.T):
        raise ValueError("the inertia matrix is not symmetric")
    moments = np.linalg.eigvalsh(inertia)
    slack = relative * max(float(moments[-1]), 1e-300)
    if moments[0] < -slack:
        raise ValueError(f"a principal moment of inertia is negative ({moments[0]:.6g} kg m^2)")
    if moments[0] + moments[1] < moments[2] - slack:
        a, b, c = (f"{m:.6g}" for m in moments)
        raise ValueError(
            f"no rigid body has principal moments {a}, {b}, {c}: two of them must add up to at"
            " least the third"
        )


def rotation_from_quaternion(quaternion: Array) -> Array:
    """Rotation matrix (3, 3) of a quaternion w, x, y, z of any length above zero."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return snapped(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
