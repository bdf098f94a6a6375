"""Trajectories: of any independent joints or of the end effector in, of the active joints with efforts out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core import ClosedState

from ..messages import conversions
from ..messages.joint_samples import (
    FloatArray,
    JointOrder,
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
)
from ..parameters import LEAST_SINGULARITY
from ..stream.situation import Context
from .answers import code_of
from .kinematics import target_of
from .trajectory_motion import Converted, Motion, convert, path_motion


def convert_trajectory(
    context: Context, request: ConvertTrajectory.Request, response: ConvertTrajectory.Response
) -> None:
    """A path or a trajectory as one of the active joints, checked."""
    if bool(request.path) == bool(request.joints.points):
        raise RejectedError(
            RejectionCode.BAD_REQUEST, "expected either points of joints or a path, and not both"
        )
    start = _start(context, request)
    lost: Rejection | None = None
    if request.path:
        motion, lost = _motion_of_path(
            context, request.path, start.u, position_only=request.position_only
        )
        stamp = request.path[0].header.stamp
    else:
        motion, stamp = motion_of_joints(request.joints), request.joints.header.stamp
    # A path begins where inverse kinematics says, on the modes that it keeps.
    near = (
        None
        if motion.names == context.robot.active and context.situation.conditions.mode is None
        else start
    )
    least = context.situation.settings[LEAST_SINGULARITY]
    done = (
        convert(context.robot, motion, near, context.loads, least) if motion.time.size > 1 else None
    )
    problem = (None if done is None else done.problem) or lost
    if done is None and problem is None:
        motion.complete()  # says what is wrong with so few points
    if done is not None:
        response.trajectory = _message(context.robot.active, done, Header(stamp=stamp))
        response.nearest_singularity = done.nearest
    response.first_bad = -1
    if problem is not None:
        response.error_code, response.error_text = code_of(problem), problem.text
        response.first_bad = len(done.time) if done is not None else motion.time.size


def motion_of_joints(message: JointTrajectory) -> Motion:
    """A JointTrajectory as a motion: all points have positions, and all or none of them velocities and accelerations.

    Raises:
        RejectedError: lengths differ, or a number is not finite.
    """
    order = JointOrder(message.joint_names)
    if len(set(message.joint_names)) != len(message.joint_names):
        raise RejectedError(RejectionCode.DUPLICATE_JOINT, "a joint is named twice")
    first = message.points[0]
    has_velocity, has_acceleration = bool(len(first.velocities)), bool(len(first.accelerations))
    rows = []
    for number, point in enumerate(message.points):
        sample = JointSample(
            0,
            message.joint_names,
            conversions.from_field(point.positions),
            conversions.from_field(point.velocities) if has_velocity else None,
            conversions.from_field(point.accelerations) if has_acceleration else None,
        )
        try:
            rows.append(order.arrange(sample))
        except RejectedError as error:
            raise RejectedError(
                error.rejection.code, f"point {number}: {error.rejection.text}"
            ) from error
    time = np.array([conversions.seconds(point.time_from_start) for point in message.points])
    velocity = np.array([row.velocity for row in rows]) if has_velocity else None
    acceleration = (
        np.array([row.acceleration for row in rows]) if has_velocity and has_acceleration else None
    )
    return Motion(
        tuple(message.joint_names),
        time,
        np.array([row.position for row in rows]),
        velocity,
        acceleration,
    )


def _motion_of_path(
    context: Context, path: Sequence[PoseStamped], start: FloatArray, *, position_only: bool
) -> tuple[Motion, Rejection | None]:
    stamps = np.array([conversions.stamp_to_ns(pose.header.stamp) for pose in path])
    time = (stamps - stamps[0]) * 1e-9
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        text = f"point {late[0] + 1}: its stamp is not later than that of the point before"
        raise RejectedError(RejectionCode.BAD_REQUEST, text)
    targets = [target_of(context.robot, pose, position_only=position_only) for pose in path]
    return path_motion(context.robot, time, targets, start, context.situation.conditions.mode)


def _start(context: Context, request: ConvertTrajectory.Request) -> ClosedState:
    robot = context.robot
    if request.start.name:
        return context.close(
            JointOrder(robot.active).arrange(conversions.sample_of_state(request.start)).position
        )
    newest = context.situation.newest
    return context.close(robot.reference if newest is None else newest)


def _message(names: Sequence[str], done: Converted, header: Header) -> JointTrajectory:
    message = JointTrajectory(header=header, joint_names=list(names))
    rows = zip(
        done.time.tolist(),
        done.position,
        done.velocity,
        done.acceleration,
        done.efforts,
        strict=True,
    )
    for time, position, velocity, acceleration, effort in rows:
        nanoseconds = round(time * 1e9)
        message.points.append(
            JointTrajectoryPoint(
                positions=conversions.to_field(position),
                velocities=conversions.to_field(velocity),
                accelerations=conversions.to_field(acceleration),
                effort=conversions.to_field(effort),
                time_from_start=Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9),
            )
        )
    return message
