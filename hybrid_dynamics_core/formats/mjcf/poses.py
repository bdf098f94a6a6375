"""Poses of a compiled model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra.rotations import canonical, quaternion
from ...description.geometry import (
    IDENTITY,
    Transform,
    rotation_from_quaternion,
    rpy_of,
    snapped,
)
from ...ground.arrays import Array, frozen


def pose_of(pos: Sequence[float], quat: Sequence[float]) -> Transform:
    """A pose from a position and a quaternion w, x, y, z; a zero quaternion is the identity."""
    return Transform(rotation_of(quat), frozen(pos))


def rotation_of(quat: Sequence[float]) -> Array:
    """The rotation (3, 3) of a quaternion w, x, y, z; a zero quaternion is the identity."""
    if not any(quat):
        return IDENTITY
    return snapped(rotation_from_quaternion(np.array(quat)))


def quat_entry(rotation: Array) -> list[float]:
    """A rotation (3, 3) as a quaternion x, y, z, w, for a description file."""
    return list(canonical(quaternion(rotation)))


def pose_entry(pose: Transform) -> dict[str, list[float]]:
    """The entry of a pose in a description file."""
    return {"xyz": pose.translation.tolist(), "rpy": rpy_of(pose.rotation).tolist()}
