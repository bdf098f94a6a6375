"""Tensors and rotations in the process that compiles MJCF.

The worker loads this file by its path. It imports only MuJoCo and NumPy.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np


def tensor_of(full: Any) -> Any:
    """The tensor (3, 3) of the six numbers xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = full
    entries = [
        [xx, xy, xz],
        [xy, yy, yz],
        [xz, yz, zz],
    ]
    return np.array(entries)


def rotation_of(quaternion: Any) -> Any:
    """The rotation (3, 3) of a quaternion w, x, y, z."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
