"""Ball joints on topics: angles in one chart, places that are those of forward kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import InputError, Pose, Robot, SingularityError
from hybrid_dynamics_ros.messages.joint_samples import OrderedMotion
from hybrid_dynamics_ros.messages.link_transforms import LinkTransforms
from hybrid_dynamics_ros.stream.evaluator import MotionEvaluator
from hybrid_dynamics_ros.stream.floating.first_charts import in_first_charts, require_first_charts
from tests.laws.test_multi_dof import (
    BALL,
    FREE,
    KNEE,
    crank_and_rocker,
    floating_robot,
    two_links,
)
from tests.sampling import examples


def turned(seed: int) -> Robot:
    """A ball joint, or a screw or planar joint, in a frame that stands anyhow."""
    rng = np.random.default_rng(seed)
    origin = {"xyz": rng.normal(size=3).tolist(), "rpy": rng.uniform(-3, 3, 3).tolist()}
    axis = rng.normal(size=3).tolist()
    kinds = ({"type": "ball"}, {"type": "screw", "pitch": 0.1}, {"type": "planar"})
    return two_links({**kinds[seed % 3], "axis": axis, "origin": origin}, active=[BALL, KNEE])


@given(st.integers(0, 10_000))
@examples(60)
def test_transforms_are_the_places_of_links_in_those_before(seed: int) -> None:
    robot = turned(seed)
    state = robot.close(np.random.default_rng(seed).uniform(-2, 2, len(robot.active)))
    slots = LinkTransforms(robot).values(state.s)
    for k, name in enumerate(robot.coordinates):
        joint = robot.description.joints[name]
        child = robot.forward_kinematics(state, joint.child)
        rotation, position = np.eye(3), np.zeros(3)
        if joint.parent != robot.base_frame:
            parent = robot.forward_kinematics(state, joint.parent)
            rotation, position = parent.rotation, parent.position
        translation, quaternion = slots[2 * k], slots[2 * k + 1]
        assert translation == pytest.approx(rotation.T @ (child.position - position), abs=1e-12)
        found = Rotation.from_quat(quaternion).as_matrix()
        assert found == pytest.approx(rotation.T @ child.rotation, abs=1e-12)


def evaluator(robot: Robot) -> MotionEvaluator:
    return MotionEvaluator(robot, bandwidth=10.0, max_gap=0.5)


def test_a_ball_joint_in_a_loop_is_streamed() -> None:
    robot = crank_and_rocker([-0.3, 0.2, 0.4])
    stream = evaluator(robot)
    for k in range(5):
        u = np.array([0.3 + 0.01 * k, 0.0])
        result = stream.step(k * 10_000_000, OrderedMotion(u, None, None))
        assert result.position == pytest.approx(robot.close(u).s)


def test_a_reference_without_good_angles_is_refused_and_so_is_such_a_state() -> None:
    quarter = [0.0, 0.5**0.5, 0.0, 0.5**0.5]
    robot = two_links({"type": "ball"}, active=[BALL, KNEE], reference={BALL: {"quat": quarter}})
    with pytest.raises(InputError, match="joint hip: its second turn is beyond a radian"):
        evaluator(robot)
    with pytest.raises(SingularityError, match="no good angles on topics"):
        require_first_charts(robot, robot.close(robot.reference))


@pytest.mark.parametrize("third", [0.4, 0.5 * np.pi])
@given(first=st.floats(-3.0, 3.0), second=st.floats(-1.5, 1.5), seed=st.integers(0, 99))
@examples(40)
def test_angles_and_rates_on_topics_are_those_of_pose_and_twist(
    third: float, first: float, second: float, seed: int
) -> None:
    robot = floating_robot()
    rng = np.random.default_rng(seed)
    turn = Rotation.from_euler("XYZ", [first, second, third]).as_matrix()
    pose, twist = Pose(rng.normal(size=3), turn), rng.normal(size=6)
    state = robot.close_at_poses({FREE: pose}, {FREE: twist}, du=np.ones(7))
    for one in (state, robot.recentred(state, leave=0.0)):
        s, ds = in_first_charts(robot, one)
        active = [robot.coordinates.index(name) for name in robot.active]
        back = robot.close(s[active], ds[active])
        assert robot.joint_pose(back, FREE).rotation == pytest.approx(turn, abs=1e-12)
        far = 1.0 / np.cos(second)  # condition of the angles there
        assert robot.joint_twist(back, FREE) == pytest.approx(twist, abs=1e-12 * far**2)


def test_at_a_quarter_turn_of_the_second_turn_there_are_no_rates() -> None:
    robot = floating_robot()
    turn = Rotation.from_euler("XYZ", [0.3, 0.5 * np.pi, 0.2]).as_matrix()
    state = robot.close_at_poses({FREE: Pose(np.zeros(3), turn)}, {FREE: np.ones(6)})
    s, ds = in_first_charts(robot, state)
    (joint,) = robot.description.freely_turning
    turns = [robot.coordinates.index(name) for name in joint.turns]
    assert Rotation.from_euler("XYZ", s[turns]).as_matrix() == pytest.approx(turn, abs=1e-9)
    assert np.isnan(ds[turns]).all()
    assert np.isfinite(np.delete(ds, turns)).all()
