"""Services: forward and inverse kinematics, Jacobian, closure from any given joints."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.msg import ClosedState as ClosedStateMessage
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import CloseLoops, ComputeJacobian, SolveFK, SolveIK
from std_msgs.msg import Header

from hybrid_dynamics_core import ClosedState, IKStatus, Pose, Robot
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.suggestions import no_such_name
from hybrid_dynamics_core.ground.wording import one_line
from hybrid_dynamics_core.kinematics.inverse_kinematics import IKResult

from ..messages import conversions
from ..messages.joint_samples import (
    FloatArray,
    JointOrder,
    RejectedError,
    RejectionCode,
    resting_besides,
)
from ..parameters import TF_TARGETS
from ..stream.floating.first_charts import in_first_charts
from ..stream.stroke_margins import StrokeMargins
from .context import ServiceContext, require_finite

IK_CODES: Final = {
    IKStatus.OUT_OF_REACH: ErrorCode.OUT_OF_REACH,
    IKStatus.LIMIT: ErrorCode.LIMIT,
    IKStatus.SINGULAR: ErrorCode.SINGULAR,
    IKStatus.NOT_FOUND: ErrorCode.NOT_CONVERGED,
    IKStatus.NOT_CONVERGED: ErrorCode.NOT_CONVERGED,
}


def solve_fk(context: ServiceContext, request: SolveFK.Request, response: SolveFK.Response) -> None:
    """Poses of frames, and all joints, for given active coordinates."""
    robot, given = context.robot, request.active_joints
    motion = context.active_motion(given)
    state = context.close(motion.position, motion.velocity)
    frames = list(request.frames) or [robot.end_effector]
    require_frames(robot, *frames)
    poses = [robot.forward_kinematics(state, frame) for frame in frames]
    require_finite(*(pose.position for pose in poses))
    s, _ = in_first_charts(robot, state)
    velocity = None
    if motion.velocity is not None:
        velocity = context.motion_of(state).velocity
    require_finite(s)

    header = Header(stamp=given.header.stamp, frame_id=context.frames.base)
    response.joint_state = conversions.joint_state(header, robot.coordinates, s, velocity)
    response.poses = [_pose_message(header, pose) for pose in poses]
    response.residual = float(np.max(state.residual))


def _pose_message(header: Header, pose: Pose) -> PoseStamped:
    return conversions.pose_stamped(header, pose.position, pose.rotation)


def solve_ik(context: ServiceContext, request: SolveIK.Request, response: SolveIK.Response) -> None:
    """Active coordinates that bring the end effector to a target.

    Without a solution, the response has an error and the nearest coordinates.
    """
    robot = context.robot
    header = Header(stamp=request.target.header.stamp, frame_id=context.frames.base)
    result = _solution(context, request)
    state = result.state
    if state is not None and np.isfinite(state.s).all():
        s, _ = in_first_charts(robot, state)
        response.solution = conversions.joint_state(header, robot.coordinates, s)
        response.loops = list(result.branch)
        response.branches = [str(mode) for mode in result.branch.values()]
    if result.status is not IKStatus.SOLVED or state is None:
        response.error_code = IK_CODES.get(result.status, ErrorCode.SINGULAR)
        response.error_text = " ".join(result.message.split())
        response.residual = math.nan
        if math.isfinite(result.residual):
            response.residual = float(result.residual)
        return
    require_finite(state.s)
    solutions = result.solutions
    response.solutions = [conversions.joint_state(header, robot.active, u) for u in solutions]
    response.residual = float(result.residual)
    response.redundant = list(result.redundant)


def _solution(context: ServiceContext, request: SolveIK.Request) -> IKResult:
    robot = context.robot
    mask = list(request.mask) or None
    position_only = request.position_only
    if mask is not None:
        rotations = mask[3:]
        position_only = position_only or not any(rotations)
    target = target_of(context, request.target, position_only=position_only)
    seed = None
    if request.seed.name or request.seed.position:
        seed = context.active_motion(request.seed).position
    return robot.inverse_kinematics(target, seed, request.all_solutions, mask, context.start)


def compute_jacobian(
    context: ServiceContext, request: ComputeJacobian.Request, response: ComputeJacobian.Response
) -> None:
    """Jacobian of a frame with respect to the active joints."""
    robot = context.robot
    require_frames(robot, request.frame or robot.end_effector)
    motion = context.active_motion(request.active_joints)
    state = context.close(motion.position, motion.velocity)
    jacobian = robot.jacobian(state, request.frame or None)
    require_finite(jacobian)
    response.joints = list(robot.active)
    response.jacobian = conversions.to_field(jacobian.ravel())


def close_loops(
    context: ServiceContext, request: CloseLoops.Request, response: CloseLoops.Response
) -> None:
    """The full state from any independent set of joints."""
    robot, given = context.robot, request.given
    unknown = [name for name in given.name if name not in robot.coordinates]
    if unknown:
        text = f"there is no joint '{unknown[0]}'; known: {', '.join(robot.coordinates)}"
        raise RejectedError(RejectionCode.BAD_REQUEST, text)
    if not given.name:
        count = len(robot.active)
        text = f"no joint is named, expected {count} independent of {', '.join(robot.coordinates)}"
        raise RejectedError(RejectionCode.EMPTY, text)
    sample = conversions.sample_of_motion(given, complete=False)
    resting = resting_besides(robot, given.name)
    names = (*given.name, *resting)
    motion = JointOrder(names, resting).arrange(sample)
    near = context.start
    if request.near.name:
        near = context.close(context.active_motion(request.near).position)
    values, rates, accelerations = motion.by_name(names)
    try:
        state = robot.close_given(values, rates, accelerations, near=near)
    except InputError as error:
        raise RejectedError(RejectionCode.BAD_REQUEST, one_line(error)) from error
    dds = np.full_like(state.s, np.nan) if state.dds is None else state.dds
    motion_of_all = context.motion_of(state, dds)
    header = Header(stamp=given.header.stamp)
    response.motion = conversions.joint_motion(header, robot.coordinates, *motion_of_all.complete())
    response.closed_state = closed_state_message(robot, state, given.header.stamp)


def closed_state_message(robot: Robot, state: ClosedState, stamp: Time) -> ClosedStateMessage:
    """A state as a message, with the fields of the topic of closed states."""
    strokes = StrokeMargins(robot)
    lower, upper = strokes.margins(state.s)
    message = ClosedStateMessage(
        residual=float(state.residual),
        loops=list(robot.loops),
        branches=[state.branch.get(loop, "") for loop in robot.loops],
        singularity=conversions.to_field(state.distances),
        nearest_singularity=float(state.singularity),
        nearest_loop=str(state.singular_loop),
        stroke_joints=list(strokes.joints),
        to_lower=conversions.to_field(lower),
        to_upper=conversions.to_field(upper),
    )
    message.header.stamp = stamp
    return message


def target_of(
    context: ServiceContext, target: PoseStamped, *, position_only: bool
) -> FloatArray | Pose:
    """A target in the base frame: a position (3,) [m], or a pose.

    Raises:
        RejectedError: the target is in another frame.
    """
    frame, base = target.header.frame_id, context.frames.base
    if frame not in ("", base):
        text = (
            f"target is in frame '{frame}', expected '{base}' or none; other frames of /tf need the"
            f" parameter {TF_TARGETS.name}"
        )
        raise RejectedError(RejectionCode.BAD_REQUEST, text)
    position, quaternion = conversions.pose_arrays(target.pose)
    return position if position_only else Pose.from_quaternion(position, quaternion)


def require_frames(robot: Robot, *frames: str) -> None:
    """Check that the robot has some frames.

    Raises:
        RejectedError: a frame is unknown.
    """
    for frame in frames:
        if frame not in robot.frames:
            raise RejectedError(
                RejectionCode.BAD_REQUEST, no_such_name("frame", frame, robot.frames)
            )
