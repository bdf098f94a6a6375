"""Conversion of trajectories of independent joints, or of the end effector, to active joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from time import monotonic

import numpy as np
from builtin_interfaces.msg import Duration
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
    RejectionCode,
    resting_besides,
)
from ..parameters import EFFORT_TOLERANCE, LEAST_SINGULARITY, RETIME
from .answers import code_of
from .context import ServiceContext
from .kinematics import target_of
from .trajectory_conversion import Conversion, ConvertedTrajectory
from .trajectory_follower import ConversionSettings
from .trajectory_motion import PathSearch, SampledTrajectory, require_times, retimed


def convert_trajectory(
    context: ServiceContext,
    request: ConvertTrajectory.Request,
    response: ConvertTrajectory.Response,
) -> None:
    """Convert a path or a trajectory to a checked trajectory of the active joints."""
    task = TrajectoryTask(context, request)
    task.advance(context)
    task.fill(context.robot, response)


class TrajectoryTask:
    """The conversion of one request in pieces; it can be pickled between pieces."""

    def __init__(self, context: ServiceContext, request: ConvertTrajectory.Request) -> None:
        """Parse the request.

        Args:
            context: the robot and how it stands.
            request: request of the service, or goal of the action.

        Raises:
            RejectedError: the request is wrong.
        """
        if bool(request.path) == bool(request.joints.points):
            text = "expected either points of joints or a path, and not both"
            raise RejectedError(RejectionCode.BAD_REQUEST, text)
        # Conditions are constant during a conversion.
        self._situation = context.situation
        self._start = _start(context, request)
        self._search: PathSearch | None = None
        self._conversion: Conversion | None = None
        if request.path:
            self._search = _search(context, request, self._start.u)
            self._header = Header(stamp=request.path[0].header.stamp)
            return
        trajectory = motion_of_joints(context.robot, request.joints)
        self._header = Header(stamp=request.joints.header.stamp)
        self._conversion = self._conversion_of(context, trajectory)

    @property
    def is_done(self) -> bool:
        """Whether the conversion is complete."""
        if self._conversion is not None:
            return self._conversion.is_done
        return self._search is not None and self._search.problem is not None

    @property
    def stage(self) -> Conversion | PathSearch:
        """The present stage: the search along a path, then the conversion of the motion."""
        stage = self._conversion or self._search
        if stage is None:
            raise AssertionError("a task has one of them from the start")
        return stage

    @property
    def nearest(self) -> float:
        """Smallest distance to a singularity so far; 1 before anything is converted."""
        return 1.0 if self._conversion is None else self._conversion.nearest

    @property
    def velocity_maps(self) -> tuple[FloatArray, FloatArray] | None:
        """Largest absolute entries of R (n_s, n) along the motion, and those at its end."""
        return None if self._conversion is None else self._conversion.velocity_maps

    def advance(self, context: ServiceContext, budget: float = math.inf) -> None:
        """Continue the conversion, for about `budget` [s] if given."""
        end = monotonic() + budget
        context = ServiceContext(context.robot, self._situation)
        if self._conversion is None and self._search is not None:
            self._search.advance(context.robot, budget)
            if not self._search.is_done:
                return
            self._begin_conversion(context, self._search)
        if self._conversion is not None:
            values = context.situation.settings
            settings = ConversionSettings(
                context.loads, values[LEAST_SINGULARITY], values[EFFORT_TOLERANCE]
            )
            self._conversion.advance(context.robot, settings, end - monotonic())

    def _begin_conversion(self, context: ServiceContext, search: PathSearch) -> None:
        trajectory = search.trajectory(context.robot)
        if search.problem is not None and trajectory.time.size < 2:
            return
        self._conversion = self._conversion_of(context, trajectory)

    def _conversion_of(self, context: ServiceContext, trajectory: SampledTrajectory) -> Conversion:
        near: ClosedState | None = self._start
        # A motion of the active joints starts at its first point, on the robot's modes.
        if trajectory.names == context.robot.active and context.start is None:
            near = None
        share = context.situation.settings[RETIME]
        if share > 0.0:
            trajectory = retimed(context.robot, trajectory, context.loads, near, share)
        return Conversion(trajectory.motion(), near)

    def fill(self, robot: Robot, response: ConvertTrajectory.Response) -> None:
        """Write the result to a response, or to the result of the action."""
        response.first_bad = -1
        response.first_bad_time = response.nearest_singularity = math.nan
        problem = None
        if self._conversion is not None:
            converted = self._conversion.result()
            response.trajectory = _message(robot.active, converted, self._header)
            response.nearest_singularity = converted.nearest
            problem, response.first_bad = converted.problem, converted.bad_point
            response.first_bad_time = converted.bad_time
        if problem is None and self._search is not None and self._search.problem is not None:
            problem, response.first_bad = self._search.problem, self._search.count
            response.first_bad_time = self._search.next_time
        if problem is not None:
            response.error_code, response.error_text = code_of(problem), problem.text


def motion_of_joints(robot: Robot, message: JointTrajectory) -> SampledTrajectory:
    """A JointTrajectory as a motion.

    All points must have positions, and each may have velocities and accelerations. Idle joints may
    be missing.

    Args:
        robot: the robot.
        message: the trajectory.

    Raises:
        RejectedError: lengths differ, or a number is not finite.
    """
    if len(set(message.joint_names)) != len(message.joint_names):
        raise RejectedError(RejectionCode.DUPLICATE_JOINT, "a joint is named twice")
    resting = resting_besides(robot, message.joint_names)
    names = (*message.joint_names, *resting)
    order = JointOrder(names, resting)
    shape = len(message.points), len(names)
    position = np.zeros(shape)
    velocity, acceleration = np.full(shape, np.nan), np.full(shape, np.nan)
    for number, point in enumerate(message.points):
        try:
            motion = order.arrange(_sample(message.joint_names, point))
        except RejectedError as error:
            text = f"point {number}: {error.rejection.text}"
            raise RejectedError(error.rejection.code, text) from error
        position[number] = motion.position
        if motion.velocity is not None:
            velocity[number] = motion.velocity
        if motion.acceleration is not None:
            acceleration[number] = motion.acceleration
    time = np.array([conversions.seconds(point.time_from_start) for point in message.points])
    return SampledTrajectory(names, time, position, velocity, acceleration)


def _sample(names: Sequence[str], point: JointTrajectoryPoint) -> JointSample:
    return JointSample(
        0,
        names,
        conversions.from_field(point.positions),
        conversions.from_field(point.velocities) if len(point.velocities) else None,
        conversions.from_field(point.accelerations) if len(point.accelerations) else None,
    )


def _search(
    context: ServiceContext, request: ConvertTrajectory.Request, start: FloatArray
) -> PathSearch:
    path, position_only = request.path, request.position_only
    stamps = np.array([conversions.stamp_to_ns(pose.header.stamp) for pose in path])
    time = (stamps - stamps[0]) * 1e-9
    require_times(time)
    targets = [target_of(context, pose, position_only=position_only) for pose in path]
    return PathSearch(time, targets, start, context.start)


def _start(context: ServiceContext, request: ConvertTrajectory.Request) -> ClosedState:
    if request.start.name:
        return context.close(context.active_motion(request.start).position)
    newest = context.situation.newest
    return context.close(context.reference if newest is None else newest)


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
