"""Ball joints on topics: angles in one chart, places that are those of forward kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import InputError, Robot, SingularityError
from hybrid_dynamics_ros.messages.joint_samples import OrderedMotion
from hybrid_dynamics_ros.messages.link_transforms import LinkTransforms
from hybrid_dynamics_ros.stream.evaluator import MotionEvaluator
from hybrid_dynamics_ros.stream.floating.first_charts import require_first_charts
from tests.laws.test_multi_dof import BALL, KNEE, crank_and_rocker, two_links
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
