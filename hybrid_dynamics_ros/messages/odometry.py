"""Odometry of a floating base as data: pose and twist, without covariances."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from .joint_samples import FloatArray, nanoseconds

ODOMETRY: Final = "nav_msgs/msg/Odometry"


class OdometrySample(NamedTuple):
    """Pose and twist of a link at one stamp.

    Attributes:
        stamp_ns: stamp [ns].
        link: name of the moving frame, the `child_frame_id` of the message.
        position: position of its origin (3,) [m].
        orientation: quaternion (4,) x y z w.
        twist: linear velocity of its origin [m/s], then angular velocity [rad/s], in the axes of
            the link (6,).
    """

    stamp_ns: int
    link: str
    position: FloatArray
    orientation: FloatArray
    twist: FloatArray


def sample_of_odometry(message: Any) -> OdometrySample:
    """Convert an Odometry message of rclpy or rosbags, without its covariances."""
    pose, twist = message.pose.pose, message.twist.twist
    place, turn = pose.position, pose.orientation
    linear, angular = twist.linear, twist.angular
    rates = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    stamp = message.header.stamp
    return OdometrySample(
        stamp_ns=nanoseconds(stamp.sec, stamp.nanosec),
        link=message.child_frame_id,
        position=np.array([place.x, place.y, place.z], dtype=np.float64),
        orientation=np.array([turn.x, turn.y, turn.z, turn.w], dtype=np.float64),
        twist=np.array(rates, dtype=np.float64),
    )
