"""Inverse kinematics in closed form, where the end effector has coordinates of its own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import IKStatus, Pose, Robot, load, shipped_robots
from tests.sampling import examples, swept
from tests.strategies import positions

WITH_PLATFORM = ("ankle", "delta", "gough", "staicu2015")


@pytest.mark.parametrize("name", shipped_robots())
def test_which_robots_have_one(name: str) -> None:
    assert (load(name).pose_chain is not None) == (name in WITH_PLATFORM)


@pytest.fixture(scope="module", params=swept(WITH_PLATFORM))
def robot(request: pytest.FixtureRequest) -> Robot:
    return load(request.param)


@examples(15)
@given(data=st.data())
def test_the_pose_is_reached_without_iterations(robot: Robot, data: st.DataObject) -> None:
    u = robot.reference + 0.5 * (data.draw(positions(robot)) - robot.reference)
    state = robot.close(u, check=False)
    assume(state.status == 0 and state.singularity > 0.1)
    pose = robot.forward_kinematics(state)
    result = robot.inverse_kinematics(pose)
    assert result.status is IKStatus.SOLVED
    assert result.iterations == 0
    reached = robot.forward_kinematics(robot.close(result.u))
    assert reached.position == pytest.approx(pose.position, abs=1e-12)
    assert reached.rotation == pytest.approx(pose.rotation, abs=1e-12)


def test_a_position_leaves_the_turns_at_the_seed(robot: Robot) -> None:
    slides = robot.pose_chain is not None and len(robot.pose_chain.slides) == 3
    state = robot.close(robot.reference)
    target = robot.forward_kinematics(state).position + (
        0.01 if slides else 0.0
    )  # the ankle only turns
    result = robot.inverse_kinematics(target)
    assert result.status is IKStatus.SOLVED
    assert result.iterations == 0
    moved = robot.forward_kinematics(robot.close(result.u))
    assert moved.position == pytest.approx(target, abs=1e-12)
    assert moved.rotation == pytest.approx(robot.forward_kinematics(state).rotation, abs=1e-12)


def test_a_pose_that_the_platform_cannot_have_is_told(robot: Robot) -> None:
    pose = robot.forward_kinematics(robot.close(robot.reference))
    result = robot.inverse_kinematics(Pose(pose.position + 50.0, pose.rotation))
    if np.isfinite(robot.limits).any():
        assert result.status in (IKStatus.OUT_OF_REACH, IKStatus.LIMIT)
    else:  # legs without limits reach as far
        assert result.status is IKStatus.SOLVED
    assert np.isfinite(result.residual)
