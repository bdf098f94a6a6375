"""JointState and JointMotion messages and bags for the tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.storage.storage import Messages
from hybrid_dynamics_ros.messages.interfaces import JOINT_MOTION, JOINT_STATE, typestore

START = 1_700_000_000 * 10**9  # [ns]


def joint_state(stamp_ns, names, position, velocity=(), effort=(), frame=""):
    """CDR bytes of a JointState, by rosbags."""
    types = typestore().types
    time = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    numbers = (np.array(part, dtype=np.float64) for part in (position, velocity, effort))
    message = types[JOINT_STATE](types["std_msgs/msg/Header"](time, frame), list(names), *numbers)
    return bytes(typestore().serialize_cdr(message, JOINT_STATE))


def joint_motion(stamp_ns, names, position, velocity, acceleration):
    """CDR bytes of a JointMotion, by rosbags."""
    types = typestore().types
    time = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    numbers = (np.array(part, dtype=np.float64) for part in (position, velocity, acceleration))
    message = types[JOINT_MOTION](types["std_msgs/msg/Header"](time, ""), list(names), *numbers)
    return bytes(typestore().serialize_cdr(message, JOINT_MOTION))


def motion_of(robot, count, rate=100.0, seed=0):
    """A gentle random motion about the reference: times [s], u, u', u'', each (count, n)."""
    rng = np.random.default_rng(seed)
    time = np.arange(count) / rate
    n = len(robot.active)
    w, phase = rng.uniform(1.0, 3.0, n), rng.uniform(0.0, 6.0, n)
    width = np.minimum(
        0.02, 0.2 * np.diff(np.nan_to_num(robot.limits, posinf=1.0, neginf=-1.0), axis=1)[:, 0]
    )
    angle = w * time[:, None] + phase
    centre = robot.reference
    return (
        time,
        centre + width * np.sin(angle),
        width * w * np.cos(angle),
        -width * w**2 * np.sin(angle),
    )


def recorded(robot, count=60, rate=100.0, seed=0, *, velocity=True):
    """Messages of a motion, with their log times."""
    time, u, du, _ = motion_of(robot, count, rate, seed)
    stamps = [START + round(t * 1e9) for t in time]
    rates = du if velocity else [()] * count
    return [
        (t + 1000, joint_state(t, robot.active, p, v))
        for t, p, v in zip(stamps, u, rates, strict=True)
    ]


def recorded_motions(robot, count=60, rate=100.0, seed=0):
    """JointMotion messages of a motion, with their log times."""
    time, *parts = motion_of(robot, count, rate, seed)
    stamps = [START + round(t * 1e9) for t in time]
    return [
        (t + 1000, joint_motion(t, robot.active, *rows))
        for t, *rows in zip(stamps, *parts, strict=True)
    ]


def bag(
    path: Path,
    messages,
    topic=INPUT,
    plugin=StoragePlugin.MCAP,
    mode=CompressionMode.NONE,
    kind=JOINT_STATE,
):
    """A bag of one topic, by rosbags."""
    writer = Writer(path, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(topic, kind, typestore=typestore())
        for log_ns, data in messages:
            writer.write(connection, log_ns, data)
    return path


def messages_of(pairs):
    """Messages as a source gives them."""
    return Messages.of([log for log, _ in pairs], [data for _, data in pairs])
