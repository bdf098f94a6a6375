"""Transforms of all links, for /tf where robot_state_publisher does not send them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from std_msgs.msg import Header

from hybrid_dynamics_core import Robot
from hybrid_dynamics_ros.conversions import ns_to_stamp, quaternion
from hybrid_dynamics_ros.outputs import Fill
from hybrid_dynamics_ros.parameters import TF_RATE, ParameterError
from hybrid_dynamics_ros.pipeline import MotionResult
from hybrid_dynamics_ros.samples import FloatArray


def link_transforms(robot: Robot) -> Callable[[FloatArray, Time], list[TransformStamped]]:
    """Maker of the transform of every link in the one before it, from all coordinates (n_s,)."""
    joints = [robot.description.joints[name] for name in robot.coordinates]
    crosses = [_cross(joint.axis) for joint in joints]

    def make(s: FloatArray, stamp: Time) -> list[TransformStamped]:
        transforms = []
        for joint, cross, value in zip(joints, crosses, s.tolist(), strict=True):
            if joint.type == "revolute":
                turned = np.eye(3) + np.sin(value) * cross + (1.0 - np.cos(value)) * cross @ cross
                rotation, translation = joint.rotation @ turned, joint.translation
            else:
                rotation, translation = joint.rotation, joint.translation + joint.rotation @ (value * joint.axis)
            x, y, z, w = quaternion(rotation)
            px, py, pz = translation.tolist()
            transforms.append(
                TransformStamped(
                    header=Header(stamp=stamp, frame_id=joint.parent),
                    child_frame_id=joint.child,
                    transform=Transform(translation=Vector3(x=px, y=py, z=pz), rotation=Quaternion(x=x, y=y, z=z, w=w)),
                )
            )
        return transforms

    return make


def tf_output() -> tuple[type, Callable[[Robot], Fill]]:
    """Type of /tf and what makes its filler.

    Raises:
        ParameterError: tf2_msgs is not installed.
    """
    try:
        from tf2_msgs.msg import TFMessage  # noqa: PLC0415 - not among the wheels of PyPI
    except ImportError as error:
        text = f"parameter {TF_RATE.name}: tf2_msgs is not installed; use robot_state_publisher, or set it to -1"
        raise ParameterError(text) from error

    def filler(robot: Robot) -> Fill:
        make = link_transforms(robot)

        def fill(result: MotionResult) -> Any:
            return TFMessage(transforms=make(result.state.s, ns_to_stamp(result.stamp_ns)))

        return fill

    return TFMessage, filler


def _cross(axis: FloatArray) -> FloatArray:
    x, y, z = axis.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
