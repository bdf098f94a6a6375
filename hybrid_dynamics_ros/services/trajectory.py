"""Trajectories in, of any independent joints or of the end effector; of the active joints out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core import ClosedState, Robot

from ..messages import conversions
from ..messages.cdr import NS
from ..messages.joint_samples import (
    FloatArray,
    JointOrder,
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
    resting_besides,
)
from ..parameters import LEAST_SINGULARITY
from .answers import code_of
from .context import ServiceContext
from .kinematics import target_of
from .trajectory_motion import ConvertedTrajectory, SampledTrajectory, convert, path_motion


def convert_trajectory(
    context: ServiceContext,
    request: ConvertTrajectory.Request,
    response: ConvertTrajectory.Response,
) -> None:
    """A path or a trajectory as one of the active joints, checked."""
    if bool(request.path) == bool(request.joints.points):
        raise RejectedError(
            RejectionCode.BAD_REQUEST, "expected either points of joints or a path, and not both"
        )
    start = _start(context, request)
    problem: Rejection | None = None
    if request.path:
        motion, problem = _motion_of_path(
            context, request.path, start.u, position_only=request.position_only
        )
        header = Header(stamp=request.path[0].header.stamp)
    else:
        motion = motion_of_joints(context.robot, request.joints)
        header = Header(stamp=request.joints.header.stamp)
    count = motion.time.size
    if count > 1:
        converted = _convert(context, motion, start)
        problem = converted.problem or problem
        count = len(converted.time)
        response.trajectory = _message(context.robot.active, converted, header)
        response.nearest_singularity = converted.nearest
    elif problem is None:
        motion.complete()  # says what is wrong with so few points
    response.first_bad = -1
    if problem is not None:
        response.error_code, response.error_text = code_of(problem), problem.text
        response.first_bad = count


def _convert(
    context: ServiceContext, motion: SampledTrajectory, start: ClosedState
) -> ConvertedTrajectory:
    near: ClosedState | None = start
    # A path begins where inverse kinematics says, on the modes that it keeps.
    if motion.names == context.robot.active and context.mode is None:
        near = None
    least = context.situation.settings[LEAST_SINGULARITY]
    return convert(context.robot, motion, near, context.loads, least)


def motion_of_joints(robot: Robot, message: JointTrajectory) -> SampledTrajectory:
    """A JointTrajectory as a motion.

    All points have positions, and all or none of them velocities and accelerations. Idle joints
    need not be named.

    Args:
        robot: that moves.
        message: the trajectory.

    Raises:
        RejectedError: lengths differ, or a number is not finite.
    """
    if len(set(message.joint_names)) != len(message.joint_names):
        raise RejectedError(RejectionCode.DUPLICATE_JOINT, "a joint is named twice")
    first = message.points[0]
    has_velocity, has_acceleration = bool(len(first.velocities)), bool(len(first.accelerations))
    resting = resting_besides(robot, message.joint_names)
    names = (*message.joint_names, *resting)
    order = JointOrder(names, resting)
    motions = []
    for number, point in enumerate(message.points):
        sample = _sample(message.joint_names, point, has_velocity, has_acceleration)
        try:
            motions.append(order.arrange(sample))
        except RejectedError as error:
            text = f"point {number}: {error.rejection.text}"
            raise RejectedError(error.rejection.code, text) from error
    velocity = acceleration = None
    if has_velocity:
        velocity = np.array([motion.velocity for motion in motions])
        if has_acceleration:
            acceleration = np.array([motion.acceleration for motion in motions])
    return SampledTrajectory(
        names,
        np.array([conversions.seconds(point.time_from_start) for point in message.points]),
        np.array([motion.position for motion in motions]),
        velocity,
        acceleration,
    )


def _sample(
    names: Sequence[str], point: JointTrajectoryPoint, has_velocity: bool, has_acceleration: bool
) -> JointSample:
    return JointSample(
        0,
        names,
        conversions.from_field(point.positions),
        conversions.from_field(point.velocities) if has_velocity else None,
        conversions.from_field(point.accelerations) if has_acceleration else None,
    )


def _motion_of_path(
    context: ServiceContext, path: Sequence[PoseStamped], start: FloatArray, *, position_only: bool
) -> tuple[SampledTrajectory, Rejection | None]:
    stamps = np.array([conversions.stamp_to_ns(pose.header.stamp) for pose in path])
    time = (stamps - stamps[0]) * 1e-9
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        text = f"point {late[0] + 1}: its stamp is not later than that of the point before"
        raise RejectedError(RejectionCode.BAD_REQUEST, text)
    targets = [target_of(context.robot, pose, position_only=position_only) for pose in path]
    return path_motion(context.robot, time, targets, start, context.mode)


def _start(context: ServiceContext, request: ConvertTrajectory.Request) -> ClosedState:
    if request.start.name:
        return context.close(context.active_motion(request.start).position)
    newest = context.situation.newest
    return context.close(context.robot.reference if newest is None else newest)


def _message(
    names: Sequence[str], converted: ConvertedTrajectory, header: Header
) -> JointTrajectory:
    message = JointTrajectory(header=header, joint_names=list(names))
    rows = zip(
        converted.time.tolist(),
        converted.position,
        converted.velocity,
        converted.acceleration,
        converted.efforts,
        strict=True,
    )
    for time, position, velocity, acceleration, effort in rows:
        sec, nanosec = divmod(round(time * 1e9), NS)
        message.points.append(
            JointTrajectoryPoint(
                positions=conversions.to_field(position),
                velocities=conversions.to_field(velocity),
                accelerations=conversions.to_field(acceleration),
                effort=conversions.to_field(effort),
                time_from_start=Duration(sec=sec, nanosec=nanosec),
            )
        )
    return message
