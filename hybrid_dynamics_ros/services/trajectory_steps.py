"""Conversions in short pieces, so that an action can give feedback and be cancelled.

A piece is an ordinary call of a worker: it receives the partial result, and returns an extended
one. It has no side effects, so that it may be repeated. This module does not depend on rclpy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from multiprocessing.reduction import ForkingPickler
from typing import Any, Final

import numpy as np
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from trajectory_msgs.msg import JointTrajectoryPoint

from hybrid_dynamics_core import Robot

from ..messages import conversions
from ..messages.joint_samples import FloatArray, JointSample, active_order
from .context import ServiceContext
from .trajectory import TrajectoryTask
from .trajectory_motion import PathSearch

BUDGET: Final = 0.2  # [s] approximate time of a piece


class TrajectoryStep:
    """The next piece of a conversion."""

    @dataclass
    class Request:
        """The request of a piece.

        Attributes:
            goal: request of the service, or goal of the action.
            task: the partial result as bytes; None before the first piece.
            joints: names of joints for `JointMaps`.
        """

        goal: Any = None
        task: bytes | None = None
        joints: Sequence[str] = ()

    @dataclass
    class Response:
        """The response of a piece.

        Attributes:
            error_code, error_text: why the conversion failed.
            task: the partial result as bytes, which the node does not read; None if complete.
            answer: the result, if complete.
            maps: the joint maps, if complete.
            stage, progress, reached, nearest: as in the action's feedback.
        """

        error_code: int = 0
        error_text: str = ""
        task: bytes | None = None
        answer: ConvertTrajectory.Response | None = None
        maps: JointMaps | None = None
        stage: str = ""
        progress: float = 0.0
        reached: float = 0.0
        nearest: float = 1.0


@dataclass(frozen=True, eq=False)
class JointMaps:
    """Largest rates of joints per unit rate of active joints.

    Attributes:
        joints: names of k joints.
        active: names of n active joints.
        on_the_way: (k, n) largest absolute entries along the motion.
        at_the_end: (k, n) absolute entries at its end.
    """

    joints: tuple[str, ...]
    active: tuple[str, ...]
    on_the_way: FloatArray
    at_the_end: FloatArray


def trajectory_step(
    context: ServiceContext, request: TrajectoryStep.Request, response: TrajectoryStep.Response
) -> None:
    """Do one piece of a conversion."""
    task = _task_of(context, request)
    task.advance(context, BUDGET)
    stage = task.stage
    response.stage = "path" if isinstance(stage, PathSearch) else "motion"
    response.progress, response.reached = stage.progress, stage.reached
    response.nearest = task.nearest
    if not task.is_done:
        # In one piece: the node would hold the GIL to make thousands of arrays.
        response.task = bytes(ForkingPickler.dumps(task))
        return
    response.answer = ConvertTrajectory.Response()
    task.fill(context.robot, response.answer)
    response.maps = _maps(context.robot, task, request.joints)


def _task_of(context: ServiceContext, request: TrajectoryStep.Request) -> TrajectoryTask:
    """The task of a piece: a new one, or the one that an earlier piece sent."""
    if request.task is None:
        return TrajectoryTask(context, request.goal)
    task: TrajectoryTask = ForkingPickler.loads(request.task)
    return task


def _maps(robot: Robot, task: TrajectoryTask, joints: Sequence[str]) -> JointMaps | None:
    """The joint maps along the converted motion, or None."""
    names = tuple(name for name in joints if name in robot.coordinates)
    if task.velocity_maps is None or not names:
        return None
    places = [robot.coordinates.index(name) for name in names]
    on_the_way, at_the_end = task.velocity_maps
    return JointMaps(names, robot.active, on_the_way[places], at_the_end[places])


class PointsOfJoints:
    """Conversion of points of the active joints to points of other joints."""

    @dataclass
    class Request:
        """The request.

        Attributes:
            names: names of the points' joints.
            points: points with positions, and optional velocities or accelerations.
            joints: names of the requested joints.
        """

        names: Sequence[str] = ()
        points: Sequence[JointTrajectoryPoint] = ()
        joints: Sequence[str] = ()

    @dataclass
    class Response:
        """The points, in the order of the request."""

        error_code: int = 0
        error_text: str = ""
        points: list[JointTrajectoryPoint] = field(default_factory=list)


def points_of_joints(
    context: ServiceContext, request: PointsOfJoints.Request, response: PointsOfJoints.Response
) -> None:
    """Close the loops at each point."""
    for point in request.points:
        response.points.append(_point_of(context, request.names, point, request.joints))


def _point_of(
    context: ServiceContext,
    names: Sequence[str],
    point: JointTrajectoryPoint,
    joints: Sequence[str],
) -> JointTrajectoryPoint:
    robot = context.robot
    velocity = accelerations = None
    if len(point.velocities):
        velocity = conversions.from_field(point.velocities)
    if len(point.accelerations):
        accelerations = conversions.from_field(point.accelerations)
    sample = JointSample(0, names, conversions.from_field(point.positions), velocity, accelerations)
    motion = active_order(robot).arrange(sample)
    state = context.close(motion.position, motion.velocity)
    places = np.array([robot.coordinates.index(name) for name in joints], dtype=np.intp)
    dds = None
    if motion.velocity is not None and motion.acceleration is not None:
        dds = robot.accelerations(state, motion.acceleration)
    s, ds, dds = context.motion_of(state, dds)
    result = JointTrajectoryPoint(
        positions=conversions.to_field(s[places]), time_from_start=point.time_from_start
    )
    if motion.velocity is not None:
        result.velocities = conversions.to_field(ds[places])
    if dds is not None:
        result.accelerations = conversions.to_field(dds[places])
    return result
