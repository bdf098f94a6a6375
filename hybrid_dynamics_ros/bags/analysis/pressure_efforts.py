"""Efforts of the active joints that the pressures of a recording measure, at any stamps.

The node joins a joint state with what came before it. Here what comes after is there too: forces
are linear between two readings, so that they are not late.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Robot

from ...messages.joint_samples import FloatArray
from ...messages.pressures import PressureInput
from ..recorded_pressures import pressure_topic, read_pressures
from ..storage.bag_reader import BagReader

Stamps = NDArray[np.int64]


class PressureEfforts:
    """What pressures say of the efforts.

    Attributes:
        topic: where the pressures are; empty where there are none.
    """

    def __init__(self, robot: Robot, source: BagReader, max_age: float) -> None:
        """Read all pressures of a bag; messages that cannot be used are added to its losses.

        Args:
            robot: the robot.
            source: the bag.
            max_age: how far readings may be from a stamp [s].
        """
        self.topic = pressure_topic(source)
        self._robot = robot
        self._reach = round(max_age * 1e9)
        self._indices = [robot.coordinates.index(name) for name in robot.drives]
        self._readings: list[dict[int, float]] = [{} for _ in robot.drives]
        pressures = PressureInput(robot, max_age)
        for _, is_taken in read_pressures(pressures, source, source.losses):
            if is_taken:
                measured = pressures.newest[-1]
                for drive in np.flatnonzero(np.isfinite(measured.forces)).tolist():
                    self._readings[drive][measured.stamp_ns] = float(measured.forces[drive])

    def efforts(self, stamps: Stamps, state: ClosedState) -> FloatArray:
        """Efforts of the active joints (N, n) [N m or N]; NaN where they are not measured.

        Args:
            stamps: (N,) [ns].
            state: closed there, a batch of N.
        """
        active = len(self._robot.active)
        efforts = np.full((len(stamps), active), np.nan)
        if not any(self._readings):
            return efforts
        forces = self.forces(stamps)
        if max(self._indices) < active:
            efforts[:, self._indices] = forces
            return efforts
        rates = state.R[:, self._indices, :]
        moves = rates != 0.0
        parts = np.where(moves, rates * forces[:, :, None], 0.0)
        return np.where(moves.any(axis=1), parts.sum(axis=1), np.nan)

    def forces(self, stamps: Stamps) -> FloatArray:
        """Forces along the drives (N, d) [N]; NaN where they are not measured."""
        columns = [_between(readings, stamps, self._reach) for readings in self._readings]
        return np.stack(columns, axis=1)


def _between(readings: dict[int, float], stamps: Stamps, reach: int) -> FloatArray:
    """Values (N,) between readings by stamp [ns], where the next ones are within reach [ns]."""
    if not readings:
        return np.full(len(stamps), np.nan)
    times = np.array(sorted(readings), dtype=np.int64)
    values = np.array([readings[time] for time in times.tolist()])
    last = len(times) - 1
    after = np.minimum(np.searchsorted(times, stamps), last)
    before = np.maximum(np.searchsorted(times, stamps, side="right") - 1, 0)
    since, until = stamps - times[before], times[after] - stamps
    share = since / np.maximum(since + until, 1)
    value = (1.0 - share) * values[before] + share * values[after]
    nearest, farthest = np.minimum(since, until), np.maximum(since, until)
    is_measured = (nearest >= 0) & (farthest <= reach)
    return np.where(is_measured, value, np.nan)
