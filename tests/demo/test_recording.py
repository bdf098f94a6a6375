"""The shipped recording, and how bags are written."""

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from hybrid_dynamics_ros.bags.storage.bag_reader import read_raw
from hybrid_dynamics_ros.bags.storage.bag_writer import new_bag
from hybrid_dynamics_ros.demo.play.recording import (
    SHIPPED,
    START_NS,
    make_recording,
    recorded_messages,
    shipped_messages,
)
from hybrid_dynamics_ros.demo.topics import INPUT, TYPES, bag_topics
from hybrid_dynamics_ros.messages.interfaces import deserialize

NODE_INPUT = "/hybrid_dynamics/active_joint_states"


def test_the_shipped_recording_is_what_its_maker_makes():
    assert shipped_messages() == recorded_messages()


def test_made_twice_the_messages_are_the_same_bytes(tmp_path):
    make_recording(tmp_path / "again")
    assert read_raw(tmp_path / "again", INPUT) == read_raw(SHIPPED, INPUT)


def test_the_shipped_recording_is_small_mcap_of_one_topic():
    assert sum(file.stat().st_size for file in SHIPPED.iterdir()) < 100_000
    with Reader(SHIPPED) as reader:
        (connection,) = reader.connections
        assert (connection.topic, connection.msgtype) == (NODE_INPUT, "sensor_msgs/msg/JointState")
    assert sorted(file.suffix for file in SHIPPED.iterdir()) == [".mcap", ".yaml"]


def test_the_shipped_recording_is_the_papers_trajectory_at_100_hz():
    messages = [deserialize(data, TYPES[INPUT]) for _, data in shipped_messages()]
    assert len(messages) == 1001
    for k, message in enumerate(messages):
        t = k / 100
        stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        assert stamp_ns == START_NS + 10_000_000 * k
        assert message.name == ["q1", "q12", "q22", "q4"]
        position = [np.radians(10 * t), 0.1 + 0.01 * t, 0.15 + 0.005 * t, np.radians(5 * t)]
        np.testing.assert_allclose(message.position, position, rtol=0, atol=1e-15)  # one rounding
        np.testing.assert_array_equal(
            message.velocity, [np.radians(10), 0.01, 0.005, np.radians(5)]
        )
        assert message.effort.size == 0


def test_log_times_are_the_stamps():
    assert [log_ns for log_ns, _ in shipped_messages()] == [
        START_NS + 10_000_000 * k for k in range(1001)
    ]


def test_a_new_bag_takes_the_place_of_the_old_one(tmp_path):
    for data in (b"\x00\x01\x00\x00old!", b"\x00\x01\x00\x00new!"):
        with new_bag(tmp_path / "bag", bag_topics([INPUT])) as bag:
            bag.write_message(INPUT, 5, data)
    assert read_raw(tmp_path / "bag", INPUT) == [(5, b"\x00\x01\x00\x00new!")]
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]


def write_half_a_bag(path):
    with new_bag(path, bag_topics([INPUT])) as bag:
        bag.write_message(INPUT, 5, b"\x00\x01\x00\x00new!")
        raise KeyboardInterrupt


def test_an_interrupted_bag_leaves_the_old_one_and_nothing_else(tmp_path):
    make_recording(tmp_path / "bag")
    with pytest.raises(KeyboardInterrupt):
        write_half_a_bag(tmp_path / "bag")
    assert read_raw(tmp_path / "bag", INPUT) == shipped_messages()
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]


def test_a_topic_that_is_not_in_the_bag_has_no_messages():
    assert read_raw(SHIPPED, "/other") == []
