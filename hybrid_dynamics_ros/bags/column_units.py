"""Units in names of columns: `q12 [mm]`, `time [ms]`, `q1.velocity [deg/s]`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.expressions import evaluate
from hybrid_dynamics_core.formats.tables import unit_term
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit

from ..messages.joint_samples import FloatArray
from .errors import BagError

WITH_UNIT: Final = re.compile(r"(.*\S)\s*[\[(]([^\[\]()]+)[\])]")  # name and unit in brackets
_RATES: Final = {"velocity": "/s", "rate": "/s", "acceleration": "/s^2"}
_PRESSURES: Final = {"cap_pressure": "Pa", "rod_pressure": "Pa"}

Columns = dict[str, FloatArray]


def in_si_units(path: Path, columns: Columns, robot: Robot) -> Columns:
    """Columns in SI units, with units removed from their names.

    Columns that are neither times nor of a joint are not changed.

    Raises:
        BagError: a unit is unknown or of another quantity, or a name is duplicate.
    """
    converted: Columns = {}
    for head, values in columns.items():
        match = WITH_UNIT.fullmatch(head)
        name = match[1] if match else head
        expected = _unit_of(name, robot)
        if match is None or not expected or head in robot.coordinates:
            name = head
        else:
            values = values * unit_factor(path, head, match[2], expected)  # noqa: PLW2901
        if name in converted:
            raise BagError(f"{path}: two columns are called {name}")
        converted[name] = values
    return converted


def _unit_of(name: str, robot: Robot) -> str:
    """The SI unit of a column; empty if it is neither a time nor of a joint."""
    if name in {"time", "t"}:
        return "s"
    joint, _, part = name.rpartition(".")
    if name in robot.joint_types:
        return coordinate_unit(robot.joint_types[name])
    if joint not in robot.joint_types:
        return ""
    forces = {"effort": effort_unit(robot.joint_types[joint]), **_PRESSURES}
    if part in forces:
        return forces[part]
    if part in _RATES:
        return coordinate_unit(robot.joint_types[joint], _RATES[part])
    return ""


def unit_factor(path: Path, head: str, unit: str, expected: str) -> float:
    """The factor from a unit to SI; raises BagError."""
    try:
        return evaluate(unit_term(unit), {}, names_are="", units=[expected])
    except (ValueError, ArithmeticError) as error:
        raise BagError(
            f"{path}: column '{head}': {error}; expected a unit as {expected}"
        ) from error
