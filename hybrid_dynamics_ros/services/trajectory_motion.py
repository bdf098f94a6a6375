"""Motions through points of a trajectory, and along a path. It does not depend on ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from time import monotonic
from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, IKStatus, InputError, Loads, Pose, Robot
from hybrid_dynamics_core.retiming.constraints import Constraints
from hybrid_dynamics_core.retiming.curve import curve_of
from hybrid_dynamics_core.retiming.eased import eased

from ..messages.cdr import NS
from ..messages.joint_samples import FloatArray, RejectedError, Rejection, RejectionCode
from .trajectory_fit import completed

_STATIONS: Final = 100  # of a retimed path
_RAMP: Final = 1e-3  # [s] of a retimed path, in place of a jump of its acceleration
_UNSOLVED: Final = {IKStatus.LIMIT: RejectionCode.LIMIT, IKStatus.SINGULAR: RejectionCode.SINGULAR}
# Coefficients of the powers 3, 4 and 5 of a quintic on [0, 1]. They multiply position, velocity and
# acceleration at its end, minus the contributions of the powers 0, 1 and 2.
_QUINTIC: Final = np.array([[10.0, -4.0, 0.5], [-15.0, 7.0, -1.0], [6.0, -3.0, 0.5]])
Point = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class SampledTrajectory:
    """A trajectory of named coordinates.

    Attributes:
        names: names of n coordinates.
        time: (N,) [s].
        position: (N, n) [rad or m].
        velocity: (N, n) [rad/s or m/s], or None; NaN in missing rows.
        acceleration: (N, n) [rad/s^2 or m/s^2], or None; NaN in missing rows.
    """

    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None
    acceleration: FloatArray | None = None

    def motion(self) -> SmoothMotion:
        """The smooth motion through all points.

        Raises:
            RejectedError: a time is negative, times do not increase, or there are too few points.
        """
        require_times(self.time)
        nothing = np.full(self.position.shape, np.nan)
        velocity = nothing if self.velocity is None else self.velocity
        acceleration = nothing if self.acceleration is None else self.acceleration
        rates = completed(self.time, self.position, velocity, acceleration)
        return SmoothMotion(self.names, self.time, self.position, *rates)


def retimed(
    robot: Robot,
    trajectory: SampledTrajectory,
    loads: Loads,
    near: ClosedState | None,
    share: float,
) -> SampledTrajectory:
    """The path of a trajectory as fast as the limits allow.

    Its acceleration has no jumps, so that controllers that join the points keep the limits too.

    Args:
        robot: the robot.
        trajectory: a trajectory of independent joints, whose times do not matter.
        loads: loads besides the actuators.
        near: closed state whose assembly modes are kept; the robot's own if None.
        share: share of each limit that is used.

    Raises:
        RejectedError: no motion keeps all limits.
        HybridDynamicsError: a loop does not close on the path.
    """
    path = _active_path(robot, trajectory, near)
    try:
        fastest = robot.retime(
            path,
            loads,
            near=near,
            stations=_STATIONS,
            share=share,
        )
        constraints = Constraints(robot, fastest.curve, loads, near, share)
        ramp = min(_RAMP, fastest.duration / (10.0 * _STATIONS))
        motion = eased(fastest, constraints, ramp)
    except InputError as error:
        raise RejectedError(RejectionCode.LIMIT, str(error)) from error
    # messages have nanoseconds: the points are those of their times
    stamps = np.round(motion.times * NS)
    time = np.unique(stamps) / NS
    point = motion(time)
    point.du[[0, -1]] = 0.0
    return SampledTrajectory(robot.active, time, *point)


def _active_path(
    robot: Robot, trajectory: SampledTrajectory, near: ClosedState | None
) -> FloatArray:
    """Positions (N, n) of the active joints along a path, dense if it is one of other joints."""
    names = trajectory.names
    if set(names) == set(robot.active):
        order = [names.index(name) for name in robot.active]
        return trajectory.position[:, order]
    curve = curve_of(trajectory.position, names)
    evenly = np.linspace(0.0, curve.end, _STATIONS)
    rows = []
    dense = np.union1d(curve.s, evenly)
    for position in curve.at(dense).tolist():
        given = dict(zip(names, position, strict=True))
        near = robot.close_given(given, near=near)
        rows.append(near.u)
    return np.array(rows)


def require_times(time: FloatArray) -> None:
    """Check the times (N,) [s] of points.

    Raises:
        RejectedError: a time is negative, times do not increase, or there are fewer than two.
    """
    if time.size < 2:
        raise RejectedError(RejectionCode.BAD_REQUEST, f"{time.size} points, expected 2 or more")
    if time[0] < 0.0:
        text = f"point 0 is at {time[0]:g} s, expected no negative time"
        raise RejectedError(RejectionCode.BAD_REQUEST, text)
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        before = late[0]
        times = f"{time[before + 1]:g} s, expected later than {time[before]:g} s"
        raise RejectedError(RejectionCode.BAD_REQUEST, f"point {before + 1} is at {times}")


@dataclass(frozen=True, eq=False)
class SmoothMotion:
    """Named coordinates as smooth functions of time.

    Between two points they are quintic polynomials with the positions, velocities and accelerations
    of both, as in joint_trajectory_controller.

    Attributes:
        names: names of n coordinates.
        time: times of N points (N,) [s].
        position, velocity, acceleration: values at the points (N, n) [rad or m, per s, per s^2].
    """

    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def at(self, time: float) -> Point:
        """Position, velocity and acceleration (n,) at a time [s]."""
        last = self.time.size - 2
        k = int(np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, last))
        for point in (k, k + 1):
            if time == self.time[point]:
                return self.position[point], self.velocity[point], self.acceleration[point]
        span = float(self.time[k + 1] - self.time[k])
        x = (time - self.time[k]) / span
        coefficients = self._coefficients(k, span)
        powers = x ** np.arange(6)
        slopes = np.arange(1, 6) * powers[:5]
        curvatures = np.arange(2, 6) * np.arange(1, 5) * powers[:4]
        return (
            powers @ coefficients,
            slopes @ coefficients[1:] / span,
            curvatures @ coefficients[2:] / span**2,
        )

    def end_after(self, time: float) -> float:
        """The first point after a time, or the last one [s]."""
        following = np.searchsorted(self.time, time, side="right")
        return float(self.time[min(int(following), self.time.size - 1)])

    def _coefficients(self, k: int, span: float) -> FloatArray:
        """Coefficients (6, n) of the quintic of interval k, in normalised time."""
        start, end = self._scaled(k, span), self._scaled(k + 1, span)
        lower = np.stack([start[0], start[1], 0.5 * start[2]])
        reached = np.stack([lower.sum(axis=0), lower[1] + 2.0 * lower[2], 2.0 * lower[2]])
        return np.concatenate([lower, _QUINTIC @ (end - reached)])

    def _scaled(self, k: int, span: float) -> FloatArray:
        velocity, acceleration = span * self.velocity[k], span**2 * self.acceleration[k]
        return np.stack([self.position[k], velocity, acceleration])


class PathSearch:
    """Inverse kinematics along poses of the end effector, each solved from the previous one.

    It works in pieces, and can be pickled between pieces.
    """

    def __init__(
        self,
        time: FloatArray,
        poses: Sequence[Pose | FloatArray],
        start: FloatArray,
        near: ClosedState | None = None,
    ) -> None:
        """Start without results.

        Args:
            time: (N,) [s].
            poses: N poses, or positions (3,) [m], in the base frame.
            start: active joints (n,) at the start of the search [rad or m].
            near: a closed state whose assembly modes are kept; the robot's own if None.
        """
        self._time, self._poses, self._start, self._near = time, poses, start, near
        self._rows: list[FloatArray] = []
        self.problem: Rejection | None = None  # of the first pose that is not reached

    @property
    def is_done(self) -> bool:
        """Whether the search is complete."""
        return self.problem is not None or self.count == len(self._poses)

    @property
    def count(self) -> int:
        """Number of solved poses."""
        return len(self._rows)

    @property
    def progress(self) -> float:
        """Solved share of the poses."""
        return self.count / len(self._poses)

    @property
    def reached(self) -> float:
        """Time up to which the path is solved [s]."""
        return float(self._time[max(self.count - 1, 0)])

    @property
    def next_time(self) -> float:
        """Time of the first unsolved pose [s]."""
        return float(self._time[self.count])

    def advance(self, robot: Robot, budget: float = math.inf) -> None:
        """Continue the search, for about `budget` [s] if given."""
        end = monotonic() + budget
        while not self.is_done:
            self._solve_next(robot)
            if monotonic() > end:
                break

    def trajectory(self, robot: Robot) -> SampledTrajectory:
        """The motion of the active joints up to the last reached pose."""
        reached = np.array(self._rows).reshape(-1, len(robot.active))
        return SampledTrajectory(robot.active, self._time[: len(reached)], reached)

    def _solve_next(self, robot: Robot) -> None:
        number = self.count
        seed = self._rows[-1] if self._rows else self._start
        result = robot.inverse_kinematics(self._poses[number], seed=seed, near=self._near)
        if result.status is IKStatus.SOLVED:
            self._rows.append(result.u)
            return
        code = _UNSOLVED.get(result.status, RejectionCode.UNREACHABLE)
        place = f"point {number} at {self._time[number]:g} s"
        self.problem = Rejection(code, f"{place}: {' '.join(result.message.split())}")
