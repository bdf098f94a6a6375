"""Readings of inertial measurement units as data."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from .joint_samples import FloatArray, RejectedError, RejectionCode, nanoseconds

IMU: Final = "sensor_msgs/msg/Imu"
_ABSENT: Final = -1.0  # first entry of a covariance whose values are not measured


class ImuSample(NamedTuple):
    """What a unit read at one stamp, in its own axes.

    Attributes:
        stamp_ns: stamp [ns].
        rate: angular velocity (3,) [rad/s]; None if it is not measured.
        force: specific force (3,) [m/s^2]; None if it is not measured.
    """

    stamp_ns: int
    rate: FloatArray | None
    force: FloatArray | None


def sample_of_imu(message: Any) -> ImuSample:
    """Convert an Imu message of rclpy or rosbags; its orientation and covariances are not used.

    Raises:
        RejectedError: the stamp is negative, or a value is not finite.
    """
    stamp = message.header.stamp
    stamp_ns = nanoseconds(stamp.sec, stamp.nanosec)
    if stamp_ns < 0:
        text = f"stamp is {stamp_ns} ns, expected 0 or more"
        raise RejectedError(RejectionCode.BAD_STAMP, text)
    rate = _measured(message.angular_velocity, message.angular_velocity_covariance)
    force = _measured(message.linear_acceleration, message.linear_acceleration_covariance)
    for name, values in (("angular_velocity", rate), ("linear_acceleration", force)):
        if values is not None and not np.isfinite(values).all():
            text = f"{name} is {values.tolist()}, expected finite numbers"
            raise RejectedError(RejectionCode.NOT_FINITE, text)
    return ImuSample(stamp_ns, rate, force)


def _measured(vector: Any, covariance: Any) -> FloatArray | None:
    """A vector (3,); None where its covariance says that it is not measured."""
    if covariance[0] == _ABSENT:
        return None
    return np.array([vector.x, vector.y, vector.z], dtype=np.float64)
