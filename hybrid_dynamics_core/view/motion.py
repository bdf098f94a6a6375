"""Motions for playback: closed states over time, with efforts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..closed_state.state import ClosedState
from ..control.trajectory import JointTrajectory
from ..errors import InputError, StateError
from ..ground.arrays import Array
from ..robot.robot import Robot

RATE: Final = 100.0  # [Hz] sampling rate of trajectories
LARGEST: Final = 6000  # largest number of states


@dataclass(frozen=True, eq=False)
class Motion:
    """States over time.

    Attributes:
        title: short title.
        time: (N,) [s], ascending, from 0.
        state: closed states, a batch of N.
        ddu: (N, n) accelerations of the active joints; NaN where they are unknown.
        recorded: (N, n) measured efforts [N m or N], NaN where missing; None if there are none.
        note: a remark on its efforts.

    Raises:
        InputError: shapes do not match, or times do not ascend.
    """

    title: str
    time: Array
    state: ClosedState
    ddu: Array
    recorded: Array | None = None
    note: str = ""

    def __post_init__(self) -> None:
        if not self._fits():
            raise InputError(
                "a motion has one time, one closed state and one row of accelerations a sample"
            )
        if (np.diff(self.time) < 0.0).any():
            raise InputError("the times of a motion have to ascend")

    def _fits(self) -> bool:
        """Whether times, states and accelerations have the same number of samples."""
        count = len(self.time)
        if self.time.ndim != 1 or count == 0:
            return False
        shape = self.state.u.shape
        return shape[0] == count and self.ddu.shape == shape

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.time[-1])

    def index(self, time: float) -> int:
        """Index of the sample that is nearest to a time [s]."""
        after = int(np.searchsorted(self.time, time))
        if after == 0:
            return 0
        if after == len(self.time):
            return after - 1
        to_next = self.time[after] - time
        to_last = time - self.time[after - 1]
        return after if to_next < to_last else after - 1

    def at(self, index: int) -> ClosedState:
        """The state of one sample."""
        return self.state.rows(index)


def motion_of(
    robot: Robot,
    trajectory: JointTrajectory,
    title: str,
    recorded: Array | None = None,
) -> Motion:
    """A motion along a trajectory of the active joints, with all loops closed.

    Args:
        robot: the robot.
        trajectory: trajectory of its active joints.
        title: short title.
        recorded: (N, n) measured efforts at the trajectory's times [N m or N]; None if there are
            none.

    Returns:
        The motion.

    Raises:
        InputError: the loops do not close; the message has the time.
    """
    wanted = round(trajectory.duration * RATE) + 1
    count = int(np.clip(wanted, 2, LARGEST))
    time = np.linspace(0.0, trajectory.duration, count)
    start, end = trajectory.times[0], trajectory.times[-1]
    reference = trajectory(np.minimum(start + time, end))  # at rest beyond the end
    try:
        state = robot.close_path(reference.u, reference.du)
    except StateError as error:
        moment = float(time[error.index or 0] + start)
        raise InputError(
            f"{title} cannot be followed to its end: at {moment:.6g} s, {error}"
        ) from error
    if recorded is not None:
        times = trajectory.times - start
        columns = [np.interp(time, times, column) for column in recorded.T]
        recorded = np.stack(columns, axis=1)
    return Motion(title, time, state, reference.ddu, recorded)
