"""What the services answer: functions of the robot and a request, without a node.

Each fills a response whose error_code is OK, or raises; :func:`guarded` turns what was raised into an answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import InverseDynamics, SolveFK, SolveIK
from std_msgs.msg import Header

from hybrid_dynamics_core import IKStatus, Pose, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_ros import conversions
from hybrid_dynamics_ros.samples import (
    FloatArray,
    JointOrder,
    RejectedError,
    Rejection,
    RejectionCode,
    rejection_of,
)

OK: Final[int] = ErrorCode.OK

_REJECTIONS: Final = {
    RejectionCode.UNREACHABLE: ErrorCode.OUT_OF_REACH,
    RejectionCode.SINGULAR: ErrorCode.SINGULAR,
    RejectionCode.INTERNAL: ErrorCode.INTERNAL,
}  # all others: BAD_INPUT

_IK_CODES: Final = {
    IKStatus.OUT_OF_REACH: ErrorCode.OUT_OF_REACH,
    IKStatus.LIMIT: ErrorCode.LIMIT,
    IKStatus.SINGULAR: ErrorCode.SINGULAR,
    IKStatus.NOT_CONVERGED: ErrorCode.NOT_CONVERGED,
}


def guarded(answer: Callable[[Robot, Any, Any], None], robot: Robot, request: Any, response: Any) -> Any:
    """The answer to a request, an error code and text included, whatever happens.

    Args:
        answer: one of the functions below.
        robot: the robot.
        request: request message.
        response: empty response message, to be filled.

    Returns:
        The response; where something went wrong an empty one with ``error_code`` and ``error_text``.
    """
    try:
        # Numbers near the end of the range overflow somewhere in the model; the answer is checked instead.
        with np.errstate(all="ignore"):
            answer(robot, request, response)
    except RejectedError as error:
        return _refused(type(response)(), error.rejection)
    except HybridDynamicsError as error:
        return _refused(type(response)(), rejection_of(error))
    except Exception as error:  # noqa: BLE001 - a client waits for an answer, and the node must go on
        return _refused(type(response)(), Rejection(RejectionCode.INTERNAL, f"fault of the node: {error!r}"))
    return response


def solve_fk(robot: Robot, request: SolveFK.Request, response: SolveFK.Response) -> None:
    """Close the loops for given active coordinates; poses of the frames asked for."""
    given = request.active_joints
    motion = JointOrder(robot.active).arrange(conversions.sample_of_state(given))
    state = robot.close(motion.position, motion.velocity)
    frames = list(request.frames) or [robot.end_effector]
    poses = [robot.forward_kinematics(state, frame) for frame in frames]
    velocity = None if motion.velocity is None else state.ds
    _require_finite(state.s, velocity, *(pose.position for pose in poses))

    stamp = given.header.stamp
    header = Header(stamp=stamp, frame_id=robot.base_frame)
    response.joint_state = conversions.joint_state(header, robot.coordinates, state.s, velocity)
    response.poses = [conversions.pose_stamped(header, pose.position, pose.quaternion) for pose in poses]
    response.residual = float(np.max(state.residual))


def inverse_dynamics(robot: Robot, request: InverseDynamics.Request, response: InverseDynamics.Response) -> None:
    """Efforts of the active joints for a motion with accelerations."""
    given = request.motion
    sample = conversions.sample_of_motion(given)
    position, velocity, acceleration = JointOrder(robot.active).arrange(sample).complete()
    state = robot.close(position, velocity)
    efforts = robot.inverse_dynamics(state, acceleration)
    _require_finite(state.s, state.ds, efforts)

    header = Header(stamp=given.header.stamp)
    response.efforts = conversions.joint_state(header, robot.active, position, velocity, efforts)
    response.joint_state = conversions.joint_state(header, robot.coordinates, state.s, state.ds)


def solve_ik(robot: Robot, request: SolveIK.Request, response: SolveIK.Response) -> None:
    """Active coordinates that bring the end effector to a target."""
    target = _target(robot, request.target, position_only=request.position_only)
    seed = None
    if request.seed.name or request.seed.position:
        seed = JointOrder(robot.active).arrange(conversions.sample_of_state(request.seed)).position
    result = robot.inverse_kinematics(target, seed=seed, all_solutions=request.all_solutions)

    state = result.state
    if result.status is not IKStatus.SOLVED or state is None:
        response.error_code = _IK_CODES.get(result.status, ErrorCode.INTERNAL)
        response.error_text = " ".join(result.message.split())
        response.residual = math.nan
        return
    _require_finite(state.s)
    header = Header(stamp=request.target.header.stamp, frame_id=robot.base_frame)
    response.solution = conversions.joint_state(header, robot.coordinates, state.s)
    response.solutions = [conversions.joint_state(header, robot.active, u) for u in result.solutions]
    response.residual = float(result.residual)
    response.loops = list(result.branch)
    response.branches = [str(mode) for mode in result.branch.values()]
    response.redundant = list(result.redundant)


def _target(robot: Robot, target: PoseStamped, *, position_only: bool) -> FloatArray | Pose:
    frame = target.header.frame_id
    if frame not in ("", robot.base_frame):
        raise RejectedError(
            RejectionCode.MISSING_JOINT,
            f"target is in frame '{frame}', expected '{robot.base_frame}' or none",
        )
    position, quaternion = conversions.pose_arrays(target.pose)
    return position if position_only else Pose.from_quaternion(position, quaternion)


def _refused(response: Any, rejection: Rejection) -> Any:
    response.error_code = _REJECTIONS.get(rejection.code, ErrorCode.BAD_INPUT)
    response.error_text = rejection.text
    if hasattr(response, "residual"):
        response.residual = math.nan
    return response


def _require_finite(*arrays: FloatArray | None) -> None:
    if not all(values is None or np.isfinite(values).all() for values in arrays):
        raise RejectedError(RejectionCode.OVERFLOW, "the input is too large: the answer would not be finite")
