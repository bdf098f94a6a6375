"""Poses: a position and a rotation, one or many."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.rotations import canonical, quaternion, rotation_matrix
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array

# largest deviation of a quaternion's norm from 1 that is accepted; it is normalised then
UNIT = 1e-3
# largest error of R^T R that is accepted: single-precision messages stay usable
ORTHONORMAL = 1e-6


@dataclass(frozen=True, eq=False)
class Pose:
    """The pose of a frame in the base frame, or a batch of N.

    Attributes:
        position: origin of the frame (3,) or (N, 3) [m].
        rotation: from frame coordinates to base coordinates, (3, 3) or (N, 3, 3).
    """

    position: Array
    rotation: Array

    @property
    def quaternion(self) -> Array:
        """Unit quaternion (x, y, z, w), of shape (4,) or (N, 4), with w >= 0."""
        return canonical(quaternion(self.rotation))

    @property
    def matrix(self) -> Array:
        """Homogeneous transform (4, 4) or (N, 4, 4) from frame coordinates to base coordinates."""
        rows = self.position.shape[:-1]
        matrix = np.zeros((*rows, 4, 4))
        matrix[..., :3, :3] = self.rotation
        matrix[..., :3, 3] = self.position
        matrix[..., 3, 3] = 1.0
        return matrix

    @staticmethod
    def from_quaternion(position: ArrayLike, quaternion: ArrayLike) -> Pose:
        """Make a pose from a position and a quaternion.

        Args:
            position: (3,) [m].
            quaternion: x, y, z, w (4,). Its norm must be 1 to `UNIT`; it is normalised.

        Raises:
            InputError: a shape is wrong, a value is not finite, or the norm is not 1.
        """
        xyzw = real_array("quaternion", quaternion)
        origin = real_array("position", position)
        if xyzw.shape != (4,):
            raise InputError(f"the quaternion has shape {xyzw.shape}; expected (4,): x, y, z, w")
        norm = float(np.linalg.norm(xyzw))
        if not abs(norm - 1.0) < UNIT:
            raise _not_normalised(xyzw, norm)
        return checked_pose(Pose(origin, rotation_matrix(xyzw)))


def _not_normalised(xyzw: Array, norm: float) -> InputError:
    values = ", ".join(f"{value:.6g}" for value in xyzw.tolist())
    hint = ""
    if 0.0 < norm < np.inf:
        hint = f"; divide it by {norm:.6g}"
    return InputError(
        f"the quaternion x, y, z, w = {values} has the norm {norm:.6g}; expected 1 to"
        f" {UNIT:g}{hint}"
    )


def checked_pose(pose: Pose) -> Pose:
    """The pose as float64 arrays.

    Raises:
        InputError: it is not one finite rigid pose.
    """
    position = np.asarray(pose.position, dtype=float)
    rotation = np.asarray(pose.rotation, dtype=float)
    if position.shape != (3,) or rotation.shape != (3, 3):
        raise InputError(
            f"expected a position (3,) and a rotation (3, 3), got {position.shape} and"
            f" {rotation.shape}"
        )
    finite = np.isfinite(position).all() and np.isfinite(rotation).all()
    if not finite:
        raise InputError("the pose is not finite")
    errors = rotation @ rotation.T - np.eye(3)
    is_orthonormal = np.abs(errors).max() <= ORTHONORMAL
    if not is_orthonormal or np.linalg.det(rotation) < 0.0:
        raise InputError("the rotation matrix is not orthonormal and right-handed")
    return Pose(position, rotation)


def rotation_vector(rotation: Array) -> Array:
    """Axis times angle [rad] of rotation matrices (N, 3, 3): (N, 3)."""
    vector: Array = _transform().from_matrix(rotation).as_rotvec()
    return vector


def _transform() -> Any:
    """SciPy's Rotation, imported late since it is slow and rarely needed."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    return Rotation
