"""Readings of sensors from CSV files: a column of times, and columns named after the sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hybrid_dynamics_core.filtering import Sensor
from hybrid_dynamics_core.filtering.track import column_names, column_unit
from hybrid_dynamics_core.ground.suggestions import suggestion

from ...messages.joint_samples import FloatArray
from ..column_units import WITH_UNIT, Columns, unit_factor
from ..errors import BagError
from ..measured_file import TIMES
from ..trajectory_file import csv_columns, require_trajectory


@dataclass(frozen=True, eq=False)
class SensorData:
    """Readings of a recording.

    Attributes:
        readings: stamps (N,) [s] and readings (N, k) by sensor; NaN for none.
        unused: names of columns or topics that are of no sensor.
        losses: texts on parts that could not be read.
    """

    readings: dict[str, tuple[FloatArray, FloatArray]]
    unused: tuple[str, ...] = ()
    losses: tuple[str, ...] = ()

    def within(self, start: float, end: float) -> SensorData:
        """The readings from one time to another, [s] since the first of them."""
        firsts = [stamps.min() for stamps, _ in self.readings.values() if len(stamps)]
        first = min(firsts, default=0.0)
        chosen: dict[str, tuple[FloatArray, FloatArray]] = {}
        for name, (stamps, values) in self.readings.items():
            since = stamps - first
            rows = (since >= start) & (since <= end)
            chosen[name] = (stamps[rows], values[rows])
        return SensorData(chosen, self.unused, self.losses)


def read_sensor_table(path: Path, sensors: Sequence[Sensor]) -> SensorData:
    """Read a CSV file with a header.

    Columns are `time`, `NAME` for sensors with one reading, and `NAME.x`, `NAME.y`, `NAME.z` for
    those of frames. A name may have a unit, as in `boom.gyro.x [deg/s]`; the default is SI. An
    empty cell is no reading.

    Raises:
        BagCallError: the file is missing, or of another kind.
        BagError: a column is missing or duplicate, a value is no number, or a unit is wrong.
    """
    require_trajectory(path)
    units = dict.fromkeys(TIMES, "s")
    for sensor in sensors:
        for name in column_names(sensor):
            units[name] = column_unit(sensor)
    columns = _in_units(path, _columns_of(path), units)
    time_name = next((name for name in TIMES if name in columns), None)
    if time_name is None:
        raise BagError(f"{path}: no column time; there are: {', '.join(columns)}")
    time = columns.pop(time_name)
    if not np.isfinite(time).all():
        raise BagError(f"{path}: column {time_name}: expected a number in each row")
    heads = list(columns)
    readings = _readings(path, time, columns, sensors)
    if not readings:
        listed = ", ".join(name for name in units if name not in TIMES)
        hints = [suggestion(name, units) for name in heads]
        hint = next(filter(None, hints), "")
        raise BagError(f"{path}: no column of a sensor{hint}; expected {listed}")
    return SensorData(readings, tuple(columns))


def _readings(
    path: Path, time: FloatArray, columns: Columns, sensors: Sequence[Sensor]
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Stamps and readings by sensor, removed from the columns; raises BagError."""
    readings: dict[str, tuple[FloatArray, FloatArray]] = {}
    for sensor in sensors:
        names = column_names(sensor)
        missing = [name for name in names if name not in columns]
        if len(missing) == len(names):
            continue
        if missing:
            raise BagError(f"{path}: no column {', '.join(missing)}; expected {', '.join(names)}")
        values = np.stack([columns.pop(name) for name in names], axis=1)
        readings[sensor.name] = (time, values)
    return readings


def _columns_of(path: Path) -> Columns:
    """Columns of a CSV file by head; raises BagError."""
    try:
        return csv_columns(path, _number)
    except ValueError as error:
        raise BagError(f"{path}: expected a CSV file with a header and numbers ({error})") from None


def _number(cell: str) -> float:
    """A cell of a table; NaN where it is empty."""
    return float(cell.strip() or "nan")


def _in_units(path: Path, columns: Columns, units: dict[str, str]) -> Columns:
    """Columns in SI units, without units in their names; raises BagError."""
    converted: Columns = {}
    for head, column in columns.items():
        name, values = head, column
        match = WITH_UNIT.fullmatch(head)
        if match is not None and match[1] in units and head not in units:
            name = match[1]
            values = column * unit_factor(path, head, match[2], units[name])
        if name in converted:
            raise BagError(f"{path}: two columns are called {name}")
        converted[name] = values
    return converted
