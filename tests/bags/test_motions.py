"""Recorded joint motions, whose accelerations are told.

What the node answers to them, to the last bit.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2 import Writer

from hybrid_dynamics_core import load, shipped_robots
from hybrid_dynamics_ros.bags.batch_outputs import NODE
from hybrid_dynamics_ros.bags.decode import Decoder
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.input_topic import INPUT, input_topic
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import KINDS, process
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader
from hybrid_dynamics_ros.messages.interfaces import JOINT_MOTION, JOINT_STATE, typestore
from hybrid_dynamics_ros.messages.joint_samples import Calibration
from hybrid_dynamics_ros.parameters import NodeSettings
from hybrid_dynamics_ros.stream.pipeline import MotionResult, Pipeline
from hybrid_dynamics_ros.stream.rate_limit import RateLimit
from hybrid_dynamics_ros.stream.topics import topics_of
from tests.bags.messages import START, bag, joint_motion, messages_of, recorded, recorded_motions
from tests.bags.test_outputs import plain, written
from tests.bags.test_stream import ACTIVE, GOOD, MS, NAMES, assert_same
from tests.sampling import examples, swept

MOTIONS = f"{NODE}/active_joint_motions"
ROBOT = "forging_chu2020"


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_every_shipped_robot_gives_the_bits_of_the_stream(name):
    robot = load(name)
    expected = assert_same(robot, recorded_motions(robot, 20), cuts=(7, 8), kind=JOINT_MOTION)
    assert all(result.efforts is not None for _, result in expected)  # the filter is not asked
    assert len(expected) == 20


@st.composite
def sequences(draw):
    """JointMotion messages.

    Reordered joints, arrays too short or missing, numbers that are none or too large.
    """
    stamp, pairs = START, []
    for k in range(draw(st.integers(1, 30))):
        names = draw(st.sampled_from(NAMES))
        stamp = max(stamp + draw(st.sampled_from([10 * MS, 0, -5 * MS, 600 * MS])), 0)
        parts = [
            [GOOD[name] + 0.001 * (k % 7) for name in names],
            *([0.01 * (k % 5)] * len(names) for _ in range(2)),
        ]
        kind, which = (
            draw(st.sampled_from(["good", "good", "good", "odd", "short", "none"])),
            draw(st.integers(0, 2)),
        )
        if kind == "odd" and names:
            parts[which][draw(st.integers(0, len(names) - 1))] = draw(
                st.sampled_from([0.9, 1e300, np.nan, np.inf, -0.0])
            )
        parts[which] = {"short": parts[which][:-1], "none": []}.get(kind, parts[which])
        pairs.append((START + k, joint_motion(stamp, names, *parts)))
    return pairs, sorted(draw(st.lists(st.integers(0, len(pairs)), max_size=3)))


@examples(60)
@given(case=sequences())
def test_any_sequence_cut_anywhere_gives_the_bits_of_the_stream(forging, case):
    assert_same(forging, *case, kind=JOINT_MOTION)


def test_sensors_are_read_as_the_stream_reads_them(forging):
    calibration = Calibration(np.array([0.01, -0.02, 0.0, 0.1]), np.array([1.0, 1.01, 0.99, -1.0]))
    assert (
        len(
            assert_same(
                forging, recorded_motions(forging, 20), (5,), None, JOINT_MOTION, calibration
            )
        )
        == 20
    )


def test_measured_joints_that_are_not_the_active_ones_give_the_bits_of_the_stream(forging):
    state = forging.close(forging.reference)
    measured = ("q1", "q2", "q3", "q4")
    at = [float(state.s[forging.coordinates.index(name)]) for name in measured]
    rates = [0.01] * 4, [0.1, 0.0, -0.1, 0.0]
    pairs = [
        (k, joint_motion(START + 10 * MS * k, measured, np.add(at, 1e-4 * k), *rates))
        for k in range(12)
    ]
    assert assert_same(forging, pairs, (5,), measured, JOINT_MOTION)


def test_motions_of_one_layout_are_decoded_in_bulk(forging):
    pairs = recorded_motions(forging, 40)
    bulk, single = (
        Decoder(ACTIVE, JOINT_MOTION, bulk=many).decode(messages_of(pairs))
        for many in (True, False)
    )
    assert (bulk.bulk_count, single.bulk_count) == (40, 0)
    for part in ("stamp_ns", "position", "velocity", "acceleration", "measured"):
        assert np.array_equal(getattr(bulk, part), getattr(single, part)), part


@pytest.mark.ros
@pytest.mark.parametrize("name", swept([ROBOT, "staicu2015", "gough"]))
def test_a_bag_of_motions_has_what_the_node_would_have_published(name, tmp_path):
    pytest.importorskip("hybrid_dynamics_msgs")
    from hybrid_dynamics_msgs.msg import JointMotion

    from hybrid_dynamics_ros.messages.conversions import sample_of_motion

    robot = load(name)
    pairs = recorded_motions(robot, 30)
    outcome = process(
        Job(bag(tmp_path / "in", pairs, MOTIONS, kind=JOINT_MOTION), tmp_path / "out", name)
    )
    assert (outcome.losses, outcome.bulk) == ([], 1.0)
    assert outcome.summary == "30 received, 30 accepted, 30 with efforts"
    found = written(tmp_path / "out")
    pipeline, defaults = Pipeline(robot, 10.0, 0.5), NodeSettings()
    topics = [(topic, RateLimit()) for topic in topics_of(robot, NodeSettings())]
    for log_ns, data in pairs:
        told = typestore().deserialize_cdr(data, JOINT_MOTION)
        message = JointMotion(name=told.name)
        for part in ("position", "velocity", "acceleration"):
            setattr(message, part, getattr(told, part).tolist())
        message.header.stamp.sec, message.header.stamp.nanosec = (
            told.header.stamp.sec,
            told.header.stamp.nanosec,
        )
        result = pipeline.process(sample_of_motion(message))
        assert isinstance(result, MotionResult)
        for topic, pace in topics:
            due = pace.due(result.stamp_ns, defaults[topic.rate])
            sent = topic.fill(result) if due else None
            if sent is not None:
                sent = typestore().deserialize_cdr(sent, topic.kind)
                there_log, there = found[f"{NODE}/{topic.name}"].pop(0)
                assert there_log == log_ns
                assert plain(there) == plain(sent), topic.name
    assert {topic for topic, rest in found.items() if rest} == {"/robot_description"}


def two_topics(path, robot):
    """A bag with joint states and joint motions."""
    with Writer(path, version=9) as writer:
        states = writer.add_connection("/states", JOINT_STATE, typestore=typestore())
        motions = writer.add_connection("/motions", JOINT_MOTION, typestore=typestore())
        for (log_ns, state), (_, motion) in zip(
            recorded(robot, 40), recorded_motions(robot, 40), strict=True
        ):
            writer.write(states, log_ns, state)
            writer.write(motions, log_ns, motion)
    return path


def test_joint_states_come_first_and_motions_where_they_are_named(forging, tmp_path):
    path = two_topics(tmp_path / "in", forging)
    told = [
        process(Job(path, tmp_path / "out", ROBOT, topic)).summary
        for topic in (None, "/states", "/motions")
    ]
    # the filter is ready after its lag, 2 / (2 pi 10 Hz / sqrt(sqrt(2) - 1)) = 20.5 ms: from the
    # fourth sample on
    assert told[0] == told[1] == "40 received, 40 accepted, 37 with efforts"
    assert told[2] == "40 received, 40 accepted, 40 with efforts"
    with BagReader(path) as source:
        assert input_topic(source, None, KINDS) == "/states"
        with pytest.raises(
            BagError, match=r"no topic /motions of type sensor_msgs/msg/JointState; .*: /states$"
        ):
            input_topic(source, "/motions")
        with pytest.raises(
            BagError,
            match=r"no topic /tf of type .*JointState or .*JointMotion; .*: /states, /motions$",
        ):
            input_topic(source, "/tf", KINDS)


def test_smoothing_accelerations_that_are_told_is_refused(forging, tmp_path):
    path = bag(tmp_path / "in", recorded_motions(forging, 20), MOTIONS, kind=JOINT_MOTION)
    with pytest.raises(
        BagError, match=r"active_joint_motions has accelerations.*leave out --smooth spline"
    ):
        process(Job(path, tmp_path / "out", ROBOT, smooth="spline"))
    assert not (tmp_path / "out").exists()


def test_what_is_no_motion_is_told_and_the_rest_is_there(forging, tmp_path):
    pairs = recorded_motions(forging, 30)
    pairs[3] = (pairs[3][0], pairs[3][1][:40])
    pairs[4] = (pairs[4][0], joint_motion(START, ACTIVE, [0.1] * 4, [], [0.0] * 4))
    outcome = process(
        Job(bag(tmp_path / "in", pairs, INPUT, kind=JOINT_MOTION), tmp_path / "out", ROBOT)
    )
    (lost,) = outcome.losses
    assert "message 3" in lost
    assert "no JointMotion" in lost
    assert outcome.rejections == {
        "wrong length": (
            "velocity has 0 values for 4 joint names; expected 4, zeros for a robot at rest"
        )
    }
    assert outcome.summary == "29 received, 28 accepted, 28 with efforts, 1 rejected: wrong length"
