"""What calls of services may leave out, given: answers are those of `close` and of differences."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import ComputeJacobian, ConvertTrajectory
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import JointState

from hybrid_dynamics_ros.services.answers import guarded
from hybrid_dynamics_ros.services.call_counts import CallCounts
from hybrid_dynamics_ros.services.context import ServiceContext
from hybrid_dynamics_ros.services.kinematics import compute_jacobian
from hybrid_dynamics_ros.services.trajectory import convert_trajectory
from hybrid_dynamics_ros.stream.monitor import Level
from tests.sampling import examples

STEP = 1e-5  # of differences [rad or m]
CODES = {name: getattr(ErrorCode, name) for name in dir(type(ErrorCode)) if name.isupper()}
UNSERVED = ("BUSY", "TIMEOUT", "INTERNAL")


def answer_of(robot, answer, kind, **fields):
    response, _ = guarded(answer, ServiceContext(robot), kind.Request(**fields), kind.Response())
    assert response.error_code == ErrorCode.OK, response.error_text
    return response


def joints(robot, u):
    return JointState(name=list(robot.active), position=np.asarray(u).tolist())


def velocity_of(robot, frame, u, joint):
    """Of a frame at unit speed of one active joint, by differences: (6,)."""
    ends = []
    for sign in (-1.0, 1.0):
        moved = u + sign * STEP * np.eye(len(u))[joint]
        ends.append(robot.forward_kinematics(robot.close(moved), frame))
    linear = (ends[1].position - ends[0].position) / (2.0 * STEP)
    turned = (ends[1].rotation @ ends[0].rotation.T - np.eye(3)) / (2.0 * STEP)
    spin = 0.5 * np.array(
        [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
    )
    return np.concatenate([linear, spin])


def test_the_jacobian_is_that_of_the_frame_that_is_asked_for(robot):
    u = robot.reference + 0.01
    frames = ["", robot.end_effector, *robot.frames[1::4]]
    assert robot.end_effector not in frames[2:]
    for frame in frames:
        asked = {"active_joints": joints(robot, u), "frame": frame}
        response = answer_of(robot, compute_jacobian, ComputeJacobian, **asked)
        jacobian = np.reshape(response.jacobian, (6, len(u)))
        place = frame or robot.end_effector
        expected = [velocity_of(robot, place, u, joint) for joint in range(len(u))]
        np.testing.assert_allclose(jacobian, np.transpose(expected), atol=1e-8)


@pytest.mark.parametrize("begin", [0, 7])
@pytest.mark.parametrize("has_start", [True, False])
def test_times_of_a_path_count_from_its_first_pose(robot, begin, has_start):
    u = robot.reference + np.linspace(0.0, 1.0, 3)[:, None] * 0.01
    request = {"position_only": True}
    if has_start:
        request["start"] = joints(robot, u[0])
    path = []
    for k, place in enumerate(robot.forward_kinematics(robot.close(u)).position):
        pose = PoseStamped()
        pose.header.stamp.sec = begin + 2 * k
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = place.tolist()
        path.append(pose)
    response = answer_of(robot, convert_trajectory, ConvertTrajectory, path=path, **request)
    assert response.trajectory.header.stamp.sec == begin
    points = response.trajectory.points
    ends = [points[0].time_from_start, points[-1].time_from_start]
    assert [(time.sec, time.nanosec) for time in ends] == [(0, 0), (4, 0)]
    for point, active in ((points[0], u[0]), (points[-1], u[-1])):
        tool = robot.forward_kinematics(robot.close(np.array(point.positions))).position
        expected = robot.forward_kinematics(robot.close(active)).position
        np.testing.assert_allclose(tool, expected, atol=1e-7)


@examples(200)
@given(st.lists(st.lists(st.sampled_from(sorted(CODES)), max_size=5), min_size=1, max_size=4))
def test_a_report_warns_of_calls_that_were_not_served_since_the_last(rounds):
    counts, total = CallCounts(), 0
    for names in rounds:
        for name in names:
            counts.note("solve_ik", CODES[name], name.lower())
        total += len(names)
        recent = sum(name in UNSERVED for name in names)
        entries = {entry.name: entry for entry in counts.report()}
        unserved = entries["not served since last report"]
        assert (unserved.value, unserved.level is Level.WARN) == (str(recent), recent > 0)
        assert entries["calls answered"].value == str(total)


def test_levels_are_the_numbers_of_diagnostic_messages():
    for level in Level:
        assert getattr(DiagnosticStatus, level.name) == bytes([level])
