"""Between ROS messages and arrays. Nothing else of the package reads or builds messages of other packages."""

from __future__ import annotations

import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from hybrid_dynamics_msgs.msg import JointMotion
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from hybrid_dynamics_ros.pipeline import MotionResult
from hybrid_dynamics_ros.samples import FloatArray, JointSample

_NS: int = 10**9


def stamp_to_ns(stamp: Time) -> int:
    """Stamp in nanoseconds; negative where the message says so, or where its nanoseconds are a second or more."""
    return int(stamp.sec) * _NS + int(stamp.nanosec) if int(stamp.nanosec) < _NS else -1


def ns_to_stamp(stamp_ns: int) -> Time:
    """Inverse of :func:`stamp_to_ns`."""
    return Time(sec=stamp_ns // _NS, nanosec=stamp_ns % _NS)


def to_field(values: FloatArray) -> array.array[float]:
    """An array as a float64[] field takes it fastest: lists are 5 times slower, ndarrays 20 times."""
    return array.array("d", np.ascontiguousarray(values, dtype=np.float64).tobytes())


def from_field(field: Any) -> FloatArray:
    """A float64[] field as an array of its own, (k,)."""
    return np.array(field, dtype=np.float64)


def sample_of_state(message: JointState) -> JointSample:
    """A JointState as a sample: positions, and velocities where there are any. Efforts are not read."""
    return JointSample(
        stamp_ns=stamp_to_ns(message.header.stamp),
        names=message.name,
        position=from_field(message.position),
        velocity=from_field(message.velocity) if len(message.velocity) else None,
    )


def sample_of_motion(message: JointMotion) -> JointSample:
    """A JointMotion as a sample: it has all three arrays, so an empty one stays an array of wrong length."""
    return JointSample(
        stamp_ns=stamp_to_ns(message.header.stamp),
        names=message.name,
        position=from_field(message.position),
        velocity=from_field(message.velocity),
        acceleration=from_field(message.acceleration),
    )


def joint_state(
    header: Header,
    names: Sequence[str],
    position: FloatArray,
    velocity: FloatArray | None = None,
    effort: FloatArray | None = None,
) -> JointState:
    """A JointState of the named joints, arrays in their order; None leaves a field empty: unknown."""
    message = JointState(header=header, name=list(names), position=to_field(position))
    if velocity is not None:
        message.velocity = to_field(velocity)
    if effort is not None:
        message.effort = to_field(effort)
    return message


def pose_stamped(header: Header, position: FloatArray, quaternion: FloatArray) -> PoseStamped:
    """A pose from a position (3,) [m] and a unit quaternion (4,) x y z w, in the frame of the header."""
    px, py, pz = position.tolist()
    x, y, z, w = quaternion.tolist()
    return PoseStamped(
        header=header,
        pose=Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w)),
    )


def pose_arrays(pose: Pose) -> tuple[FloatArray, FloatArray]:
    """Position (3,) [m] and quaternion (4,) x y z w, as they are in the message."""
    p, o = pose.position, pose.orientation
    return np.array([p.x, p.y, p.z], dtype=np.float64), np.array([o.x, o.y, o.z, o.w], dtype=np.float64)


def result_messages(
    result: MotionResult, coordinates: Sequence[str], active: Sequence[str], base_frame: str
) -> tuple[JointState, JointState | None, PoseStamped]:
    """The messages that one result becomes: joint states, efforts (None where there are none), tool pose.

    Args:
        result: what the pipeline found.
        coordinates: names of all coordinates.
        active: names of the active ones.
        base_frame: frame of the pose.
    """
    header = Header(stamp=ns_to_stamp(result.stamp_ns))
    efforts = None
    if result.efforts is not None:
        efforts = joint_state(header, active, result.active_position, result.active_velocity, result.efforts)
    pose_header = Header(stamp=header.stamp, frame_id=base_frame)
    return (
        joint_state(header, coordinates, result.position, result.velocity),
        efforts,
        pose_stamped(pose_header, result.tool_position, result.tool_quaternion),
    )
