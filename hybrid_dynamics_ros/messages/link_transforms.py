"""Where each link is in the one before it. Knows no ROS."""

from __future__ import annotations

from typing import Any

import numpy as np

from hybrid_dynamics_core import Robot

from .joint_samples import FloatArray


class LinkTransforms:
    """Place and turn of every joint's child in its parent; elementwise, so that many states give the bits of one."""

    def __init__(self, robot: Robot) -> None:
        joints = [robot.description.joints[name] for name in robot.coordinates]
        self._turns = np.array([joint.type == "revolute" for joint in joints])
        self._fixed = np.array([quaternion(joint.rotation) for joint in joints])
        self._axis = np.array([joint.axis for joint in joints])
        self._places = np.array([joint.translation for joint in joints])
        self._slide = np.array(
            [
                np.zeros(3) if joint.type == "revolute" else joint.rotation @ joint.axis
                for joint in joints
            ]
        )

    def values(self, s: FloatArray) -> list[FloatArray]:
        """Translation [m] and unit quaternion x y z w of each joint's child in its parent, joint after joint.

        Args:
            s: all coordinates, (n_s,) or (N, n_s) [rad or m].
        """
        translations = self._places + self._slide * s[..., None]
        half = np.where(self._turns, 0.5 * s, 0.0)
        sine, cosine = np.sin(half), np.cos(half)
        a, b, c, d = self._fixed.T
        x, y, z = (component * sine for component in self._axis.T)
        quaternions = np.stack(
            [
                d * x + a * cosine + b * z - c * y,
                d * y + b * cosine + c * x - a * z,
                d * z + c * cosine + a * y - b * x,
                d * cosine - a * x - b * y - c * z,
            ],
            axis=-1,
        )
        # Of the two that are the same rotation, the one with w >= 0.
        quaternions = np.copysign(1.0, quaternions[..., 3:]) * quaternions
        slots: list[FloatArray] = []
        for k in range(len(self._places)):
            slots += [translations[..., k, :], quaternions[..., k, :]]
        return slots


def quaternion(rotation: FloatArray) -> FloatArray:
    """Unit quaternions x, y, z, w with w >= 0 of rotation matrices, by way of their largest component.

    Args:
        rotation: (3, 3) or (N, 3, 3).

    Returns:
        (4,) or (N, 4).
    """
    if rotation.ndim == 2:
        squares, columns = _candidates(rotation.tolist())
        x, y, z, w = columns[max(range(4), key=squares.__getitem__)]
    else:
        squares, columns = _candidates(np.moveaxis(rotation, 0, -1))
        largest = np.argmax(np.array(squares), axis=0)
        x, y, z, w = np.array(columns)[largest, :, np.arange(len(rotation))].T
    scale = np.copysign(1.0 / np.sqrt(x * x + y * y + z * z + w * w), w)
    return np.array([scale * x, scale * y, scale * z, scale * w]).T


def _candidates(entries: Any) -> tuple[tuple[Any, ...], tuple[tuple[Any, ...], ...]]:
    """4 x^2, 4 y^2, 4 z^2, 4 w^2, and the quaternion times 4 x, 4 y, 4 z, 4 w, of a rotation's entries."""
    (a, b, c), (d, e, f), (g, h, i) = entries
    squares = (1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i, 1.0 + a + e + i)
    columns = (
        (squares[0], b + d, c + g, h - f),
        (b + d, squares[1], f + h, c - g),
        (c + g, f + h, squares[2], d - b),
        (h - f, c - g, d - b, squares[3]),
    )
    return squares, columns
