"""Trajectories of any independent joints, or of the end effector, as ones of the active joints.

Every point is followed from the one before it, so that no loop changes its assembly mode unnoticed.
It is checked against limits and singularities. Knows no ROS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core import ClosedState, IKStatus, Loads, Pose, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.units import coordinate_unit

from ..messages.joint_samples import (
    FloatArray,
    OrderedMotion,
    RejectedError,
    Rejection,
    RejectionCode,
    rejection_of,
)
from ..stream.stroke_margins import StrokeMargins

_ROUNDING: Final = 1e-9  # [rad or m] that a limit may be passed by
_UNSOLVED: Final = {IKStatus.LIMIT: RejectionCode.LIMIT, IKStatus.SINGULAR: RejectionCode.SINGULAR}


@dataclass(frozen=True, eq=False)
class SampledTrajectory:
    """Named coordinates over time.

    Attributes:
        names: of n coordinates.
        time: (N,) [s].
        position: (N, n) [rad or m].
        velocity: (N, n) [rad/s or m/s], or None.
        acceleration: (N, n) [rad/s^2 or m/s^2], or None.
    """

    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None
    acceleration: FloatArray | None = None

    def complete(self) -> SampledTrajectory:
        """With rates and accelerations from splines where they are missing; at rest at both ends.

        Raises:
            RejectedError: times do not increase, or there are too few points.
        """
        if self.time.size < 2:
            raise RejectedError(
                RejectionCode.BAD_REQUEST, f"{self.time.size} points, expected 2 or more"
            )
        late = np.flatnonzero(np.diff(self.time) <= 0.0)
        if late.size:
            before = late[0]
            times = f"{self.time[before + 1]:g} s, expected later than {self.time[before]:g} s"
            raise RejectedError(RejectionCode.BAD_REQUEST, f"point {before + 1} is at {times}")
        velocity, acceleration = self.velocity, self.acceleration
        if velocity is None:
            spline = _splines().CubicSpline(self.time, self.position, bc_type="clamped")
            velocity, acceleration = spline(self.time, 1), spline(self.time, 2)
        elif acceleration is None:
            acceleration = _hermite_accelerations(self.time, self.position, velocity)
        return SampledTrajectory(self.names, self.time, self.position, velocity, acceleration)


@dataclass(frozen=True, eq=False)
class ConvertedTrajectory:
    """Points of the active joints, (k, n) each, as far as they are good.

    Attributes:
        time: (k,) [s].
        position, velocity, acceleration: [rad or m, per s, per s^2].
        efforts: [N m or N].
        nearest: smallest distance to a singularity on the way.
        problem: what is wrong with point k, or None where all are good.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    efforts: FloatArray
    nearest: float
    problem: Rejection | None


def convert(
    robot: Robot,
    motion: SampledTrajectory,
    near: ClosedState | None = None,
    loads: Loads | None = None,
    least: float = 0.0,
) -> ConvertedTrajectory:
    """The motion as one of the active joints, checked point by point; the first bad point ends it.

    Args:
        robot: the robot.
        motion: of any independent set of coordinates.
        near: where it comes from; its assembly modes are kept. None: the reference configuration.
        loads: what acts on the robot; None: what its file says.
        least: a point nearer to a singularity than this is bad, 0 singular, 1 best.

    Raises:
        RejectedError: the motion says nothing that can be used.
        InputError: the coordinates are not independent.
    """
    motion = motion.complete()
    if motion.velocity is None or motion.acceleration is None:
        raise AssertionError("a complete motion has rates and accelerations")
    strokes = StrokeMargins(robot)
    rows: list[list[FloatArray]] = []
    nearest = 1.0
    problem: Rejection | None = None
    for point in zip(motion.position, motion.velocity, motion.acceleration, strict=True):
        try:
            near, ddu = _close(robot, motion.names, point, near)
            _require_good(robot, near, strokes, least)
            rows.append([near.u, near.du, ddu, robot.inverse_dynamics(near, ddu, loads)])
        except RejectedError as error:
            problem = _of_point(len(rows), motion, error.rejection)
            break
        except HybridDynamicsError as error:
            problem = _of_point(len(rows), motion, rejection_of(error))
            break
        nearest = min(nearest, float(near.singularity))
    points = np.array(rows).reshape(len(rows), 4, len(robot.active))
    position, velocity, acceleration, efforts = points.swapaxes(0, 1)
    time = motion.time[: len(rows)]
    return ConvertedTrajectory(time, position, velocity, acceleration, efforts, nearest, problem)


def path_motion(
    robot: Robot,
    time: FloatArray,
    poses: Sequence[Pose | FloatArray],
    start: FloatArray,
    near: ClosedState | None = None,
) -> tuple[SampledTrajectory, Rejection | None]:
    """The motion of the active joints along poses of the end effector.

    Each pose is solved from the one before.

    Args:
        robot: the robot.
        time: (N,) [s].
        poses: N poses, or positions (3,) [m], in the base frame.
        start: active joints where the search begins (n,).
        near: a closed state whose assembly modes are kept; the robot's own if None.

    Returns:
        The motion as far as poses are reached, and what is wrong with the first one that is not.
    """
    u = start
    rows: list[FloatArray] = []
    for number, pose in enumerate(poses):
        result = robot.inverse_kinematics(pose, seed=u, near=near)
        if result.status is not IKStatus.SOLVED:
            code = _UNSOLVED.get(result.status, RejectionCode.UNREACHABLE)
            text = f"point {number} at {time[number]:g} s: {' '.join(result.message.split())}"
            reached = SampledTrajectory(robot.active, time[:number], np.array(rows))
            return reached, Rejection(code, text)
        u = result.u
        rows.append(u)
    return SampledTrajectory(robot.active, time, np.array(rows)), None


def _close(
    robot: Robot, names: tuple[str, ...], point: Sequence[FloatArray], near: ClosedState | None
) -> tuple[ClosedState, FloatArray]:
    position, velocity, acceleration = point
    if names == robot.active:
        return robot.close(position, velocity, near=near), acceleration
    values, rates, accelerations = OrderedMotion(*point).by_name(names)
    state = robot.close_given(values, rates, accelerations, near=near)
    dds = np.full_like(state.s, np.nan) if state.dds is None else state.dds
    return state, dds[: state.n]


def _require_good(robot: Robot, state: ClosedState, strokes: StrokeMargins, least: float) -> None:
    for k, name in enumerate(robot.coordinates):
        low, value, high = float(strokes.lower[k]), float(state.s[k]), float(strokes.upper[k])
        if not low - _ROUNDING <= value <= high + _ROUNDING:
            kind = coordinate_unit(robot.joint_types[name])
            text = f"{name} is {value:.6g} {kind}, expected {low:.6g} to {high:.6g} {kind}"
            raise RejectedError(RejectionCode.LIMIT, text)
    if float(state.singularity) < least:
        place = f"at a distance of {state.singularity:.3g} (of at most 1) from a singularity"
        text = f"loop {state.singular_loop} is {place}, expected {least:g} or more"
        raise RejectedError(RejectionCode.SINGULAR, text)


def _of_point(number: int, motion: SampledTrajectory, rejection: Rejection) -> Rejection:
    text = f"point {number} at {motion.time[number]:g} s: {rejection.text}"
    return Rejection(rejection.code, text)


def _hermite_accelerations(
    time: FloatArray, position: FloatArray, velocity: FloatArray
) -> FloatArray:
    """Accelerations of the cubic Hermite spline, the mean of both sides where pieces meet."""
    spline = _splines().CubicHermiteSpline(time, position, velocity)
    before, after = spline(np.nextafter(time, -np.inf), 2), spline(time, 2)
    before[0], after[-1] = after[0], before[-1]
    accelerations: FloatArray = 0.5 * (before + after)
    return accelerations


def _splines() -> Any:
    from scipy import interpolate  # noqa: PLC0415  slow to import, and only this needs it

    return interpolate
