"""Messages to arrays and back."""

import array

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hybrid_dynamics_msgs.msg import JointMotion
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from hybrid_dynamics_ros import conversions
from hybrid_dynamics_ros.pipeline import MotionResult

HEADER = Header(stamp=Time(sec=3, nanosec=4), frame_id="base")


@pytest.mark.parametrize(
    ("sec", "nanosec", "stamp_ns"),
    [
        (0, 0, 0),
        (1, 999_999_999, 1_999_999_999),
        (-1, 0, -1_000_000_000),
        (-1, 999_999_999, -1),
        (2**31 - 1, 999_999_999, 2**31 * 10**9 - 1),
    ],
)
def test_stamps_go_to_nanoseconds_and_back(sec, nanosec, stamp_ns):
    assert conversions.stamp_to_ns(Time(sec=sec, nanosec=nanosec)) == stamp_ns
    assert conversions.ns_to_stamp(stamp_ns) == Time(sec=sec, nanosec=nanosec)


def test_nanoseconds_of_a_second_or_more_are_no_stamp():
    assert conversions.stamp_to_ns(Time(sec=1, nanosec=2_500_000_000)) < 0
    assert conversions.stamp_to_ns(Time(sec=1, nanosec=999_999_999)) == 1_999_999_999


@pytest.mark.parametrize("values", [[], [1.5], [0.1, -0.0, np.nan, np.inf, 5e-324, 1e300]])
def test_fields_keep_every_bit(values):
    field = conversions.to_field(np.array(values))
    assert isinstance(field, array.array)
    assert field.typecode == "d"
    assert field.tobytes() == np.array(values, dtype=float).tobytes()
    assert conversions.from_field(field).tobytes() == np.array(values, dtype=float).tobytes()


def test_fields_take_the_values_of_a_view_not_its_memory():
    matrix = np.arange(12.0).reshape(3, 4)
    assert list(conversions.to_field(matrix[:, 1])) == [1.0, 5.0, 9.0]
    assert list(conversions.to_field(matrix[0, ::-1])) == [3.0, 2.0, 1.0, 0.0]
    assert list(conversions.to_field(np.array([1, 2]))) == [1.0, 2.0]


def test_arrays_of_fields_are_their_own():
    message = JointState(name=["a"], position=[1.0])
    sample = conversions.sample_of_state(message)
    message.position[0] = 2.0
    assert sample.position[0] == 1.0


def test_a_state_without_velocities_has_none():
    message = JointState(header=HEADER, name=["a", "b"], position=[1.0, 2.0], effort=[9.0])
    sample = conversions.sample_of_state(message)
    assert sample.stamp_ns == 3_000_000_004
    assert list(sample.names) == ["a", "b"]
    assert np.array_equal(sample.position, [1.0, 2.0])
    assert sample.velocity is None
    assert sample.acceleration is None


def test_a_state_keeps_velocities_of_any_length_for_the_check():
    sample = conversions.sample_of_state(JointState(name=["a", "b"], position=[1.0, 2.0], velocity=[3.0]))
    assert np.array_equal(sample.velocity, [3.0])


def test_a_motion_keeps_empty_arrays_for_the_check():
    sample = conversions.sample_of_motion(JointMotion(header=HEADER, name=["a"], position=[1.0]))
    assert sample.stamp_ns == 3_000_000_004
    assert sample.velocity.shape == (0,)
    assert sample.acceleration.shape == (0,)


def test_a_joint_state_holds_what_is_known_and_leaves_the_rest_empty():
    message = conversions.joint_state(HEADER, ("a", "b"), np.array([1.0, 2.0]), effort=np.array([5.0, 6.0]))
    assert message.header == HEADER
    assert message.name == ["a", "b"]
    assert list(message.position) == [1.0, 2.0]
    assert not message.velocity
    assert list(message.effort) == [5.0, 6.0]


def test_poses_keep_their_order_x_y_z_w():
    message = conversions.pose_stamped(HEADER, np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.3, 0.9]))
    p, o = message.pose.position, message.pose.orientation
    assert (p.x, p.y, p.z) == (1.0, 2.0, 3.0)
    assert (o.x, o.y, o.z, o.w) == (0.1, 0.2, 0.3, 0.9)
    position, quaternion = conversions.pose_arrays(message.pose)
    assert np.array_equal(position, [1.0, 2.0, 3.0])
    assert np.array_equal(quaternion, [0.1, 0.2, 0.3, 0.9])


def result(efforts, velocity=(7.0, 8.0)):
    def optional(values):
        return None if values is None else np.array(values)

    return MotionResult(
        stamp_ns=3_000_000_004,
        position=np.array([1.0, 2.0]),
        velocity=optional(velocity),
        active_position=np.array([1.0]),
        active_velocity=optional(None if velocity is None else velocity[:1]),
        active_acceleration=np.array([0.5]),
        efforts=optional(efforts),
        tool_position=np.zeros(3),
        tool_quaternion=np.array([0.0, 0.0, 0.0, 1.0]),
        residual=0.0,
        event=None,
    )


def test_a_result_becomes_three_messages_with_its_stamp():
    states, efforts, pose = conversions.result_messages(result([4.0]), ("a", "z"), ("a",), "base_link")
    for message in (states, efforts, pose):
        assert message.header.stamp == Time(sec=3, nanosec=4)
    assert pose.header.frame_id == "base_link"
    assert states.name == ["a", "z"]
    assert list(states.position) == [1.0, 2.0]
    assert list(states.velocity) == [7.0, 8.0]
    assert efforts.name == ["a"]
    assert list(efforts.effort) == [4.0]
    assert list(efforts.velocity) == [7.0]


def test_what_a_result_does_not_know_is_not_sent():
    states, efforts, _ = conversions.result_messages(result(None, velocity=None), ("a", "z"), ("a",), "base")
    assert efforts is None
    assert not states.velocity
