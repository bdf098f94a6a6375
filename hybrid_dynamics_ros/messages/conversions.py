"""Conversion between ROS messages and arrays.

No other module of this package reads or builds messages of other packages.
"""

from __future__ import annotations

import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from hybrid_dynamics_msgs.msg import JointMotion
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from hybrid_dynamics_core.algebra.rotations import quaternion

from .cdr import NS
from .joint_samples import FloatArray, JointSample, nanoseconds


def stamp_to_ns(stamp: Time) -> int:
    """Stamp in nanoseconds.

    It is negative if the stamp is, or if its nanoseconds are a second or more.
    """
    return nanoseconds(stamp.sec, stamp.nanosec)


def ns_to_stamp(stamp_ns: int) -> Time:
    """Inverse of `stamp_to_ns`."""
    return Time(sec=stamp_ns // NS, nanosec=stamp_ns % NS)


def to_field(values: FloatArray) -> array.array[float]:
    """An array in the type that a float64[] field accepts fastest.

    Lists are 5 times slower, ndarrays 20 times.
    """
    return array.array("d", np.ascontiguousarray(values, dtype=np.float64).tobytes())


def from_field(field: Any) -> FloatArray:
    """A copy of a float64[] field as an array (k,)."""
    return np.array(field, dtype=np.float64)


def sample_of_state(message: JointState) -> JointSample:
    """A JointState as a sample: positions, and velocities and efforts if there are any."""
    return JointSample(
        stamp_ns=stamp_to_ns(message.header.stamp),
        names=message.name,
        position=from_field(message.position),
        velocity=from_field(message.velocity) if len(message.velocity) else None,
        effort=from_field(message.effort) if len(message.effort) else None,
    )


def sample_of_motion(message: JointMotion, *, complete: bool = True) -> JointSample:
    """A JointMotion as a sample.

    Args:
        message: the motion.
        complete: whether all three arrays are required. An empty one then has a wrong length;
            otherwise it counts as not given.
    """

    def part(field: Any) -> FloatArray | None:
        if complete or len(field):
            return from_field(field)
        return None

    return JointSample(
        stamp_ns=stamp_to_ns(message.header.stamp),
        names=message.name,
        position=from_field(message.position),
        velocity=part(message.velocity),
        acceleration=part(message.acceleration),
    )


def joint_state(
    header: Header,
    names: Sequence[str],
    position: FloatArray,
    velocity: FloatArray | None = None,
    effort: FloatArray | None = None,
) -> JointState:
    """A JointState of the named joints, arrays in their order.

    None leaves a field empty, for unknown values.
    """
    message = JointState(header=header, name=list(names), position=to_field(position))
    if velocity is not None:
        message.velocity = to_field(velocity)
    if effort is not None:
        message.effort = to_field(effort)
    return message


def pose_stamped(header: Header, position: FloatArray, rotation: FloatArray) -> PoseStamped:
    """A pose from a position (3,) [m] and a rotation matrix (3, 3), in the frame of the header."""
    px, py, pz = position.tolist()
    x, y, z, w = quaternion(rotation).tolist()
    pose = Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w))
    return PoseStamped(header=header, pose=pose)


def pose_arrays(pose: Pose) -> tuple[FloatArray, FloatArray]:
    """Position (3,) [m] and quaternion (4,) x y z w of a message."""
    place, turn = pose.position, pose.orientation
    position = np.array([place.x, place.y, place.z], dtype=np.float64)
    orientation = np.array([turn.x, turn.y, turn.z, turn.w], dtype=np.float64)
    return position, orientation


def joint_motion(
    header: Header,
    names: Sequence[str],
    position: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
) -> JointMotion:
    """A JointMotion of the named joints, arrays in their order."""
    return JointMotion(
        header=header,
        name=list(names),
        position=to_field(position),
        velocity=to_field(velocity),
        acceleration=to_field(acceleration),
    )


def seconds(duration: Duration) -> float:
    """A duration in seconds."""
    return float(duration.sec) + 1e-9 * float(duration.nanosec)
