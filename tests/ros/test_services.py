"""Services as functions.

What cannot be provoked from outside, and the mapping of errors to codes.
"""

import dataclasses
import os
from multiprocessing import Pipe

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import (
    CloseLoops,
    ForwardDynamics,
    InverseDynamics,
    ListAssemblyModes,
    SolveFK,
    SolveIK,
    SwitchAssemblyMode,
)
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core import IKStatus, Robot, load
from hybrid_dynamics_core.errors import (
    ClosureError,
    HybridDynamicsError,
    InputError,
    SingularityError,
)
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_ros.messages.joint_samples import RejectedError, RejectionCode
from hybrid_dynamics_ros.services import worker
from hybrid_dynamics_ros.services.answers import guarded
from hybrid_dynamics_ros.services.context import ServiceContext
from hybrid_dynamics_ros.services.dynamics import forward_dynamics, inverse_dynamics
from hybrid_dynamics_ros.services.kinematics import IK_CODES, close_loops, solve_fk, solve_ik
from hybrid_dynamics_ros.services.modes import list_assembly_modes, switch_assembly_mode
from hybrid_dynamics_ros.services.table import TABLE
from hybrid_dynamics_ros.services.trajectory import motion_of_joints
from hybrid_dynamics_ros.stream.situation import Situation
from tests.export.test_round_trip import CART

ACTIVE = ["q1", "q12", "q22", "q4"]
POSITION = [0.8726646259971648, 0.15000000000000002, 0.175, 0.4363323129985824]


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ClosureError("loop L cannot close", loop="L"), ErrorCode.OUT_OF_REACH),
        (SingularityError("loop L is singular", loop="L", distance=0.0), ErrorCode.SINGULAR),
        (InputError("no frame 'x'"), ErrorCode.BAD_INPUT),
        (RejectedError(RejectionCode.MISSING_JOINT, "missing joint q1"), ErrorCode.BAD_INPUT),
        (RejectedError(RejectionCode.OVERFLOW, "too large"), ErrorCode.BAD_INPUT),
        (RejectedError(RejectionCode.BAD_REQUEST, "another frame"), ErrorCode.BAD_INPUT),
        (RejectedError(RejectionCode.NOT_READY, "no input yet"), ErrorCode.NOT_READY),
        (RejectedError(RejectionCode.REFUSED, "it moves"), ErrorCode.REFUSED),
        (HybridDynamicsError("odd"), ErrorCode.INTERNAL),
        (ZeroDivisionError("a bug"), ErrorCode.INTERNAL),
    ],
)
@pytest.mark.parametrize("kind", [service.kind for service in TABLE])
def test_whatever_fails_the_client_gets_a_code_a_text_and_nothing_half_done(
    robot, kind, error, code
):
    def answer(_context, _request, response):
        if hasattr(response, "joint_state"):
            response.joint_state.name = ["half done"]
        raise error

    response, conditions = guarded(answer, ServiceContext(robot), kind.Request(), kind.Response())
    assert conditions is None
    assert response.error_code == code
    assert str(error) in response.error_text
    if hasattr(response, "joint_state"):
        assert not response.joint_state.name
    if hasattr(response, "residual"):
        assert np.isnan(response.residual)


class Unlucky:
    """A robot whose inverse kinematics ends with a chosen status."""

    def __init__(self, robot, status):
        self._robot, self._status = robot, status

    def __getattr__(self, name):
        return getattr(self._robot, name)

    def inverse_kinematics(self, target, seed=None, all_solutions=False, mask=None, near=None):
        return dataclasses.replace(
            self._robot.inverse_kinematics(target, seed, all_solutions, mask, near),
            status=self._status,
            message="no\nluck",
        )


@pytest.mark.parametrize(
    ("status", "code"),
    [
        (IKStatus.OUT_OF_REACH, ErrorCode.OUT_OF_REACH),
        (IKStatus.LIMIT, ErrorCode.LIMIT),
        (IKStatus.SINGULAR, ErrorCode.SINGULAR),
        (IKStatus.NOT_FOUND, ErrorCode.NOT_CONVERGED),
        (IKStatus.NOT_CONVERGED, ErrorCode.NOT_CONVERGED),
    ],
)
def test_the_statuses_of_the_solver_become_codes_beside_the_nearest_joints(robot, status, code):
    request = SolveIK.Request(position_only=True)
    point = request.target.pose.position
    point.x, point.y, point.z = 0.3226478557853928, 0.38451674127506036, 1.1179125884719605
    response, _ = guarded(
        solve_ik, ServiceContext(Unlucky(robot, status)), request, SolveIK.Response()
    )
    assert response.error_code == code
    assert response.error_text == "no luck"
    assert 0.0 <= response.residual < 1e-6  # how near the solver came
    assert list(response.solution.name) == list(robot.coordinates)
    state = robot.close(np.array(response.solution.position)[: len(robot.active)])
    distance = np.linalg.norm(
        robot.forward_kinematics(state).position - [point.x, point.y, point.z]
    )
    assert abs(distance - response.residual) < 1e-12  # rounding of one sum
    assert not response.solutions


def test_every_failure_of_the_solver_has_a_code():
    """One each, but for the two by which nothing is known of the target."""
    assert set(IK_CODES) == set(IKStatus) - {IKStatus.SOLVED}
    unknown = (IKStatus.NOT_FOUND, IKStatus.NOT_CONVERGED)
    assert {IK_CODES[status] for status in unknown} == {ErrorCode.NOT_CONVERGED}
    assert len(set(IK_CODES.values())) == len(IK_CODES) - 1


def test_frames_come_in_the_order_asked_for(robot):
    request = SolveFK.Request(
        active_joints=JointState(name=ACTIVE, position=POSITION),
        frames=[robot.end_effector, robot.base_frame],
    )
    response, _ = guarded(solve_fk, ServiceContext(robot), request, SolveFK.Response())
    assert response.error_code == ErrorCode.OK, response.error_text
    tool, base = (pose.pose.position for pose in response.poses)
    np.testing.assert_allclose(
        [tool.x, tool.y, tool.z], [0.3226478557853928, 0.38451674127506036, 1.1179125884719605]
    )
    assert [base.x, base.y, base.z] == [0.0, 0.0, 0.0]
    assert not response.joint_state.velocity


def test_numbers_too_large_are_bad_input_not_an_infinite_answer(robot):
    request = InverseDynamics.Request()
    request.motion.name = ACTIVE
    request.motion.position = POSITION
    request.motion.velocity = [1e300] * 4
    request.motion.acceleration = [0.0] * 4
    response, _ = guarded(
        inverse_dynamics, ServiceContext(robot), request, InverseDynamics.Response()
    )
    assert response.error_code == ErrorCode.BAD_INPUT
    assert not response.efforts.effort


def test_quaternions_near_unit_length_are_taken(robot):
    pose = robot.forward_kinematics(robot.close(np.array(POSITION)))
    request = SolveIK.Request()
    target = request.target.pose
    target.position.x, target.position.y, target.position.z = pose.position.tolist()
    x, y, z, w = (1.0005 * pose.quaternion).tolist()
    target.orientation.x, target.orientation.y, target.orientation.z, target.orientation.w = (
        x,
        y,
        z,
        w,
    )
    response, _ = guarded(solve_ik, ServiceContext(robot), request, SolveIK.Response())
    assert response.error_code == ErrorCode.OK, response.error_text
    np.testing.assert_allclose(response.solution.position[:4], POSITION, atol=1e-9)


@pytest.mark.parametrize("newest", [None, np.array(POSITION)])
@pytest.mark.parametrize(
    ("loop", "mode", "said"),
    [
        (
            "theta_11",
            "clockwise",
            "there is no loop 'theta_11' (did you mean 'theta_1'?); known: theta_1, theta_2, ",
        ),
        (
            "theta_1",
            "clockwis",
            (
                "loop 'theta_1' has no mode 'clockwis' (did you mean 'clockwise'?); known:"
                " counterclockwise, clockwise"
            ),
        ),
        ("theta_3", "clockwise", "loop 'theta_3' has no mode 'clockwise'; known: parallelogram"),
    ],
)
def test_unknown_loops_and_modes_are_told_before_all_else(robot, newest, loop, mode, said):
    request = SwitchAssemblyMode.Request(loops=[loop], branches=[mode])
    response, change = guarded(
        switch_assembly_mode,
        ServiceContext(robot, Situation(newest=newest)),
        request,
        SwitchAssemblyMode.Response(),
    )
    assert (response.error_code, change) == (ErrorCode.BAD_INPUT, None)
    assert response.error_text.startswith(said)


def test_a_mode_that_a_loop_may_have_and_has_not_here_is_told_with_those_it_has():
    """The platform closes by iteration, so that its modes have numbers.

    Which there are depends on the place.
    """
    gough = load("gough")
    request = SwitchAssemblyMode.Request(loops=[gough.loops[0]], branches=["mode_999"])
    context = ServiceContext(gough, Situation(newest=gough.reference))
    response, _ = guarded(switch_assembly_mode, context, request, SwitchAssemblyMode.Response())
    said = f"loop '{gough.loops[0]}' does not close as 'mode_999' here (did you mean 'mode_"
    assert response.error_text.startswith(said)


def test_before_any_input_each_service_says_what_can_be_done_there(robot):
    request = SwitchAssemblyMode.Request(loops=["theta_1"], branches=["clockwise"])
    switched, _ = guarded(
        switch_assembly_mode, ServiceContext(robot), request, SwitchAssemblyMode.Response()
    )
    listed, _ = guarded(
        list_assembly_modes,
        ServiceContext(robot),
        ListAssemblyModes.Request(),
        ListAssemblyModes.Response(),
    )
    assert switched.error_code == listed.error_code == ErrorCode.NOT_READY
    assert (
        switched.error_text
        == "no input has come yet: send joint states to ~/active_joint_states, which say where the"
        " robot stands; the assembly modes to begin with stand in the robot file"
    )
    assert listed.error_text.endswith(
        "send joint states to ~/active_joint_states, or name the active joints in the call"
    )


def test_arrays_that_are_missing_are_told_with_what_is_expected(robot):
    request = InverseDynamics.Request()
    request.motion.name, request.motion.position = ACTIVE, POSITION
    response, _ = guarded(
        inverse_dynamics, ServiceContext(robot), request, InverseDynamics.Response()
    )
    assert response.error_code == ErrorCode.BAD_INPUT
    assert (
        response.error_text
        == "velocity has 0 values for 4 joint names; expected 4, zeros for a robot at rest"
    )


@pytest.mark.parametrize(
    ("efforts", "text"),
    [
        ([0.0, np.nan, 0.0, 0.0], "effort of joint q12 is nan"),
        ([0.0, 0.0, 0.0, -1e300], "effort of joint q4 is -1e+300, expected less than 1e+12"),
        ([0.0], "effort has 1 value for 4 joint names; expected 4"),
    ],
)
def test_bad_efforts_are_named_as_efforts(robot, efforts, text):
    joints = JointState(name=ACTIVE, position=POSITION, effort=efforts)
    request = ForwardDynamics.Request(active_joints=joints)
    response, _ = guarded(
        forward_dynamics, ServiceContext(robot), request, ForwardDynamics.Response()
    )
    assert response.error_code == ErrorCode.BAD_INPUT
    assert response.error_text == text


def test_idle_joints_need_not_be_named():
    cart = Robot(parse_description(CART))
    context = ServiceContext(cart)
    named = JointState(name=["x"], position=[0.2], velocity=[0.1], effort=[3.0])
    request = ForwardDynamics.Request(active_joints=named)
    response, _ = guarded(forward_dynamics, context, request, ForwardDynamics.Response())
    assert response.error_text == ""
    expected = cart.forward_dynamics(cart.close([0.2, 0.0], [0.1, 0.0]), [3.0, 0.0])
    assert list(response.motion.acceleration) == expected.tolist()
    closing = CloseLoops.Request()
    closing.given.name, closing.given.position = ["x"], [0.2]
    response, _ = guarded(close_loops, context, closing, CloseLoops.Response())
    assert response.error_text == ""
    assert list(response.motion.position) == [0.2, 0.0]
    points = [JointTrajectoryPoint(positions=[0.1 * k]) for k in range(3)]
    motion = motion_of_joints(cart, JointTrajectory(joint_names=["x"], points=points))
    assert motion.names == ("x", "th")
    assert motion.position.tolist() == [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]


def test_a_worker_that_cannot_make_its_robot_says_why(monkeypatch):
    """An OSError of the robot is not taken for one of the pipe, which means that the node ended."""

    def fail(_description):
        raise PermissionError("the folder of the kernels")

    monkeypatch.setattr(worker, "Robot", fail)
    monkeypatch.setattr(worker, "_exit_with_node", lambda _lifeline: None)
    monkeypatch.setattr(worker.signal, "signal", lambda *_: None)
    ours, theirs = Pipe()
    ours.send("a description")
    descriptor = os.dup(theirs.fileno())  # `main` closes its own
    with pytest.raises(PermissionError, match="the folder of the kernels"):
        worker.main([0, descriptor], worker.answer_calls)
    assert not ours.poll()
