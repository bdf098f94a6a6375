"""Constant geometry of a description: rotations, axes, inertia tensors and their checks."""

from __future__ import annotations

import math

import numpy as np

from ..algebra.vector import constant
from .model import Array, frozen

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
TRIANGLE_SLACK = 1e-9  # relative: rounding of printed moments, not physics


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Fixed-axis roll, pitch, yaw [rad] as a rotation matrix (3, 3): Rz(yaw) Ry(pitch) Rx(roll), as in URDF."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return snapped(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_about(axis: Array, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit axis by an angle [rad]."""
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return snapped(np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * skew @ skew)


def snapped(matrix: list[list[float]] | Array) -> Array:
    """The matrix with rounding dust next to 0 and +-1 removed, read-only."""
    return frozen([constant(row) for row in matrix])


def unit_axis(axis: str | list[float]) -> Array:
    """A unit vector (3,) from 'x', '-y', ... or from a vector of any length. ValueError if it has none."""
    if isinstance(axis, str):
        sign = -1.0 if axis.startswith("-") else 1.0
        return frozen([sign * v for v in AXES[axis[-1]]])
    length = math.sqrt(sum(v * v for v in axis))
    if length == 0.0:
        raise ValueError("the axis has no length; give a direction such as [0, 0, 1]")
    return frozen(constant([v / length for v in axis]))


def rod_inertia(mass: float, axis: str, length: float) -> Array:
    """Slender uniform rod about its centre [kg m^2]."""
    moment = mass * length * length / 12.0
    return frozen(np.diag([0.0 if name == axis else moment for name in "xyz"]))


def check_inertia(inertia: Array) -> None:
    """ValueError unless the tensor can belong to a rigid body: symmetric, moments >= 0, triangle inequality."""
    if not np.array_equal(inertia, inertia.T):
        raise ValueError("the inertia matrix is not symmetric")
    moments = np.linalg.eigvalsh(inertia)
    slack = TRIANGLE_SLACK * max(float(moments[-1]), 1e-300)
    if moments[0] < -slack:
        raise ValueError(f"a principal moment of inertia is negative ({moments[0]:.6g} kg m^2)")
    if moments[0] + moments[1] < moments[2] - slack:
        a, b, c = (f"{m:.6g}" for m in moments)
        raise ValueError(
            f"no rigid body has principal moments {a}, {b}, {c}: two of them must add up to at least the third"
        )
