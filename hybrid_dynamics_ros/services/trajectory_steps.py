"""Conversions in short pieces, so that an action can tell how far it is and be cancelled.

A piece is a call of a worker as any other: it gets what is done so far, and gives back a little
more. It changes nothing, so that it may be tried again. Knows no rclpy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
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

BUDGET: Final = 0.2  # [s] that a piece takes about


class TrajectoryStep:
    """The next piece of a conversion."""

    @dataclass
    class Request:
        """What to work on.

        Attributes:
            goal: what is asked for: a request of the service or a goal of the action.
            task: what is done so far; None before the first piece.
            joints: names whose `JointMaps` are wanted.
        """

        goal: Any = None
        task: TrajectoryTask | None = None
        joints: Sequence[str] = ()

    @dataclass
    class Response:
        """What is done.

        Attributes:
            error_code, error_text: why nothing more can be done.
            task: to go on with; None where all is done.
            answer: where all is done.
            maps: where all is done.
            stage, progress, reached, nearest: as in the action's feedback.
        """

        error_code: int = 0
        error_text: str = ""
        task: TrajectoryTask | None = None
        answer: ConvertTrajectory.Response | None = None
        maps: JointMaps | None = None
        stage: str = ""
        progress: float = 0.0
        reached: float = 0.0
        nearest: float = 1.0


@dataclass(frozen=True, eq=False)
class JointMaps:
    """How much rates of joints are at most, for unit rates of active joints.

    Attributes:
        joints: k names.
        active: n names.
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
    """Work on a conversion for a while."""
    task = request.task or TrajectoryTask(context, request.goal)
    task.advance(context, BUDGET)
    stage = task.stage
    response.stage = "path" if isinstance(stage, PathSearch) else "motion"
    response.progress, response.reached = stage.progress, stage.reached
    response.nearest = task.nearest
    if not task.is_done:
        response.task = task
        return
    response.answer = ConvertTrajectory.Response()
    task.fill(context.robot, response.answer)
    response.maps = _maps(context.robot, task, request.joints)


def _maps(robot: Robot, task: TrajectoryTask, joints: Sequence[str]) -> JointMaps | None:
    """How the joints move with the active ones along what was converted."""
    names = tuple(name for name in joints if name in robot.coordinates)
    if task.velocity_maps is None or not names:
        return None
    places = [robot.coordinates.index(name) for name in names]
    on_the_way, at_the_end = task.velocity_maps
    return JointMaps(names, robot.active, on_the_way[places], at_the_end[places])


class PointsOfJoints:
    """Points of the active joints as points of other joints."""

    @dataclass
    class Request:
        """What to convert.

        Attributes:
            names: of the joints of the points.
            points: with positions, and velocities or accelerations where there are any.
            joints: whose points are wanted.
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
    result = JointTrajectoryPoint(
        positions=conversions.to_field(state.s[places]), time_from_start=point.time_from_start
    )
    if motion.velocity is not None:
        result.velocities = conversions.to_field(state.ds[places])
        if motion.acceleration is not None:
            all_of_them = robot.accelerations(state, motion.acceleration)
            result.accelerations = conversions.to_field(all_of_them[places])
    return result
