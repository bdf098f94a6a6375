"""Ten thousand random messages: nothing escapes, and whatever goes out is finite and true."""

import array
import copy

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hybrid_dynamics_msgs.msg import JointMotion
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from hybrid_dynamics_ros.messages import conversions
from hybrid_dynamics_ros.messages.joint_samples import Rejection
from hybrid_dynamics_ros.node.publishers import message_class
from hybrid_dynamics_ros.parameters import NodeSettings
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from hybrid_dynamics_ros.stream.topics import LoopReactions, topics_of
from tests.sampling import examples

ACTIVE = ("q1", "q12", "q22", "q4")
ROUNDS, LENGTH = 120, 40  # streams, messages in each

any_number = st.one_of(
    st.floats(),  # NaN, infinite, tiny and huge ones among them
    st.floats(-0.5, 0.5),
    st.sampled_from([0.0, 0.1, 0.15, 1e300, -1e300, 1e-320]),
)
good = st.fixed_dictionaries(
    {
        "q1": st.floats(-3, 3),
        "q12": st.floats(0.05, 0.2),
        "q22": st.floats(0.1, 0.2),
        "q4": st.floats(-3, 3),
    }
)
names = st.one_of(
    st.permutations(ACTIVE),
    st.lists(st.sampled_from([*ACTIVE, "", "hose", "q2", "\u00e9"]), max_size=7),
)
stamps = st.one_of(
    st.integers(0, 10**6).map(lambda k: (k // 100, 10**7 * (k % 100))),
    st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1)),
)


@st.composite
def messages(draw):
    """A JointState or a JointMotion: near what it should be, or anything."""
    if draw(st.booleans()):
        values = draw(good)
        order = draw(st.permutations(ACTIVE))
        parts = [[values[name] for name in order], draw(st.lists(any_number, max_size=4))]
    else:
        order = draw(names)
        size = st.integers(max(0, len(order) - 1), len(order) + 1)
        parts = [
            draw(size.flatmap(lambda n: st.lists(any_number, min_size=n, max_size=n)))
            for _ in range(2)
        ]
    sec, nanosec = draw(stamps)
    header = Header(stamp=Time(sec=sec, nanosec=nanosec))
    position, velocity = (array.array("d", part) for part in parts)
    if draw(st.booleans()):
        return JointState(header=header, name=list(order), position=position, velocity=velocity)
    acceleration = array.array("d", draw(st.lists(any_number, max_size=4)))
    return JointMotion(
        header=header,
        name=list(order),
        position=position,
        velocity=velocity,
        acceleration=acceleration,
    )


def numbers(message):
    """Every number of a message, nested ones too."""
    for field in message.get_fields_and_field_types():
        value = getattr(message, field)
        if isinstance(value, float):
            yield value
        elif isinstance(value, array.array):
            yield from value
        elif hasattr(value, "get_fields_and_field_types"):
            yield from numbers(value)


@pytest.fixture(scope="module")
def fillers(robot):
    topics = topics_of(robot, NodeSettings())
    table = [topic for topic in topics if not isinstance(topic, LoopReactions)]  # NaN is an answer
    return [(message_class(topic.kind), topic.fill) for topic in table]


@examples(ROUNDS)
@given(stream=st.lists(messages(), min_size=LENGTH, max_size=LENGTH))
def test_random_streams_give_true_numbers_or_reasons(robot, fillers, stream):
    pipeline, accepted = Pipeline(robot, bandwidth=10.0, max_gap=0.5), 0
    for message in stream:
        before = copy.deepcopy(message)
        is_motion = isinstance(message, JointMotion)
        sample = (conversions.sample_of_motion if is_motion else conversions.sample_of_state)(
            message
        )
        result = pipeline.process(sample)
        assert (
            message == before or not np.isfinite(list(numbers(before))).all()
        )  # NaN is not itself
        if result is None:
            continue  # it waits for other joints
        if isinstance(result, Rejection):
            assert result.text
            continue
        assert isinstance(result, MotionResult)
        accepted += 1
        given_at = dict(zip(message.name, message.position, strict=False))
        if not pipeline.counts.wraps:  # none of the jumps was one of a whole turn so far
            assert [given_at[name] for name in ACTIVE] == list(result.active.position)
        assert result.residual < 1e-9
        for kind, fill in fillers:
            sent = fill(result)
            if sent is not None:
                out = deserialize_message(sent, kind)
                assert out.header.stamp == message.header.stamp
                assert np.isfinite(list(numbers(out))).all()
    counts = pipeline.counts
    assert (counts.received, counts.accepted) == (LENGTH, accepted)
    assert counts.received == counts.accepted + counts.waiting + counts.rejected.total()


def test_a_running_node_survives_random_messages_and_is_right_after_them(client, robot):
    @settings(max_examples=100, database=None)
    @given(message=messages())
    def flood(message):
        topic = (
            "active_joint_motions" if isinstance(message, JointMotion) else "active_joint_states"
        )
        client.publish_as_it_is(topic, message)

    flood()
    stamp = client.new_stamp(10_000.0)
    u = [0.0, 0.1, 0.15, 0.0]
    client.publish(
        "active_joint_motions",
        JointMotion(
            name=list(ACTIVE),
            position=u,
            velocity=[0.0] * 4,
            acceleration=[0.0] * 4,
        ),
        stamp,
    )
    assert np.array_equal(client.wait_for("joint_states", stamp).position, robot.close(u).s)
    wanted = robot.inverse_dynamics(robot.close(u), np.zeros(4))
    assert np.array_equal(client.wait_for("required_efforts", stamp).effort, wanted)
