"""Conversion and check of trajectories, from any independent joints to the active joints.

The motion is followed, so that no loop changes its assembly mode unnoticed. It is checked at the
points and between them. The points of the outcome are so close that efforts are nearly linear
between two of them. It does not depend on ROS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import monotonic
from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot

from ..messages.joint_samples import FloatArray, Rejection
from .trajectory_follower import ConversionSettings, Follower, Sample
from .trajectory_motion import SampledTrajectory, SmoothMotion

_LEAST_SHARE: Final = 1e-6  # least effort of a drive, as a share of the largest effort
_LEAST_EFFORT: Final = 1e-9  # [N m or N] smaller efforts are rounding


@dataclass(frozen=True, eq=False)
class ConvertedTrajectory:
    """Valid points of the active joints, (k, n) each.

    Attributes:
        time: (k,) [s].
        position, velocity, acceleration: [rad or m, per s, per s^2].
        efforts: [N m or N].
        nearest: smallest distance to a singularity along the motion.
        problem: the first problem, or None.
        bad_point: index of the first point that is not reached, or -1.
        bad_time: time of the problem [s], or NaN.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    efforts: FloatArray
    nearest: float
    problem: Rejection | None
    bad_point: int
    bad_time: float


def convert(
    robot: Robot,
    trajectory: SampledTrajectory,
    near: ClosedState | None = None,
    settings: ConversionSettings | None = None,
) -> ConvertedTrajectory:
    """Convert a motion to the active joints, up to the first problem.

    Args:
        robot: the robot.
        trajectory: trajectory of any independent set of coordinates.
        near: the state before the motion, whose assembly modes are kept; None: the reference.
        settings: settings of the conversion.

    Raises:
        RejectedError: the times are wrong.
    """
    conversion = Conversion(trajectory.motion(), near)
    conversion.advance(robot, settings or ConversionSettings())
    return conversion.result()


class Conversion:
    """A conversion in pieces; it can be pickled between pieces."""

    def __init__(self, motion: SmoothMotion, near: ClosedState | None) -> None:
        """Start without results.

        Args:
            motion: the motion.
            near: the state before the motion; None: the reference.
        """
        self._motion, self._near = motion, near
        self._next = 0  # index of the next interval
        self._time: list[float] = []
        self._values: list[FloatArray] = []
        self._surveyed: FloatArray | None = None  # (n,) largest efforts at some of the points
        self._problem: Rejection | None = None
        self._bad = -1, np.nan
        self.nearest = 1.0
        # largest entries of R along the motion, and those at the end
        self.velocity_maps: tuple[FloatArray, FloatArray] | None = None

    @property
    def is_done(self) -> bool:
        """Whether the conversion is complete."""
        return self._problem is not None or self._next == self._motion.time.size - 1

    @property
    def reached(self) -> float:
        """Time up to which the motion is converted [s]."""
        return self._time[-1] if self._time else float(self._motion.time[0])

    @property
    def progress(self) -> float:
        """Converted share of the motion."""
        return self._next / (self._motion.time.size - 1)

    def advance(self, robot: Robot, settings: ConversionSettings, budget: float = np.inf) -> None:
        """Continue the conversion, for about `budget` [s] if given."""
        end = monotonic() + budget
        follower = Follower(robot, self._motion, settings)
        if self._surveyed is None:
            self._surveyed = follower.survey(self._near)
        last = self._last(follower)
        while not self.is_done:
            last = self._convert_interval(follower, last)
            if monotonic() > end:
                break
        self._near = last.state

    def result(self) -> ConvertedTrajectory:
        """The result so far."""
        count = len(self._values)
        n = 0 if not count else self._values[0].shape[1]
        values = np.array(self._values).reshape(count, 4, n)
        position, velocity, acceleration, efforts = values.swapaxes(0, 1)
        number, moment = self._bad
        return ConvertedTrajectory(
            time=np.array(self._time),
            position=position,
            velocity=velocity,
            acceleration=acceleration,
            efforts=efforts,
            nearest=self.nearest,
            problem=self._problem,
            bad_point=number,
            bad_time=moment,
        )

    def _last(self, follower: Follower) -> Sample:
        """The sample at the start of the next interval."""
        last = follower.sample(float(self._motion.time[self._next]), self._near)
        if not self._time:
            self._take([last])
        return last

    def _convert_interval(self, follower: Follower, first: Sample) -> Sample:
        if first.problem is not None:
            return first
        end = float(self._motion.time[self._next + 1])
        for piece in follower.pieces(first, end, self._tolerance(follower)):
            self._take(piece)
            if self._problem is not None:
                return piece[-1]
            first = piece[-1]
        self._next += 1
        return first

    def _take(self, piece: Sequence[Sample]) -> None:
        """Store the last of some samples, and update the summary with all."""
        last = piece[-1]
        good = [sample for sample in piece if sample.problem is None]
        for sample in good:
            if sample.state is not None:
                self._see(sample.state)
        if last.problem is not None:
            self._fail(last)
            return
        self._time.append(last.time)
        self._values.append(last.values)

    def _see(self, state: ClosedState) -> None:
        self.nearest = min(self.nearest, float(state.singularity))
        here = np.abs(state.R)
        largest = here
        if self.velocity_maps is not None:
            largest = np.maximum(here, self.velocity_maps[0])
        self.velocity_maps = largest, here

    def _fail(self, sample: Sample) -> None:
        times, problem = self._motion.time, sample.problem
        number = int(np.searchsorted(times, sample.time))
        self._bad = number, sample.time
        place = f"point {number} at {sample.time:.9g} s"
        if sample.time != times[number]:
            place = (
                f"point {number} at {times[number]:.9g} s is not reached: at {sample.time:.9g} s"
            )
        if problem is not None:
            self._problem = Rejection(problem.code, f"{place}: {problem.text}")

    def _tolerance(self, follower: Follower) -> FloatArray:
        """Tolerance (n,) of efforts of the active joints [N m or N]; infinite if not set."""
        sizes = [np.abs(values[3]) for values in self._values]
        if self._surveyed is not None:
            sizes.append(self._surveyed)
        largest: FloatArray = np.max(sizes, axis=0)
        least = max(_LEAST_SHARE * float(largest.max(initial=0.0)), _LEAST_EFFORT)
        return follower.allowed(np.maximum(largest, least))
