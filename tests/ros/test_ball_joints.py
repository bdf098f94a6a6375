"""Ball joints on topics: angles in one chart, places that are those of forward kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import InputError, Pose, Robot, SingularityError
from hybrid_dynamics_core.algebra.charts import rate_matrix
from hybrid_dynamics_ros.messages.joint_samples import OrderedMotion
from hybrid_dynamics_ros.messages.link_transforms import LinkTransforms
from hybrid_dynamics_ros.stream.evaluator import MotionEvaluator
from hybrid_dynamics_ros.stream.floating.first_charts import in_first_charts, require_first_charts
from tests.laws.test_multi_dof import (
    BALL,
    FREE,
    KNEE,
    body,
    crank_and_rocker,
    floating_robot,
    robot_of,
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


def rod_on_a_ball(seed: int) -> Robot:
    """A crank and a rocker joined by a rod, on a ball joint that is drawn anyhow."""
    turn = Rotation.random(random_state=seed).as_euler("xyz").tolist()
    return robot_of(
        links={"crank": body(1.0), "rod": body(0.5), "l2": body(1.0), "x": {}, "y": {}},
        joints={
            "q1": {"type": "revolute", "parent": "base", "child": "crank", "axis": "z"},
            "q2": {
                "type": "revolute",
                "parent": "base",
                "child": "l2",
                "axis": "y",
                "origin": {"xyz": [0.8, 0.1, 0.4]},
            },
            "q3": {
                "type": "revolute",
                "parent": "l2",
                "child": "x",
                "axis": "x",
                "origin": {"xyz": [0.5, 0, 0]},
            },
            "q4": {"type": "revolute", "parent": "x", "child": "y", "axis": "y"},
            BALL: {
                "type": "ball",
                "parent": "crank",
                "child": "rod",
                "origin": {"xyz": [0.2, 0, 0], "rpy": turn},
            },
        },
        closures={
            "pin": {
                "kind": "frame",
                "between": {"rod": {"xyz": [0, 0, 1.0]}, "y": {"xyz": [0, 0, 0]}},
            }
        },
        active=["q1"],
        reference={"q1": 0.3},
    )


@given(st.integers(0, 10_000))
@examples(16)
@pytest.mark.parametrize("measured", ["q1", "q2"])
def test_a_ball_joint_in_a_loop_has_the_angles_of_the_urdf_in_both_charts(
    measured: str, seed: int
) -> None:
    robot = rod_on_a_ball(seed)
    stream = MotionEvaluator(robot, bandwidth=10.0, max_gap=0.5, measured=[measured])
    u = 0.3 + np.linspace(0.0, 2.0 if measured == "q1" else 0.2, 12)[:, None]
    path = robot.close_path(u, du=np.ones_like(u))
    column = robot.coordinates.index(measured)
    ball = [robot.coordinates.index(name) for name in ("hip_rx", "hip_ry", "hip_rz")]
    for k, (value, rate) in enumerate(zip(path.s[:, column], path.ds[:, column], strict=True)):
        motion = OrderedMotion(np.array([value]), np.array([rate]), np.zeros(1))
        result = stream.evaluate(k * 10_000_000, motion)
        expected = path.rows(k)
        slots = LinkTransforms(robot).values(result.position)
        turns = [Rotation.from_quat(slots[2 * index + 1]) for index in ball]
        found = (turns[0] * turns[1] * turns[2]).as_matrix()
        crank = robot.forward_kinematics(expected, "crank").rotation
        rod = robot.forward_kinematics(expected, "rod").rotation
        assert crank @ found == pytest.approx(rod, abs=1e-7)
        assert result.velocity is not None
        spin = rate_matrix(result.position[ball]) @ result.velocity[ball]
        assert spin == pytest.approx(robot.joint_twist(expected, BALL), abs=1e-6)


def test_rows_have_the_bits_of_samples() -> None:
    robots = (rod_on_a_ball(seed) for seed in range(20))
    robot = next(one for one in robots if -1.0 in one.description.charts.values())
    u = 0.3 + np.linspace(0.0, 2.0, 12)[:, None]
    motion = OrderedMotion(u, np.ones_like(u), np.zeros_like(u))
    stamps = np.arange(len(u)) * 10_000_000
    rows = evaluator(robot).evaluate(stamps, motion)
    stream = evaluator(robot)
    for k, stamp in enumerate(stamps.tolist()):
        one = OrderedMotion(u[k], np.ones(1), np.zeros(1))
        result = stream.evaluate(stamp, one)
        np.testing.assert_array_equal(result.position, rows.position[k])
        np.testing.assert_array_equal(result.velocity, rows.velocity[k])


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
