"""Forward and inverse kinematics, Jacobian, closure from any given joints."""

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

from ..messages import conversions
from ..messages.joint_samples import FloatArray, JointOrder, RejectedError, RejectionCode
from ..stream.situation import Context, require_finite
from ..stream.stroke_margins import Strokes

IK_CODES: Final = {
    IKStatus.OUT_OF_REACH: ErrorCode.OUT_OF_REACH,
    IKStatus.LIMIT: ErrorCode.LIMIT,
    IKStatus.SINGULAR: ErrorCode.SINGULAR,
    IKStatus.NOT_CONVERGED: ErrorCode.NOT_CONVERGED,
}


def solve_fk(context: Context, request: SolveFK.Request, response: SolveFK.Response) -> None:
    """Close the loops for given active coordinates; poses of the frames asked for."""
    robot, given = context.robot, request.active_joints
    motion = JointOrder(robot.active).arrange(conversions.sample_of_state(given))
    state = context.close(motion.position, motion.velocity)
    frames = list(request.frames) or [robot.end_effector]
    require_frames(robot, *frames)
    poses = [robot.forward_kinematics(state, frame) for frame in frames]
    velocity = None if motion.velocity is None else state.ds
    require_finite(state.s, velocity, *(pose.position for pose in poses))

    header = Header(stamp=given.header.stamp, frame_id=robot.base_frame)
    response.joint_state = conversions.joint_state(header, robot.coordinates, state.s, velocity)
    response.poses = [
        conversions.pose_stamped(header, pose.position, pose.rotation) for pose in poses
    ]
    response.residual = float(np.max(state.residual))


def solve_ik(context: Context, request: SolveIK.Request, response: SolveIK.Response) -> None:
    """Active coordinates that bring the end effector to a target; the nearest ones beside an error of the search."""
    robot = context.robot
    mask = list(request.mask) or None
    position_only = request.position_only or (mask is not None and not any(mask[3:]))
    target = target_of(robot, request.target, position_only=position_only)
    seed = None
    if request.seed.name or request.seed.position:
        seed = JointOrder(robot.active).arrange(conversions.sample_of_state(request.seed)).position
    result = robot.inverse_kinematics(
        target, seed, request.all_solutions, mask, context.situation.conditions.mode
    )

    state = result.state
    header = Header(stamp=request.target.header.stamp, frame_id=robot.base_frame)
    if state is not None and np.isfinite(state.s).all():
        response.solution = conversions.joint_state(header, robot.coordinates, state.s)
        response.loops = list(result.branch)
        response.branches = [str(mode) for mode in result.branch.values()]
    if result.status is not IKStatus.SOLVED or state is None:
        response.error_code = IK_CODES.get(result.status, ErrorCode.SINGULAR)
        response.error_text = " ".join(result.message.split())
        response.residual = float(result.residual) if math.isfinite(result.residual) else math.nan
        return
    require_finite(state.s)
    response.solutions = [
        conversions.joint_state(header, robot.active, u) for u in result.solutions
    ]
    response.residual = float(result.residual)
    response.redundant = list(result.redundant)


def compute_jacobian(
    context: Context, request: ComputeJacobian.Request, response: ComputeJacobian.Response
) -> None:
    """Jacobian of a frame with respect to the active joints."""
    robot = context.robot
    require_frames(robot, request.frame or robot.end_effector)
    motion = JointOrder(robot.active).arrange(conversions.sample_of_state(request.active_joints))
    jacobian = robot.jacobian(
        context.close(motion.position, motion.velocity), request.frame or None
    )
    require_finite(jacobian)
    response.joints = list(robot.active)
    response.jacobian = conversions.to_field(jacobian.ravel())


def close_loops(
    context: Context, request: CloseLoops.Request, response: CloseLoops.Response
) -> None:
    """Full state from any independent set of joints."""
    robot, given = context.robot, request.given
    unknown = [name for name in given.name if name not in robot.coordinates]
    if unknown:
        raise RejectedError(
            RejectionCode.BAD_REQUEST,
            f"there is no joint '{unknown[0]}'; known: {', '.join(robot.coordinates)}",
        )
    sample = conversions.sample_of_motion(given, complete=False)
    motion = JointOrder(given.name).arrange(sample)
    near = context.situation.conditions.mode
    if request.near.name:
        near = context.close(
            JointOrder(robot.active).arrange(conversions.sample_of_state(request.near)).position
        )
    rows = (
        None if part is None else dict(zip(given.name, part.tolist(), strict=True))
        for part in (motion.position, motion.velocity, motion.acceleration)
    )
    values, rates, accelerations = rows
    try:
        state = robot.close_given(values or {}, rates, accelerations, near=near)
    except InputError as error:
        raise RejectedError(RejectionCode.BAD_REQUEST, one_line(error)) from error
    dds = state.dds if state.dds is not None else np.full_like(state.s, np.nan)
    require_finite(state.s, state.ds, dds)
    header = Header(stamp=given.header.stamp)
    response.motion = conversions.joint_motion(header, robot.coordinates, state.s, state.ds, dds)
    response.closed_state = closed_state_message(robot, state, given.header.stamp)


def closed_state_message(robot: Robot, state: ClosedState, stamp: Time) -> ClosedStateMessage:
    """What the topic `ClosedStates` sends, as an object."""
    strokes = Strokes(robot)
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


def target_of(robot: Robot, target: PoseStamped, *, position_only: bool) -> FloatArray | Pose:
    """A target in the base frame, as the robot takes it.

    Raises:
        RejectedError: it is in another frame.
    """
    frame = target.header.frame_id
    if frame not in ("", robot.base_frame):
        text = f"target is in frame '{frame}', expected '{robot.base_frame}' or none"
        raise RejectedError(RejectionCode.BAD_REQUEST, text)
    position, quaternion = conversions.pose_arrays(target.pose)
    return position if position_only else Pose.from_quaternion(position, quaternion)


def require_frames(robot: Robot, *frames: str) -> None:
    """Refuse frames that the robot has not.

    Raises:
        RejectedError: it has not this one.
    """
    for frame in frames:
        if frame not in robot.frames:
            raise RejectedError(
                RejectionCode.BAD_REQUEST, no_such_name("frame", frame, robot.frames)
            )
