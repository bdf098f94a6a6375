"""Services of robots whose ball joints in loops turn through every orientation."""

from __future__ import annotations

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import ErrorCode, JointMotion
from hybrid_dynamics_msgs.srv import (
    CloseLoops,
    ComputeJacobian,
    ConvertTrajectory,
    DescribeRobot,
    ForwardDynamics,
    InverseDynamics,
    ListAssemblyModes,
    MinimalForm,
    SolveFK,
    SolveIK,
)
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core import Robot
from hybrid_dynamics_ros.services.answers import guarded
from hybrid_dynamics_ros.services.context import ServiceContext
from hybrid_dynamics_ros.services.table import BY_NAME
from hybrid_dynamics_ros.stream.floating.first_charts import charts_of
from tests.laws.test_multi_dof import BALL, KNEE, two_links
from tests.ros.test_ball_joints import rod_on_a_ball
from tests.sampling import examples

BALL_TURNS = ("hip_rx", "hip_ry", "hip_rz")
RATE = 1.0  # [rad/s] of the crank
STEP = 1e-4  # [s]


def answer(robot: Robot, service: str, request: object) -> object:
    kind = BY_NAME[service].kind
    response, _ = guarded(BY_NAME[service].answer, ServiceContext(robot), request, kind.Response())
    assert response.error_code == ErrorCode.OK, response.error_text
    return response


def columns(motion: object) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of the turns of the ball, by the names of a message."""
    places = [list(motion.name).index(name) for name in BALL_TURNS]
    return np.array(motion.position)[places], np.array(motion.velocity)[places]


def motion_at(robot: Robot, u: float) -> JointMotion:
    """What ~/close_loops answers for the crank at u, at a constant rate."""
    given_ = JointMotion(name=["q1"], position=[u], velocity=[RATE], acceleration=[0.0])
    return answer(robot, "close_loops", CloseLoops.Request(given=given_)).motion


def second_charts(robot: Robot) -> list[float]:
    """Places of the crank at which the ball in the loop is in its second chart."""
    path = robot.close_path(0.3 + np.linspace(0.0, 2.0, 12)[:, None])
    charts = np.broadcast_to(charts_of(robot, path), (12, 1))
    return [float(path.u[k, 0]) for k in range(12) if np.any(charts[k] < 0.0)]


@given(st.integers(0, 10_000))
@examples(8)
def test_angles_of_services_are_those_of_the_urdf_in_both_charts(seed: int) -> None:
    robot = rod_on_a_ball(seed)
    for u in [0.3, *second_charts(robot)[:3]]:
        state = robot.close([u], [RATE])
        joints = JointState(name=["q1"], position=[u], velocity=[RATE], effort=[0.1])
        still = JointMotion(name=["q1"], position=[u], velocity=[RATE], acceleration=[0.0])
        found = [
            answer(robot, "solve_fk", SolveFK.Request(active_joints=joints)).joint_state,
            answer(robot, "inverse_dynamics", InverseDynamics.Request(motion=still)).joint_state,
            answer(robot, "forward_dynamics", ForwardDynamics.Request(active_joints=joints)).motion,
        ]
        expected = robot.joint_pose(state, "hip").rotation
        for message in found:
            angles, rates = columns(message)
            turned = Rotation.from_euler("XYZ", angles)
            assert turned.as_matrix() == pytest.approx(expected, abs=1e-9)
            later = Rotation.from_euler("XYZ", angles + STEP * rates)
            spin = (turned.inv() * later).as_rotvec() / STEP
            # a difference of first order, of turns whose rates grow beside the quarter turn
            far = 1.0 / np.cos(angles[1])
            assert spin == pytest.approx(robot.joint_twist(state, "hip"), abs=20.0 * STEP * far**3)


@given(st.integers(0, 10_000))
@examples(8)
def test_accelerations_of_services_are_the_differences_of_their_rates(seed: int) -> None:
    robot = rod_on_a_ball(seed)
    for u in second_charts(robot)[:3]:
        places = [robot.coordinates.index(name) for name in BALL_TURNS]
        here = motion_at(robot, u)
        before, after = motion_at(robot, u - STEP), motion_at(robot, u + STEP)
        angles, _ = columns(here)
        rises = (columns(after)[1] - columns(before)[1]) / (2.0 * STEP * RATE)
        far = 1.0 / np.cos(angles[1])
        # differences of second order
        expected = np.array(here.acceleration)[places]
        assert rises == pytest.approx(expected, rel=1e-5, abs=1e3 * STEP**2 * far**5)


def test_a_call_that_names_no_joint_says_which_there_are() -> None:
    robot = rod_on_a_ball(0)
    service = BY_NAME["close_loops"]
    request, empty = CloseLoops.Request(), CloseLoops.Response()
    response, _ = guarded(service.answer, ServiceContext(robot), request, empty)
    assert response.error_code == ErrorCode.BAD_INPUT
    words = f"no joint is named, expected 1 independent of {', '.join(robot.coordinates)}"
    assert response.error_text == words


def hip_and_knee(turn: np.ndarray) -> Robot:
    """A ball joint and a hinge, both driven, drawn at an orientation of the ball."""
    quaternion = Rotation.from_euler("XYZ", turn).as_quat().tolist()
    return two_links({"type": "ball"}, active=[BALL, KNEE], reference={BALL: {"quat": quaternion}})


ANGLES = st.tuples(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0))


@given(drawn=st.tuples(ANGLES, ANGLES), seed=st.integers(0, 999))
@example(drawn=((0.0, 0.5 * np.pi, 0.0), (0.3, 1.5, -2.0)), seed=0)
@examples(25)
def test_services_of_a_driven_ball_do_not_depend_on_the_orientation_in_which_it_is_drawn(
    drawn: tuple[tuple[float, ...], tuple[float, ...]], seed: int
) -> None:
    """The other robot is drawn upright, in angles of the URDF."""
    reference, at = (np.array(turns) for turns in drawn)
    robot, upright = hip_and_knee(reference), hip_and_knee(np.zeros(3))
    rng = np.random.default_rng(seed)
    names = list(robot.active)
    assert names == list(upright.active)
    position = [*at, rng.uniform(-1.0, 1.0)]
    rates, rises, efforts = (rng.normal(size=4).tolist() for _ in range(3))
    joints = JointState(name=names, position=position, velocity=rates, effort=efforts)
    motion = JointMotion(name=names, position=position, velocity=rates, acceleration=rises)
    requests = {
        "solve_fk": SolveFK.Request(active_joints=joints),
        "compute_jacobian": ComputeJacobian.Request(active_joints=joints),
        "inverse_dynamics": InverseDynamics.Request(motion=motion),
        "forward_dynamics": ForwardDynamics.Request(active_joints=joints),
        "minimal_form": MinimalForm.Request(active_joints=joints),
        "close_loops": CloseLoops.Request(given=motion),
        "list_assembly_modes": ListAssemblyModes.Request(active_joints=joints),
    }
    far = 1.0 / np.cos(at[1])  # condition of the angles there
    for name, request in requests.items():
        found, expected = (numbers(answer(one, name, request)) for one in (robot, upright))
        assert found == pytest.approx(expected, rel=1e-10 * far**2, abs=1e-10 * far**2), name
    described = answer(robot, "describe_robot", DescribeRobot.Request()).reference
    turned = Rotation.from_euler("XYZ", described[:3]).as_matrix()
    assert turned == pytest.approx(Rotation.from_euler("XYZ", reference).as_matrix(), abs=1e-9)


def numbers(message: object) -> list[float]:
    """All numbers of a message, in the order of its fields."""
    if isinstance(message, (bool, int, float, np.number)):
        return [float(message)]
    if hasattr(message, "get_fields_and_field_types"):
        parts = [getattr(message, name) for name in message.get_fields_and_field_types()]
    elif isinstance(message, str):
        return []
    else:
        parts = list(message)
    return [number for part in parts for number in numbers(part)]


@given(reference=ANGLES, at=ANGLES, knee=st.floats(-1.0, 1.0))
@examples(15)
def test_a_driven_ball_reaches_what_its_forward_kinematics_show(
    reference: tuple[float, ...], at: tuple[float, ...], knee: float
) -> None:
    robot = hip_and_knee(np.array(reference))
    joints = JointState(name=list(robot.active), position=[*at, knee])
    there = answer(robot, "solve_fk", SolveFK.Request(active_joints=joints)).poses[0]
    target = SolveIK.Request(target=there, position_only=True)
    solution = answer(robot, "solve_ik", target).solution
    back = answer(robot, "solve_fk", SolveFK.Request(active_joints=solution)).poses[0]
    for axis in "xyz":
        found, wanted = (getattr(pose.pose.position, axis) for pose in (back, there))
        assert found == pytest.approx(wanted, abs=1e-6)  # the solver's own tolerance
    trajectory = JointTrajectory(joint_names=list(robot.active))
    for k, place in enumerate((list(joints.position), list(solution.position))):
        point = JointTrajectoryPoint(positions=place)
        point.time_from_start.sec = 3 * k
        trajectory.points.append(point)
    request = ConvertTrajectory.Request(joints=trajectory)
    points = answer(robot, "convert_trajectory", request).trajectory.points
    for point, place in zip((points[0], points[-1]), (joints, solution), strict=True):
        ends = (point.positions[:3], place.position[:3])
        found, wanted = (Rotation.from_euler("XYZ", list(end)).as_matrix() for end in ends)
        assert found == pytest.approx(wanted, abs=1e-9)
