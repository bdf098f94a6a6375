"""Duty cycles: motion of a robot with the loads at its end effector, from CSV files."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..formats.tables import Table, table_of
from ..ground.arrays import Array
from ..ground.suggestions import did_you_mean, suggestion
from ..ground.units import coordinate_unit, effort_unit
from ..robot.robot import Robot

TIME = "time"
WEIGHT = "weight"
PAYLOAD = ("payload", "payload.x", "payload.y", "payload.z")
WRENCH = ("force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z")
_UNITS = {
    TIME: "s",
    WEIGHT: "1",
    **dict(zip(PAYLOAD, ("kg", "m", "m", "m"), strict=True)),
    **dict.fromkeys(WRENCH[:3], "N"),
    **dict.fromkeys(WRENCH[3:], "N m"),
}
_SLIP = 0.85  # similarity of two names, above which one is a slip of the other
_LEAST_ROWS = 4  # of a spline of third degree


@dataclass(frozen=True, eq=False)
class DutyCycle:
    """What a robot does: N rows of a motion, or N places on their own.

    Attributes:
        names: the n independent coordinates.
        values: (N, n) [rad or m].
        rates: (N, n) [rad/s or m/s].
        accelerations: (N, n) [rad/s^2 or m/s^2].
        payload: (N, 4) mass at the end effector [kg], and its centre in that frame [m].
        wrench: (N, 6) force and moment on the end effector, base axes [N, N m].
        time: (N,) [s], ascending; None if the rows are no motion.
        weights: (N,) share of each row in means; their sum is one.
        places: where each row stands, for messages.
        unused: columns that were not used.
    """

    names: tuple[str, ...]
    values: Array
    rates: Array
    accelerations: Array
    payload: Array
    wrench: Array
    time: Array | None
    weights: Array
    places: tuple[str, ...]
    unused: tuple[str, ...] = ()


def read_duty(data: str | Path | Mapping[str, Sequence[float] | Array], robot: Robot) -> DutyCycle:
    """A duty cycle from a CSV file, or from columns by name.

    Columns are coordinates by name: the active ones, or as many others that determine the motion.
    Active coordinates that are left out stay at the reference. Further columns are `time`,
    `NAME.velocity` and `NAME.acceleration`, `payload` with `payload.x`, `payload.y`, `payload.z`,
    `force.x` to `moment.z` on the end effector in base axes, and `weight`. Rates that are left out
    follow from `time` by a cubic spline; without `time` they are zero.

    Args:
        data: the file, or columns in SI units.
        robot: the robot.

    Raises:
        InputError: a column is missing, its name has a slip, or a cell is empty or no number.
    """
    table = table_of(data, lambda name: _units_of(name, robot))
    return _Reader(table, robot).duty()


def _units_of(name: str, robot: Robot) -> Sequence[str]:
    """The unit of a column; any unit for columns that are not used."""
    units = _column_units(robot)
    if name not in units:
        return []
    return [units[name]]


def _column_units(robot: Robot) -> dict[str, str]:
    """Units of all columns that a duty cycle may have."""
    units = dict(_UNITS)
    for joint, kind in robot.joint_types.items():
        units[joint] = coordinate_unit(kind)
        units[f"{joint}.velocity"] = coordinate_unit(kind, "/s")
        units[f"{joint}.acceleration"] = coordinate_unit(kind, "/s^2")
        units[f"{joint}.effort"] = effort_unit(kind)
    return units


class _Reader:
    """Makes a duty cycle of a table."""

    def __init__(self, table: Table, robot: Robot) -> None:
        self.table = table
        self.robot = robot
        self.used: set[str] = set()
        self.count = len(table.lines)

    def duty(self) -> DutyCycle:
        """The duty cycle."""
        names = self.names()
        time = self.time()
        values = self.columns(names, self.reference(names))
        rates = self.rates(names, "velocity", values, time)
        accelerations = self.rates(names, "acceleration", rates, time)
        payload = self.columns(PAYLOAD, {})
        self.require(payload[:, 0] >= 0.0, "the payload is negative")
        wrench = self.columns(WRENCH, {})
        weights = self.weights(time)
        places = tuple(self.table.row(k) for k in range(self.count))
        unused = self.unused()
        return DutyCycle(
            names=names,
            values=values,
            rates=rates,
            accelerations=accelerations,
            payload=payload,
            wrench=wrench,
            time=time,
            weights=weights,
            places=places,
            unused=unused,
        )

    def unused(self) -> tuple[str, ...]:
        """Names of the columns that were not used; raises InputError for a slip in a name."""
        meant = _column_units(self.robot)
        unused = tuple(name for name in self.table.columns if name not in self.used)
        for name in unused:
            near = difflib.get_close_matches(name, list(meant), n=1, cutoff=_SLIP)
            if near and name not in meant:
                raise InputError(
                    f"{self.table.source}: there is no column '{name}'{did_you_mean(near[0])}; a"
                    " column of another meaning needs a name that is not so near"
                )
        return unused

    def require(self, good: np.ndarray, problem: str) -> None:
        """Raise InputError with a problem at the first row (N,) that is not good."""
        bad = np.flatnonzero(~good)
        if len(bad):
            row = self.table.row(int(bad[0]))
            raise InputError(f"{row}: {problem}")

    def names(self) -> tuple[str, ...]:
        """The independent coordinates."""
        active = self.robot.active
        given = [name for name in self.table.columns if name in self.robot.coordinates]
        if set(active) <= set(given) or (given and set(given) <= set(active)):
            return active
        if len(given) == len(active):
            return tuple(given)
        hints = (suggestion(name, self.robot.coordinates) for name in self.table.columns)
        hint = next(filter(None, hints), "")
        there = ", ".join(given) or "none"
        raise InputError(
            f"{self.table.source}: columns of coordinates: {there}{hint}; expected some of"
            f" {', '.join(active)}, or {len(active)} coordinates that determine the motion"
        )

    def reference(self, names: tuple[str, ...]) -> dict[str, float]:
        """The reference by name; only active coordinates are ever left out."""
        if names != self.robot.active:
            return {}
        return dict(zip(names, self.robot.reference.tolist(), strict=True))

    def columns(self, names: Sequence[str], otherwise: Mapping[str, float]) -> Array:
        """Columns (N, k) by name; a number, or zero, for those that are left out."""
        matrix = np.zeros((self.count, len(names)))
        for k, name in enumerate(names):
            matrix[:, k] = otherwise.get(name, 0.0)
            if name in self.table.columns:
                matrix[:, k] = self.column(name)
        return matrix

    def column(self, name: str) -> Array:
        """A column (N,) without empty cells."""
        values = self.table.columns[name]
        self.require(np.isfinite(values), f"{name} has no finite number")
        self.used.add(name)
        return values

    def time(self) -> Array | None:
        """Times (N,), or None."""
        if TIME not in self.table.columns:
            return None
        time = self.column(TIME)
        steps = np.diff(time, prepend=-np.inf)
        self.require(steps > 0.0, "the time does not rise from the row before")
        return time

    def rates(self, names: Sequence[str], part: str, values: Array, time: Array | None) -> Array:
        """Rates (N, n) of values: columns, else slopes of splines over the time, else zero."""
        from scipy.interpolate import CubicSpline  # noqa: PLC0415  slow to import

        rates = np.zeros_like(values)
        for k, name in enumerate(names):
            column = f"{name}.{part}"
            if column in self.table.columns:
                rates[:, k] = self.column(column)
                continue
            if time is None or not np.ptp(values[:, k]):
                continue
            if self.count < _LEAST_ROWS:
                raise InputError(
                    f"{self.table.source}: has {self.count} rows; {column} follows from"
                    f" {_LEAST_ROWS} or more, or give it as a column"
                )
            spline = CubicSpline(time, values[:, k])
            rates[:, k] = spline(time, 1)
        return rates

    def weights(self, time: Array | None) -> Array:
        """Share of each row in means: its time by the trapezoidal rule, times its weight."""
        weights = np.ones(self.count)
        if time is not None and self.count > 1:
            steps = np.diff(time)
            weights[:-1] = 0.5 * steps
            weights[-1] = 0.0
            weights[1:] += 0.5 * steps
        if WEIGHT in self.table.columns:
            weights = weights * self.column(WEIGHT)
        self.require(weights >= 0.0, "the weight is negative")
        total = weights.sum()
        if not total:
            raise InputError(f"{self.table.source}: all weights are zero")
        return np.asarray(weights / total)
