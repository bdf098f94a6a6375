"""Limits of drives and pumps in the node: diagnostics, bags and retimed trajectories."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_ros.parameters import RETIME, NodeSettings
from hybrid_dynamics_ros.services import trajectory_motion
from hybrid_dynamics_ros.services.answers import guarded
from hybrid_dynamics_ros.services.context import ServiceContext
from hybrid_dynamics_ros.services.trajectory import convert_trajectory
from hybrid_dynamics_ros.services.trajectory_limits import MotionLimits
from hybrid_dynamics_ros.stream.limit_margins import beyond_in_rows
from hybrid_dynamics_ros.stream.situation import Situation
from tests.limits.machines import crane


def converted(robot, positions, share):
    """The answer for points a second apart, with a share of the limits."""
    points = []
    for k, position in enumerate(positions):
        point = JointTrajectoryPoint(positions=position)
        point.time_from_start.sec = k
        points.append(point)
    joints = JointTrajectory(joint_names=list(robot.active), points=points)
    settings = NodeSettings({RETIME.name: share, "trajectory.effort_tolerance": 0.0})
    context = ServiceContext(robot, Situation(settings=settings))
    request = ConvertTrajectory.Request(joints=joints)
    response, _ = guarded(convert_trajectory, context, request, ConvertTrajectory.Response())
    return response


def test_a_retimed_trajectory_keeps_all_limits(monkeypatch):
    monkeypatch.setattr(trajectory_motion, "_STATIONS", 20)
    robot = crane()
    ends = [[0.2, 0.2], [0.3, 0.3]]
    response = converted(robot, ends, 0.8)
    assert response.error_code == ErrorCode.OK, response.error_text
    points = response.trajectory.points
    last = points[-1].time_from_start
    duration = last.sec + 1e-9 * last.nanosec
    assert duration == pytest.approx(robot.retime(ends, stations=20, share=0.8).duration)
    u = np.array([point.positions for point in points])
    du = np.array([point.velocities for point in points])
    ddu = np.array([point.accelerations for point in points])
    assert robot.limit_margins(robot.close(u, du), ddu).beyond == ()
    assert u[[0, -1]] == pytest.approx(np.array(ends))
    assert not du[[0, -1]].any()


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
