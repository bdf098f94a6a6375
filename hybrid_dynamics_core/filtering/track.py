"""States of a recorded motion from readings of its sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..estimation.sensors import SensorError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .gate import Innovation
from .motion_model import MotionModel
from .observability import observability
from .raw_checks import Columns, check_stuck, check_values, in_order
from .sensors import AT_JOINTS, AXES, SPATIAL, Kind, Sensor
from .start import Reading, unit_of
from .stream import LOST, Counts, Estimate, StateFilter
from .suspects import CONTRADICTED, LEAST, contradiction

Readings = Mapping[str, tuple[ArrayLike, ArrayLike]]


@dataclass(frozen=True, eq=False)
class StateTrack:
    """Estimated states of a motion: N instants.

    Attributes:
        time: (N,) [s].
        state: closed states, a batch of N.
        ddu: (N, n) active accelerations [rad/s^2, m/s^2].
        covariance: (N, 3 n, 3 n) of [u; u'; u''].
        bias: constant errors (k,) of sensors at the end, by name.
        counts: what became of the readings.
        unchecked: sensors of joints that no other sensor checks: without one of them the state is
            not determined, so no contradiction shows its errors.
        notes: sentences on what was changed or is doubtful.
    """

    time: Array
    state: ClosedState
    ddu: Array
    covariance: Array
    bias: Mapping[str, Array]
    counts: Counts
    unchecked: tuple[str, ...]
    notes: tuple[str, ...]

    def deviations(self) -> Array:
        """Deviations (N, n) of the active coordinates [rad, m]."""
        n = self.state.u.shape[1]
        variances = np.diagonal(self.covariance, axis1=1, axis2=2)
        return np.sqrt(variances[:, :n])


def estimate_states(
    robot: Robot,
    sensors: Sequence[Sensor],
    readings: Readings,
    motion: MotionModel,
    initial: ArrayLike | None = None,
) -> StateTrack:
    """The states of a motion at each stamp, from all readings up to it.

    Args:
        robot: the robot.
        sensors: its sensors.
        readings: stamps (N,) [s] and readings (N,) or (N, k) by name of the sensor.
        motion: how the machine may move.
        initial: active coordinates (n,) near which it starts [rad, m]; None: it searches.

    Raises:
        ObservabilityError: the sensors do not determine the state.
        SensorError: a sensor gives what it cannot have measured, or contradicts the others.
        InputError: a name is unknown, a shape is wrong, or there are no readings.
    """
    columns = _columns(sensors, readings)
    present = [sensor for sensor in sensors if sensor.name in columns]
    columns, notes = in_order(columns)
    for sensor in present:
        check_values(sensor, columns[sensor.name][1])
    check_stuck(present, columns)
    for sensor in sensors:
        if sensor not in present:
            notes.append(f"{sensor.name}: there are no readings")
    watched = StateFilter(robot, present, motion, initial, latest=0.0)
    in_time = _in_time(present, columns)
    try:
        estimates, shown = _run(watched, in_time)
    except SensorError as error:
        first = in_time[0].time
        raise SensorError(f"{error}: {contradiction(present, in_time, motion, first)}") from error
    if not estimates:
        raise SensorError("the readings end before each sensor has one")
    since = _first_contradiction(present, shown)
    if since is not None:
        text = contradiction(present, in_time, motion, since)
        raise SensorError(f"from {since:g} s on, {text}")
    if watched.counts.starts > 1:
        notes.append(f"the filter started {watched.counts.starts} times")
    return StateTrack(
        time=np.array([estimate.time for estimate in estimates]),
        state=ClosedState.joined([estimate.state for estimate in estimates]),
        ddu=np.stack([estimate.ddu for estimate in estimates]),
        covariance=np.stack([estimate.covariance for estimate in estimates]),
        bias=watched.bias,
        counts=watched.counts,
        unchecked=_unchecked(present, motion),
        notes=tuple(notes),
    )


def _unchecked(sensors: Sequence[Sensor], motion: MotionModel) -> tuple[str, ...]:
    """Names of sensors of joints without which the others do not determine the state."""
    names: list[str] = []
    for sensor in sensors:
        if sensor.kind not in AT_JOINTS:
            continue
        others = [other for other in sensors if other is not sensor]
        if not others or observability(sensor.robot, others, motion).undetermined:
            names.append(sensor.name)
    return tuple(names)


def _columns(
    sensors: Sequence[Sensor],
    readings: Readings,
) -> Columns:
    """Checked stamps and readings (N, k); rows without a reading are left out."""
    by_name = {sensor.name: sensor for sensor in sensors}
    columns: dict[str, tuple[Array, Array]] = {}
    require_type("readings", readings, Mapping, "{name: (stamps, values)}")
    for name, (stamps, values) in readings.items():
        if name not in by_name:
            raise InputError(f"readings: {no_such_name('sensor', name, tuple(by_name))}")
        time = np.asarray(stamps, dtype=np.float64)
        table = np.asarray(values, dtype=np.float64)
        channels = by_name[name].channels
        if table.ndim == 1 and channels == 1:
            table = table[:, None]
        if time.ndim != 1 or table.shape != (len(time), channels):
            raise InputError(
                f"{name}: stamps {time.shape} and readings {table.shape}; expected (N,) and"
                f" (N, {channels})"
            )
        rows = ~np.isnan(table).any(axis=1)
        columns[name] = (time[rows], table[rows])
        if not (np.isfinite(columns[name][0]).all() and np.isfinite(columns[name][1]).all()):
            raise InputError(f"{name}: a stamp or reading is not finite")
    return {name: column for name, column in columns.items() if len(column[0])}


def _in_time(
    sensors: Sequence[Sensor],
    columns: Columns,
) -> list[Reading]:
    """All readings by stamp; those of one stamp in the order of the sensors."""
    merged: list[tuple[float, int, Reading]] = []
    for k, sensor in enumerate(sensors):
        stamps, values = columns[sensor.name]
        for time, row in zip(stamps.tolist(), values, strict=True):
            merged.append((time, k, Reading(time, sensor.name, row)))
    merged.sort(key=lambda entry: entry[:2])
    return [reading for _, _, reading in merged]


def _run(
    watched: StateFilter,
    readings: Sequence[Reading],
) -> tuple[list[Estimate], list[Innovation]]:
    """The estimate after each stamp, and what each reading showed."""
    estimates: list[Estimate] = []
    shown: list[Innovation] = []
    for k, reading in enumerate(readings):
        shown += watched.add(*reading)
        is_last = k + 1 == len(readings)
        if watched.has_started and (is_last or readings[k + 1].time > reading.time):
            estimates.append(watched.estimate)
    return estimates, shown


def _first_contradiction(
    sensors: Sequence[Sensor],
    shown: Sequence[Innovation],
) -> float | None:
    """The time at which a sensor begins to contradict the others; None if none does."""
    times: list[float] = []
    for sensor in sensors:
        of_sensor = [each for each in shown if each.sensor == sensor.name]
        beyond = [each.time for each in of_sensor if not each.is_used]
        if len(beyond) >= LEAST and len(beyond) > CONTRADICTED * len(of_sensor):
            times.append(beyond[LEAST - 1])
            continue
        in_row = 0
        for each in of_sensor:
            in_row = 0 if each.is_used else in_row + 1
            if in_row == LOST:
                times.append(each.time)
    return min(times, default=None)


def column_names(sensor: Sensor) -> list[str]:
    """Names of the columns of a sensor in tables."""
    if sensor.kind in SPATIAL:
        return [f"{sensor.name}.{axis}" for axis in "xyz"[:AXES]]
    return [sensor.name]


def column_unit(sensor: Sensor) -> str:
    """The SI unit of the columns of a sensor."""
    if sensor.kind is Kind.ACCELEROMETER:
        return "m/s^2"
    return unit_of(sensor)
