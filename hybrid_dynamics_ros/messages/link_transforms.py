"""Poses of links relative to their parents. It does not depend on ROS."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.algebra.rotations import quaternion

from .joint_samples import FloatArray


class LinkTransforms:
    """Translation and rotation of every joint's child in its parent.

    The operations are elementwise, so that one state and many give the same bits.
    """

    def __init__(self, robot: Robot) -> None:
        joints = [robot.description.joints[name] for name in robot.coordinates]
        slides = []
        for joint in joints:
            is_revolute = joint.type == "revolute"
            slides.append(np.zeros(3) if is_revolute else joint.rotation @ joint.axis)
        self._is_revolute = np.array([joint.type == "revolute" for joint in joints])
        self._fixed = np.array([quaternion(joint.rotation) for joint in joints])
        self._axis = np.array([joint.axis for joint in joints])
        self._translation = np.array([joint.translation for joint in joints])
        self._slide = np.array(slides)

    def values(self, s: FloatArray) -> list[FloatArray]:
        """Translation [m] and unit quaternion x y z w of each joint's child, in turn.

        Args:
            s: all coordinates, (n_s,) or (N, n_s) [rad or m].
        """
        translations = self._translation + self._slide * s[..., None]
        quaternions = self._quaternions(s)
        slots: list[FloatArray] = []
        for joint in range(len(self._translation)):
            slots += [translations[..., joint, :], quaternions[..., joint, :]]
        return slots

    def _quaternions(self, s: FloatArray) -> FloatArray:
        """Quaternions (..., n_s, 4) of the fixed rotations times the joint rotations."""
        half = np.where(self._is_revolute, 0.5 * s, 0.0)
        sine, cosine = np.sin(half), np.cos(half)
        a, b, c, d = self._fixed.T
        x, y, z = (component * sine for component in self._axis.T)
        parts = [
            d * x + a * cosine + b * z - c * y,
            d * y + b * cosine + c * x - a * z,
            d * z + c * cosine + a * y - b * x,
            d * cosine - a * x - b * y - c * z,
        ]
        turned = np.stack(parts, axis=-1)
        # of q and -q, the one with w >= 0
        positive: FloatArray = np.copysign(1.0, turned[..., 3:]) * turned
        return positive
