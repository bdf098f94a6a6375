"""Catalogues of drives: CSV files with a row for each cylinder or motor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ..errors import InputError
from ..formats.tables import Table, table_of
from ..ground.suggestions import no_such_name

NAME = "name"
_CYLINDER_UNITS = {
    "bore": "m",
    "rod": "m",
    "stroke": "m",
    "retracted": "m",
    "pressure": "Pa",
    "speed": "m/s",
    "modulus": "Pa",
    "length": "m",
    "mass": "kg",
}
_MOTOR_UNITS = {
    "torque": "N m",
    "speed": "rad/s",
    "peak_torque": "N m",
    "power": "W",
    "inertia": "kg m^2",
    "gear_ratio": "1",
    "efficiency": "1",
    "lead": "m",
    "mass": "kg",
}
_NEEDED_OF_CYLINDERS = ("bore", "rod", "stroke")
_NEEDED_OF_MOTORS = ("torque", "speed")
_MAY_BE_ZERO = ("rod", "inertia")
_TINY = 1e-300


@dataclass(frozen=True)
class CatalogueCylinder:
    """A cylinder of a catalogue. NaN where the catalogue says nothing.

    Attributes:
        name: its name.
        bore: diameter of the piston [m].
        rod: diameter of the rod [m].
        stroke: way of the piston [m].
        retracted: distance of its pins with the rod in [m].
        pressure: the highest pressure [Pa].
        speed: the highest speed of the rod [m/s].
        modulus: of elasticity of the rod [Pa].
        length: length that may buckle [m]; where it is left out, the distance of the pins.
        mass: [kg].
    """

    name: str
    bore: float
    rod: float
    stroke: float
    retracted: float = math.nan
    pressure: float = math.nan
    speed: float = math.nan
    modulus: float = math.nan
    length: float = math.nan
    mass: float = math.nan

    @property
    def size(self) -> tuple[float, ...]:
        """What orders cylinders."""
        return self.bore, self.rod, self.stroke


@dataclass(frozen=True)
class CatalogueMotor:
    """A motor of a catalogue, with its gear or screw. NaN where the catalogue says nothing.

    Attributes:
        name: its name.
        torque: torque that it gives without end, at its own shaft [N m].
        speed: the highest speed of its shaft [rad/s].
        peak_torque: torque that it gives for a short time [N m]; where it is left out, `torque`.
        power: the highest power [W].
        inertia: of its rotor, with gear and screw, at its shaft [kg m^2].
        gear_ratio: turns of its shaft for a turn of the gear's output.
        efficiency: of gear and screw.
        lead: way of a screw for each turn [m], for joints that slide.
        mass: [kg].
    """

    name: str
    torque: float
    speed: float
    peak_torque: float = math.nan
    power: float = math.nan
    inertia: float = 0.0
    gear_ratio: float = 1.0
    efficiency: float = 1.0
    lead: float = math.nan
    mass: float = math.nan

    @property
    def size(self) -> tuple[float, ...]:
        """What orders motors."""
        return (self.torque * self.speed,)


Kind = TypeVar("Kind", CatalogueCylinder, CatalogueMotor)


@dataclass(frozen=True)
class Catalogue:
    """The drives of a catalogue, the smallest first.

    The smallest has the least mass where every row has one. Otherwise it is the cylinder of the
    least bore, rod and stroke, or the motor of the least torque times speed.

    Attributes:
        rows: cylinders, or motors.
        source: name of the file, for messages.
    """

    rows: tuple[CatalogueCylinder, ...] | tuple[CatalogueMotor, ...]
    source: str


def read_catalogue(path: str | Path) -> Catalogue:
    """A catalogue from a CSV file.

    Cylinders have the columns `name`, `bore`, `rod` and `stroke`, motors `name`, `torque` and
    `speed`. The other columns are the attributes of `CatalogueCylinder` and `CatalogueMotor`. A
    header may name a unit, as `bore [mm]`.

    Raises:
        InputError: a column is missing or unknown, or a number is not above zero.
    """
    table = table_of(path, lambda _: [], texts=(NAME,))
    if NAME in table.texts and "bore" in table.columns:
        table = _checked(path, _CYLINDER_UNITS, _NEEDED_OF_CYLINDERS)
        cylinders = [CatalogueCylinder(**row) for row in _rows(table)]
        for k, cylinder in enumerate(cylinders):
            if cylinder.rod >= cylinder.bore:
                raise InputError(f"{table.row(k)}: the rod is not thinner than the bore")
        return Catalogue(_by_size(cylinders), str(path))
    if NAME in table.texts and "torque" in table.columns:
        table = _checked(path, _MOTOR_UNITS, _NEEDED_OF_MOTORS)
        motors = [CatalogueMotor(**row) for row in _rows(table)]
        for k, motor in enumerate(motors):
            if motor.efficiency > 1.0:
                raise InputError(f"{table.row(k)}: the efficiency is above 1")
        return Catalogue(_by_size(motors), str(path))
    raise InputError(
        f"{path}: columns {', '.join([*table.texts, *table.columns])}; expected name, bore, rod and"
        " stroke of cylinders, or name, torque and speed of motors"
    )


def _checked(path: str | Path, units: Mapping[str, str], needed: Sequence[str]) -> Table:
    """The table of a catalogue, with known columns of numbers above zero."""
    table = table_of(path, lambda name: [units[name]] if name in units else [], texts=(NAME,))
    for name in needed:
        if name not in table.columns:
            raise InputError(f"{path}: there is no column {name}")
    for name, values in table.columns.items():
        if name not in units:
            raise InputError(f"{path}: {no_such_name('column', name, units)}")
        for k, value in enumerate(values.tolist()):
            if math.isnan(value) and name not in needed:
                continue
            least = 0.0 if name in _MAY_BE_ZERO else _TINY
            if not value >= least:
                raise InputError(f"{table.row(k)}: {name} is {value:g}; expected more than zero")
    return table


def _rows(table: Table) -> list[dict[str, Any]]:
    """The rows by column, without empty cells."""
    names = table.texts[NAME]
    rows: list[dict[str, Any]] = []
    for k, name in enumerate(names):
        if not name:
            raise InputError(f"{table.row(k)}: the name is empty")
        if name in names[:k]:
            raise InputError(f"{table.row(k)}: the name {name} is given twice")
        row: dict[str, Any] = {NAME: name}
        for column, values in table.columns.items():
            if not math.isnan(values[k]):
                row[column] = float(values[k])
        rows.append(row)
    return rows


def _by_size(rows: list[Kind]) -> tuple[Kind, ...]:
    """The rows, the smallest first."""
    if any(math.isnan(row.mass) for row in rows):
        return tuple(sorted(rows, key=lambda row: row.size))
    return tuple(sorted(rows, key=lambda row: row.mass))
