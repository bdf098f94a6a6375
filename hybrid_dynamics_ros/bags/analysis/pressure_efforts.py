"""Efforts of the active joints at given stamps, from recorded pressures.

The node combines a joint state with the last pressures before it. Here later ones are available
too, and forces are interpolated linearly between two readings. So they have no delay.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Robot, SingularityError, cylinder_force
from hybrid_dynamics_core.dynamics.pressure_check import exchanged_text, fits_exchanged

from ...messages.joint_samples import FloatArray
from ...messages.pressures import PressureInput, PressureSample
from ..recorded_pressures import pressure_topic, read_pressures
from ..storage.bag_reader import BagReader

Stamps = NDArray[np.int64]
_LEAST: Final = 20  # samples that show the side of a sensor


class PressureEfforts:
    """Efforts from pressures.

    Attributes:
        topic: topic of the pressures; empty if there is none.
    """

    def __init__(self, robot: Robot, source: BagReader, max_age: float) -> None:
        """Read all pressures of a bag; unusable messages are added to its losses.

        Args:
            robot: the robot.
            source: the bag.
            max_age: largest time between a reading and a stamp [s].
        """
        self.topic = pressure_topic(source)
        self._robot = robot
        self._reach = round(max_age * 1e9)
        self._indices = [robot.coordinates.index(name) for name in robot.drives]
        self._readings: list[dict[int, float]] = [{} for _ in robot.drives]
        self._sides: dict[str, tuple[dict[int, float], dict[int, float]]] = {}
        pressures = PressureInput(robot, max_age)
        for _, is_taken in read_pressures(pressures, source, source.losses):
            if is_taken:
                measured = pressures.newest[-1]
                for drive in np.flatnonzero(np.isfinite(measured.forces)).tolist():
                    self._readings[drive][measured.stamp_ns] = float(measured.forces[drive])
                self._take_sides(pressures.sample)

    def _take_sides(self, sample: PressureSample | None) -> None:
        """Keep the pressures of both sides of the robot's cylinders."""
        if sample is None:
            return
        rows = zip(sample.names, sample.cap_pressure, sample.rod_pressure, strict=True)
        for name, cap, rod in rows:
            if name in self._robot.cylinders and np.isfinite([cap, rod]).all():
                of_cap, of_rod = self._sides.setdefault(name, ({}, {}))
                of_cap[sample.stamp_ns] = float(cap)
                of_rod[sample.stamp_ns] = float(rod)

    def pressures(self, stamps: Stamps) -> dict[str, FloatArray]:
        """Pressures (N, 2) on cap and rod side by cylinder [Pa]; NaN if not measured."""
        pressures: dict[str, FloatArray] = {}
        for name, sides in self._sides.items():
            columns = [_between(readings, stamps, self._reach) for readings in sides]
            pressures[name] = np.stack(columns, axis=1)
        return pressures

    def efforts(self, stamps: Stamps, state: ClosedState) -> FloatArray:
        """Efforts of the active joints (N, n) [N m or N]; NaN if not measured.

        Args:
            stamps: stamps (N,) [ns].
            state: closed states at the stamps, a batch of N.
        """
        active = len(self._robot.active)
        efforts = np.full((len(stamps), active), np.nan)
        if not any(self._readings):
            return efforts
        forces = self.forces(stamps)
        if max(self._indices) < active:
            efforts[:, self._indices] = forces
            return efforts
        # virtual work: tau is R^T times the forces, where those of drives that do no work may lack
        rates = state.R[:, self._indices, :]
        does_work = rates != 0.0
        parts = np.where(does_work, rates * forces[:, :, None], 0.0)
        return np.where(does_work.any(axis=1), parts.sum(axis=1), np.nan)

    def forces(self, stamps: Stamps) -> FloatArray:
        """Forces along the drives (N, d) [N]; NaN if not measured."""
        columns = [_between(readings, stamps, self._reach) for readings in self._readings]
        return np.stack(columns, axis=1)


def exchanged_chambers(
    robot: Robot, state: ClosedState, efforts: FloatArray, pressures: dict[str, FloatArray]
) -> str:
    """A text on cylinders whose pressures fit with exchanged chambers; "" if there are none.

    Args:
        robot: the robot.
        state: closed states, a batch of N.
        efforts: efforts (N, n) of the active joints that the motion requires [N m or N].
        pressures: pressures (N, 2) on cap and rod side by cylinder [Pa]; NaN if not measured.
    """
    rows = np.flatnonzero(np.isfinite(efforts).all(axis=1))
    try:
        required = robot.drive_forces(state.rows(rows), efforts[rows])
    except SingularityError:
        return ""  # the drives cannot give these efforts
    names: list[str] = []
    for name, sides in pressures.items():
        cap, rod = sides[rows].T
        is_measured = np.isfinite(cap)
        if name not in required or is_measured.sum() < _LEAST:
            continue
        cylinder, needed = robot.cylinders[name], required[name]
        squares: list[float] = []
        for first, second in ((cap, rod), (rod, cap)):
            rest = (cylinder_force(cylinder, first, second) - needed)[is_measured]
            squares.append(float(rest @ rest))
        if fits_exchanged(*squares):
            names.append(name)
    return exchanged_text(names) if names else ""


def _between(readings: dict[int, float], stamps: Stamps, reach: int) -> FloatArray:
    """Values (N,) between readings by stamp [ns]; NaN without readings within `reach` [ns]."""
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
