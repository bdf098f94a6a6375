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
    """A pose from a place and a quaternion w, x, y, z; zeros stand for no turn, as in MuJoCo."""
    return Transform(rotation_of(quat), frozen(pos))


def rotation_of(quat: Sequence[float]) -> Array:
    """The rotation (3, 3) of a quaternion w, x, y, z; zeros stand for no turn, as in MuJoCo."""
    if not any(quat):
        return IDENTITY
    return snapped(rotation_from_quaternion(np.array(quat)))


def quat_entry(rotation: Array) -> list[float]:
    """A rotation (3, 3) as a description file has it: x, y, z, w."""
    return list(canonical(quaternion(rotation)))


def pose_entry(pose: Transform) -> dict[str, list[float]]:
    """A pose as a description file has it."""
    return {"xyz": pose.translation.tolist(), "rpy": rpy_of(pose.rotation).tolist()}
