"""Messages to arrays and back."""

import array
import gc
import pickle
from multiprocessing.reduction import ForkingPickler

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hybrid_dynamics_msgs.msg import JointMotion
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core.algebra.rotations import quaternion
from hybrid_dynamics_ros.bags.decode import Decoder
from hybrid_dynamics_ros.messages import conversions
from hybrid_dynamics_ros.messages.trajectory_columns import (
    columns_of,
    message_of,
    send_as_columns,
)
from hybrid_dynamics_ros.node.input_reader import StateReader
from tests.bags.messages import START, joint_state, messages_of

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
    sample = conversions.sample_of_state(
        JointState(name=["a", "b"], position=[1.0, 2.0], velocity=[3.0])
    )
    assert np.array_equal(sample.velocity, [3.0])


def test_a_motion_keeps_empty_arrays_for_the_check():
    sample = conversions.sample_of_motion(JointMotion(header=HEADER, name=["a"], position=[1.0]))
    assert sample.stamp_ns == 3_000_000_004
    assert sample.velocity.shape == (0,)
    assert sample.acceleration.shape == (0,)


def test_a_joint_state_holds_what_is_known_and_leaves_the_rest_empty():
    message = conversions.joint_state(
        HEADER, ("a", "b"), np.array([1.0, 2.0]), effort=np.array([5.0, 6.0])
    )
    assert message.header == HEADER
    assert message.name == ["a", "b"]
    assert list(message.position) == [1.0, 2.0]
    assert not message.velocity
    assert list(message.effort) == [5.0, 6.0]


def test_poses_keep_their_order_x_y_z_w():
    wanted = Rotation.from_quat([0.1, 0.2, 0.3, 0.9])
    message = conversions.pose_stamped(HEADER, np.array([1.0, 2.0, 3.0]), wanted.as_matrix())
    p = message.pose.position
    assert (p.x, p.y, p.z) == (1.0, 2.0, 3.0)
    position, quaternion = conversions.pose_arrays(message.pose)
    assert np.array_equal(position, [1.0, 2.0, 3.0])
    np.testing.assert_allclose(quaternion, wanted.as_quat(), atol=1e-15)


@pytest.mark.parametrize("seed", range(40))
def test_quaternions_are_those_of_an_independent_library(seed):
    random = np.random.default_rng(seed)
    wanted = Rotation.from_quat(
        random.normal(size=4) * np.where(random.random(4) < 0.3, 0.0, 1.0) + [0, 0, 1e-9, 0]
    )
    found = quaternion(wanted.as_matrix())
    np.testing.assert_allclose(np.abs(np.dot(found, wanted.as_quat())), 1.0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(found), 1.0, atol=1e-15)
    assert found[3] >= 0.0


def test_a_name_with_a_nul_is_read_up_to_it_live_and_from_recordings():
    reader, decoder = StateReader(), Decoder(["q1"])
    data = joint_state(START, ["q1\0xx"], [2.5])
    assert [list(reader(data).names) for _ in range(3)] == [["q1"]] * 3
    samples = decoder.decode(messages_of([(START + k, data) for k in range(8)]))
    assert (samples.position[:, 0].tolist(), samples.rejected, samples.broken) == (
        [2.5] * 8,
        {},
        {},
    )


@pytest.mark.parametrize("count", [0, 1, 40])
def test_trajectories_go_through_pipes_as_they_are(count):
    """Whatever each point has: lengths differ, and times may be negative."""
    rng = np.random.default_rng(count)
    sent = JointTrajectory(joint_names=["a", "b"])
    sent.header.frame_id = "base"
    for k in range(count):
        rows = [rng.normal(size=size).tolist() for size in rng.integers(0, 4, 4)]
        point = JointTrajectoryPoint(
            positions=rows[0], velocities=rows[1], accelerations=rows[2], effort=rows[3]
        )
        point.time_from_start.sec, point.time_from_start.nanosec = k - 20, 10**9 - 1 - k
        sent.points.append(point)
    send_as_columns()
    request = ConvertTrajectory.Request(joints=sent, position_only=True)
    assert pickle.loads(ForkingPickler.dumps(request)) == request  # noqa: S301 - our own
    assert message_of(columns_of(sent)) == sent
    assert gc.isenabled()
