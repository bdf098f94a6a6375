"""Limits of drives and pumps in the node: diagnostics, bags and retimed trajectories."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_ros.parameters import RETIME, NodeSettings
from hybrid_dynamics_ros.services import trajectory_motion
from hybrid_dynamics_ros.services.answers import guarded
from hybrid_dynamics_ros.services.context import ServiceContext
from hybrid_dynamics_ros.services.trajectory import convert_trajectory, motion_of_joints
from hybrid_dynamics_ros.services.trajectory_limits import MotionLimits
from hybrid_dynamics_ros.stream.limit_margins import beyond_in_rows
from hybrid_dynamics_ros.stream.situation import Situation
from tests.limits.machines import crane


def request_of(names, positions):
    """A request for points a second apart."""
    points = []
    for k, position in enumerate(positions):
        point = JointTrajectoryPoint(positions=[float(value) for value in position])
        point.time_from_start.sec = k
        points.append(point)
    joints = JointTrajectory(joint_names=list(names), points=points)
    return ConvertTrajectory.Request(joints=joints)


def converted(robot, positions, share, tolerance=0.0, names=()):
    """The answer for points a second apart, with a share of the limits."""
    settings = NodeSettings({RETIME.name: share, "trajectory.effort_tolerance": tolerance})
    context = ServiceContext(robot, Situation(settings=settings))
    request = request_of(names or robot.active, positions)
    response, _ = guarded(convert_trajectory, context, request, ConvertTrajectory.Response())
    return response


def followed(robot, message):
    """What a controller does with a trajectory: states, accelerations on a fine grid."""
    motion = motion_of_joints(robot, message).motion()
    numbers = np.linspace(0, motion.time.size - 1, 12 * (motion.time.size - 1) + 1)
    times = np.interp(numbers, np.arange(motion.time.size), motion.time)
    points = [motion.at(time) for time in times.tolist()]
    u, du, ddu = (np.array(column) for column in zip(*points, strict=True))
    return times, robot.close(u, du), ddu


@pytest.mark.parametrize("share", [0.8, 1.0])
@pytest.mark.parametrize("tolerance", [0.0, 0.01])
def test_a_retimed_trajectory_keeps_all_limits_between_its_points(share, tolerance, monkeypatch):
    monkeypatch.setattr(trajectory_motion, "_STATIONS", 30)
    robot = crane()
    ends = [[0.2, 0.2], [0.3, 0.3], [0.25, 0.4]]
    response = converted(robot, ends, share, tolerance)
    assert response.error_code == ErrorCode.OK, response.error_text
    times, state, ddu = followed(robot, response.trajectory)
    margins = robot.limit_margins(state, ddu)
    assert margins.beyond == ()
    dynamic = [k for k, row in enumerate(margins.rows) if row.kind != "position"]
    # what rounding of the stamps to nanoseconds and the grid of the search may miss
    assert margins.shares[:, dynamic].min() >= 1.0 - share - 1e-3
    fastest = robot.retime(ends, stations=30, share=share)
    # joined stations and ramps cost next to nothing
    assert fastest.duration * (1.0 - 1e-9) <= times[-1] < 1.05 * fastest.duration
    assert state.u[[0, -1]] == pytest.approx(np.array(ends)[[0, -1]])
    assert not state.du[[0, -1]].any()


def test_a_path_of_serial_joints_is_retimed_too(monkeypatch):
    """The pins of the crane are as far along straight lines as its cylinders bring them."""
    monkeypatch.setattr(trajectory_motion, "_STATIONS", 30)
    robot = crane()
    names = ("arm_pitch", "boom_pitch")
    places = [robot.coordinates.index(name) for name in names]
    ends = robot.close([[0.2, 0.2], [0.3, 0.35]]).s[:, places]
    response = converted(robot, ends, 0.9, names=names)
    assert response.error_code == ErrorCode.OK, response.error_text
    _, state, ddu = followed(robot, response.trajectory)
    assert robot.limit_margins(state, ddu).beyond == ()
    way = (state.s[:, places] - ends[0]) / (ends[1] - ends[0])
    # cubic splines of the cylinders through 30 points of a straight line
    assert way[:, 0] == pytest.approx(way[:, 1], abs=1e-5)


@pytest.mark.sweep(sample="test_a_trajectory_with_too_much_flow_is_refused_by_the_name_of_the_pump")
def test_a_node_keeps_trajectories_within_what_its_drives_can_do(start_node, connect, tmp_path):
    """A process of its own: a motion beyond a drive's power is refused, and one in time is not."""
    robot = crane(("power_limit: 5*kW", "power_limit: 2*kW"))
    path = tmp_path / "crane.yaml"
    path.write_text(to_yaml(robot))
    start_node(
        "-r", "__ns:=/lift", "-p", f"robot:={path}", "-p", "trajectory.effort_tolerance:=0.0"
    )
    client = connect("/lift/hybrid_dynamics", only=("convert_trajectory",))
    request = request_of(robot.active, [[0.2, 0.2], [0.3, 0.3]])
    request.joints.points[1].time_from_start.sec = 0
    request.joints.points[1].time_from_start.nanosec = 7 * 10**8
    refused = client.call("convert_trajectory", request)
    assert refused.error_code == ErrorCode.LIMIT
    assert "the pump 'main' gives a power of 2000 W, expected no more" in refused.error_text
    assert 0.0 < refused.first_bad_time < 0.7
    client.set_parameter(RETIME.name, 0.9)
    given = client.call("convert_trajectory", request)
    assert given.error_code == ErrorCode.OK, given.error_text
    _, state, ddu = followed(robot, given.trajectory)
    assert robot.limit_margins(state, ddu).beyond == ()


def test_a_path_that_cannot_be_held_is_refused_with_the_reason():
    robot = crane(("supply_pressure: 210*bar, flow", "supply_pressure: 10*bar, flow"))
    response = converted(robot, [[0.1, 0.1], [0.4, 0.4]], 0.9)
    assert response.error_code == ErrorCode.LIMIT
    assert "the drives cannot hold crane at rest" in response.error_text


def test_a_trajectory_with_too_much_flow_is_refused_by_the_name_of_the_pump():
    robot = crane()
    response = converted(robot, [[0.1, 0.1], [0.5, 0.5]], 0.0)
    assert response.error_code == ErrorCode.LIMIT
    assert "takes" in response.error_text or "the pump 'main' gives" in response.error_text
    assert "expected no more than" in response.error_text


def test_bounds_of_a_motion_are_the_margins_of_the_robot():
    robot = crane()
    state = robot.close([0.3, 0.2], [0.2, 0.1])
    tau = robot.inverse_dynamics(state, [0.5, 0.1])
    margins = robot.limit_margins(state, [0.5, 0.1])
    bounds = MotionLimits(robot, 0.0).margins(state, tau, np.array([0.5, 0.1]))
    assert bounds[:-1] == pytest.approx(margins.margins, rel=1e-6)


def test_a_report_names_what_a_recorded_motion_exceeded_and_when():
    robot = crane()
    time = np.linspace(0.0, 1.0, 11)
    u = np.stack([0.1 + 0.4 * time**2, np.full(11, 0.2)], axis=1)
    du = np.stack([0.8 * time, np.zeros(11)], axis=1)
    ddu = np.stack([np.full(11, 0.8), np.zeros(11)], axis=1)
    state = robot.close(u, du)
    efforts = robot.inverse_dynamics(state, ddu)
    efforts[3] = np.nan
    texts = beyond_in_rows(robot, time, state, efforts, ddu)
    assert any("cylinder of lift_cylinder takes" in text for text in texts)
    assert all(text.endswith("at 1.000 s") for text in texts if "flow" in text)
    slow = replace(state, ds=0.01 * state.ds)
    assert beyond_in_rows(robot, time, slow, efforts, 0.0 * ddu) == []
