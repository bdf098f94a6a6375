"""What is written offline is what the node publishes.

Every field of every message, to the last bit.
"""

from __future__ import annotations

import array
from collections import defaultdict

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from hybrid_dynamics_core import load, shipped_robots
from hybrid_dynamics_ros.bags.batch_outputs import NODE
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import DESCRIPTION, process
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, typestore
from hybrid_dynamics_ros.parameters import TF_RATE, NodeSettings
from hybrid_dynamics_ros.stream.frames import frame_names
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.rate_limit import RateLimit
from hybrid_dynamics_ros.stream.results import MotionResult
from hybrid_dynamics_ros.stream.topics import Transforms, topics_of
from tests.bags.messages import bag, recorded
from tests.sampling import SAMPLE, swept


def plain(message):
    """A message of rosbags or of rclpy as nested tuples."""
    if hasattr(message, "get_fields_and_field_types"):
        return tuple(plain(getattr(message, name)) for name in message.get_fields_and_field_types())
    if hasattr(message, "__dataclass_fields__"):
        return tuple(
            plain(getattr(message, name))
            for name in message.__dataclass_fields__
            if name != "__msgtype__"
        )
    if isinstance(message, (list, tuple, np.ndarray, array.array)):
        return tuple(plain(entry) for entry in message)
    return repr(float(message)) if isinstance(message, (float, np.floating)) else message


def written(path):
    """Messages by topic, with their log times, by rosbags."""
    found = defaultdict(list)
    with Reader(path) as reader:
        for connection, log_ns, data in reader.messages():
            found[connection.topic].append(
                (log_ns, typestore().deserialize_cdr(data, connection.msgtype))
            )
    return found


def by_the_mcap_library(path):
    """ThrottledLog times and bytes by topic and type."""
    from mcap.reader import make_reader

    found = defaultdict(list)
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema.encoding == "ros2msg"
            found[channel.topic, schema.name].append((message.log_time, message.data))
    return found


def by_rosbags(path):
    """The same by rosbags."""
    found = defaultdict(list)
    with Reader(path) as reader:
        for connection, log_ns, data in reader.messages():
            found[connection.topic, connection.msgtype].append((log_ns, bytes(data)))
    return found


NO_VELOCITIES = "forging_chu2020 without velocities"


@pytest.mark.ros
@pytest.mark.parametrize(
    "name",
    swept([*shipped_robots(), NO_VELOCITIES], (*SAMPLE, NO_VELOCITIES)),
)
def test_a_bag_has_what_the_node_would_have_published(name, tmp_path):
    pytest.importorskip("hybrid_dynamics_msgs")
    from sensor_msgs.msg import JointState

    from hybrid_dynamics_ros.messages.conversions import sample_of_state, stamp_to_ns

    without = name == NO_VELOCITIES
    name = name.partition(" ")[0]
    robot = load(name)
    pairs = recorded(robot, 40, velocity=not without)
    outcome = process(Job(bag(tmp_path / "in", pairs), tmp_path / "out", name, keep=True))
    assert outcome.losses == []
    assert by_the_mcap_library(tmp_path / "out" / "out.mcap") == by_rosbags(tmp_path / "out")
    assert by_rosbags(tmp_path / "out")[INPUT, JOINT_STATE] == pairs
    found = written(tmp_path / "out")
    del found[INPUT]
    pipeline, settings = Pipeline(robot, 10.0, 0.5), NodeSettings()
    topics = [(topic, RateLimit()) for topic in topics_of(robot, NodeSettings())]
    for log_ns, data in pairs:
        told = typestore().deserialize_cdr(data, JOINT_STATE)
        message = JointState(
            name=told.name, position=told.position.tolist(), velocity=told.velocity.tolist()
        )
        message.header.stamp.sec, message.header.stamp.nanosec = (
            told.header.stamp.sec,
            told.header.stamp.nanosec,
        )
        result = pipeline.process(sample_of_state(message))
        assert isinstance(result, MotionResult)
        for topic, pace in topics:
            due = pace.due(result.stamp_ns, settings[topic.rate])
            sent = topic.fill(result) if due else None
            if sent is not None:
                sent = typestore().deserialize_cdr(sent, topic.kind)
                there_log, there = found[f"{NODE}/{topic.name}"].pop(0)
                assert there_log == log_ns
                assert stamp_to_ns(there.header.stamp) == result.stamp_ns
                assert plain(there) == plain(sent), topic.name
    assert [found.pop(DESCRIPTION)[0][1].data[:5]] == ["<?xml"]
    assert {topic: rest for topic, rest in found.items() if rest} == {}


@pytest.mark.ros
@pytest.mark.parametrize("name", swept(["excavator", "staicu2015"], ["excavator"]))
def test_transforms_are_written_where_they_are_asked_for(name, tmp_path):
    pytest.importorskip("hybrid_dynamics_msgs")
    from sensor_msgs.msg import JointState

    from hybrid_dynamics_ros.messages.conversions import sample_of_state

    robot = load(name)
    pairs = recorded(robot, 20)
    settings = NodeSettings({TF_RATE.name: 0.0})
    process(Job(bag(tmp_path / "in", pairs), tmp_path / "out", name, settings=settings))
    found = by_rosbags(tmp_path / "out")["/tf", "tf2_msgs/msg/TFMessage"]
    pipeline, fill = (
        Pipeline(robot, 10.0, 0.5),
        Transforms(robot, frame_names(robot, NodeSettings())).fill,
    )
    for (log_ns, data), (there_log, there) in zip(pairs, found, strict=True):
        told = typestore().deserialize_cdr(data, JOINT_STATE)
        message = JointState(
            name=told.name, position=told.position.tolist(), velocity=told.velocity.tolist()
        )
        message.header.stamp.sec, message.header.stamp.nanosec = (
            told.header.stamp.sec,
            told.header.stamp.nanosec,
        )
        assert there_log == log_ns
        assert there == fill(pipeline.process(sample_of_state(message)))
