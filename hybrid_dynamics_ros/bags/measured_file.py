"""Measured runs from CSV and .npz files: coordinates, pressures of cylinders, efforts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.estimation import MeasuredRun
from hybrid_dynamics_core.ground.suggestions import suggestion

from ..messages.joint_samples import FloatArray
from .column_units import Columns, in_si_units
from .errors import BagError
from .trajectory_file import read_columns, require_trajectory

SIDES: Final = ("cap_pressure", "rod_pressure")
EFFORT: Final = "effort"
TIMES: Final = ("time", "t")


@dataclass(frozen=True, eq=False)
class Measurements:
    """Raw columns of a recording.

    Attributes:
        time: (N,) [s].
        positions: coordinates (N,) [rad, m] by name.
        efforts: (N,) [N m, N] by drive; NaN where unknown.
        pressures: (N,) [Pa] on cap and rod side, by cylinder.
        unused: names of other columns.
    """

    time: FloatArray
    positions: dict[str, FloatArray]
    efforts: dict[str, FloatArray]
    pressures: dict[str, tuple[FloatArray, FloatArray]]
    unused: tuple[str, ...] = ()

    def within(self, start: float, end: float) -> Measurements:
        """The samples from one time to another, [s] since the first sample."""
        since = self.time - self.time[0]
        rows = (since >= start) & (since <= end)
        pressures = {}
        for name, (cap, rod) in self.pressures.items():
            pressures[name] = (cap[rows], rod[rows])
        return Measurements(
            self.time[rows],
            {name: values[rows] for name, values in self.positions.items()},
            {name: values[rows] for name, values in self.efforts.items()},
            pressures,
            self.unused,
        )

    def run(self, robot: Robot) -> MeasuredRun:
        """The run of a robot.

        Raises:
            InputError: the columns do not determine the motion, or a sensor is wrong.
        """
        return MeasuredRun.from_samples(
            robot, self.time, self.positions, self.efforts, self.pressures
        )


def read_measurements(path: Path, robot: Robot) -> Measurements:
    """Read a CSV file with a header, or a .npz with the same names.

    Columns are `time`, coordinates by name, `NAME.cap_pressure` and `NAME.rod_pressure` of
    cylinders, and `NAME.effort` of other drives. A name may have a unit, as in
    `boom_cylinder.cap_pressure [bar]`; the default is SI.

    Raises:
        BagCallError: the file is missing, or of another kind.
        BagError: a column is missing, or has an unknown name or unit.
    """
    require_trajectory(path)
    columns, unused = read_columns(path, robot)
    columns = in_si_units(path, columns, robot)
    name = next((name for name in TIMES if name in columns), None)
    if name is None:
        raise BagError(f"{path}: no column time; there are: {', '.join(columns)}")
    time = columns.pop(name)
    positions = {name: columns.pop(name) for name in robot.coordinates if name in columns}
    pressures = _pressures(path, columns, robot)
    efforts: dict[str, FloatArray] = {}
    for drive in robot.drives:
        column = f"{drive}.{EFFORT}"
        if column not in columns:
            continue
        values = columns.pop(column)
        if drive not in pressures and np.isfinite(values).all():
            efforts[drive] = values
    _require_pressure_names(path, columns, robot)
    return Measurements(time, positions, efforts, pressures, (*columns, *unused))


def _pressures(
    path: Path, columns: Columns, robot: Robot
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Pressures of both sides by cylinder, removed from the columns; raises BagError."""
    pressures: dict[str, tuple[FloatArray, FloatArray]] = {}
    for cylinder in robot.cylinders:
        names = [f"{cylinder}.{side}" for side in SIDES]
        present = [name for name in names if name in columns]
        if not present:
            continue
        if len(present) < len(names):
            missing = next(name for name in names if name not in columns)
            raise BagError(f"{path}: no column {missing}; the force of a cylinder needs both sides")
        cap, rod = (columns.pop(name) for name in names)
        pressures[cylinder] = (cap, rod)
    return pressures


def _require_pressure_names(path: Path, columns: Columns, robot: Robot) -> None:
    """Raise BagError for pressures of what is no cylinder."""
    valid = [f"{cylinder}.{side}" for cylinder in robot.cylinders for side in SIDES]
    for name in columns:
        if name.split(" ")[0].endswith(SIDES):
            listed = ", ".join(robot.cylinders) or "none"
            raise BagError(
                f"{path}: column {name} is of no cylinder{suggestion(name, valid)}; cylinders of"
                f" {robot.name} are: {listed}"
            )
