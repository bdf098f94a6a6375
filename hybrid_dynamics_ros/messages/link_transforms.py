"""Where each link is in the one before it. Knows no ROS."""

from __future__ import annotations

import math

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

    def values(self, s: FloatArray) -> dict[str, FloatArray]:
        """Slots of `layouts.transforms` from all coordinates (N, n_s): (N, 3) [m], unit quaternions (N, 4) x y z w."""
        place = self._places + self._slide * s[..., None]
        half = np.where(self._turns, 0.5 * s, 0.0)
        sine, cosine = np.sin(half), np.cos(half)
        a, b, c, d = self._fixed.T
        x, y, z = self._axis[:, 0] * sine, self._axis[:, 1] * sine, self._axis[:, 2] * sine
        turn = np.stack(
            [
                d * x + a * cosine + b * z - c * y,
                d * y + b * cosine + c * x - a * z,
                d * z + c * cosine + a * y - b * x,
                d * cosine - a * x - b * y - c * z,
            ],
            axis=-1,
        )
        turn = (
            np.copysign(1.0, turn[..., 3:]) * turn
        )  # of the two that are the same turn, the one with w >= 0
        slots: dict[str, FloatArray] = {}
        for k in range(len(self._places)):
            slots[f"place {k}"], slots[f"turn {k}"] = place[:, k], turn[:, k]
        return slots


def quaternion(rotation: FloatArray) -> tuple[float, float, float, float]:
    """Unit quaternion x, y, z, w with w >= 0 of a rotation matrix (3, 3), by way of its largest component."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    squares = (
        1.0 + a - e - i,
        1.0 - a + e - i,
        1.0 - a - e + i,
        1.0 + a + e + i,
    )  # 4 x^2, 4 y^2, 4 z^2, 4 w^2
    largest = max(range(4), key=squares.__getitem__)
    columns = (
        (squares[0], b + d, c + g, h - f),
        (b + d, squares[1], f + h, c - g),
        (c + g, f + h, squares[2], d - b),
        (h - f, c - g, d - b, squares[3]),
    )
    x, y, z, w = columns[largest]
    scale = math.copysign(1.0 / math.sqrt(x * x + y * y + z * z + w * w), w)
    return scale * x, scale * y, scale * z, scale * w
