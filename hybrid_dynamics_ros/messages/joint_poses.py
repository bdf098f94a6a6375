"""Poses and twists of ball and free joints as data, by joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from .joint_samples import RejectedError, RejectionCode, nanoseconds, wrong_length
from .odometry import OdometrySample

JOINT_POSES: Final = "sensor_msgs/msg/MultiDOFJointState"


def samples_of_joint_poses(message: Any) -> Mapping[str, OdometrySample]:
    """Convert a MultiDOFJointState of rclpy or rosbags, by joint; its wrenches are not read.

    Raises:
        RejectedError: lengths differ, or a joint is named twice.
    """
    names = list(message.joint_names)
    if len(set(names)) != len(names):
        raise RejectedError(RejectionCode.DUPLICATE_JOINT, "a joint is named twice")
    for what in ("transforms", "twist"):
        size = len(getattr(message, what))
        if size != len(names):
            text = wrong_length(what, size, len(names))
            raise RejectedError(RejectionCode.WRONG_LENGTH, text)
    stamp = message.header.stamp
    stamp_ns = nanoseconds(stamp.sec, stamp.nanosec)
    samples = {}
    for name, pose, twist in zip(names, message.transforms, message.twist, strict=True):
        place, turn = pose.translation, pose.rotation
        linear, angular = twist.linear, twist.angular
        orientation = [turn.x, turn.y, turn.z, turn.w]
        velocity = [linear.x, linear.y, linear.z]
        spin = [angular.x, angular.y, angular.z]
        samples[name] = OdometrySample(
            stamp_ns=stamp_ns,
            link="",
            position=np.array([place.x, place.y, place.z]),
            orientation=np.array(orientation),
            twist=np.array(velocity + spin),
        )
    return samples
