"""Limits of drives, cylinders and pumps as plain data and as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hybrid_dynamics_core.description.model import Joint, RobotDescription
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit

from .output import number, plain, table

BOUNDS = (
    "effort_limit",
    "velocity_limit",
    "power_limit",
    "acceleration_limit",
)
CYLINDER = {  # attributes: heads of their columns
    "bore": "bore [m]",
    "rod": "rod [m]",
    "count": "number",
    "supply_pressure": "supply [Pa]",
    "relief_pressure": "relief [Pa]",
    "flow_limit": "flow [m^3/s]",
}
PUMP = {
    "flow_limit": "flow [m^3/s]",
    "power_limit": "power [W]",
}


def joint_facts(joint: Joint) -> dict[str, Any]:
    """Limits of the drive of a joint in SI units; None where there is none.

    `effort_table` has `rate` (k,), `position` (m,) and `effort` (m, k).
    """
    facts: dict[str, Any] = {}
    for key in BOUNDS:
        facts[key] = plain(getattr(joint, key))
    facts["effort_table"] = None
    given = joint.effort_table
    if given is not None:
        facts["effort_table"] = {
            "rate": plain(given.rates),
            "position": plain(given.positions),
            "effort": plain(given.efforts),
        }
    return facts


def hydraulic_facts(description: RobotDescription) -> dict[str, Any]:
    """Sizes and limits of `cylinders` and `pumps` by name, in SI units; None where unlimited."""
    cylinders: dict[str, Any] = {}
    for name, cylinder in description.actuators.items():
        entry = _attributes(cylinder, CYLINDER)
        entry["stroke"] = plain(cylinder.stroke)
        cylinders[name] = entry
    pumps: dict[str, Any] = {}
    for name, pump in description.pumps.items():
        entry = _attributes(pump, PUMP)
        entry["cylinders"] = list(pump.cylinders)
        pumps[name] = entry
    return {
        "cylinders": cylinders,
        "pumps": pumps,
    }


def _attributes(part: object, names: Mapping[str, str]) -> dict[str, Any]:
    """Attributes of a part as plain data."""
    entry: dict[str, Any] = {}
    for name in names:
        entry[name] = plain(getattr(part, name))
    return entry


def limit_tables(
    coordinates: Sequence[Mapping[str, Any]],
    facts: Mapping[str, Any],
) -> list[str]:
    """Tables of the limits that drives, cylinders and pumps have, each after an empty line.

    Args:
        coordinates: entries with `name`, `type` and the data of `joint_facts`.
        facts: `cylinders` and `pumps`, as `hydraulic_facts` gives them.
    """
    tables = _strengths(coordinates)
    tables += _accelerations(coordinates)
    cylinders: list[list[object]] = []
    for name, entry in facts["cylinders"].items():
        cylinders.append(_row(name, entry, CYLINDER))
    tables += _table(["cylinder", *CYLINDER.values()], cylinders)
    pumps: list[list[object]] = []
    for name, entry in facts["pumps"].items():
        row = _row(name, entry, PUMP)
        row.append(", ".join(entry["cylinders"]))
        pumps.append(row)
    heads = ["pump", *PUMP.values(), "cylinders"]
    return tables + _table(heads, pumps)


def _strengths(coordinates: Sequence[Mapping[str, Any]]) -> list[str]:
    """A table of largest efforts and rates, and notes on tables of efforts."""
    rows: list[list[object]] = []
    notes: list[str] = []
    for entry in coordinates:
        name, kind = entry["name"], entry["type"]
        effort = limit_text(entry["effort_limit"])
        rate = limit_text(entry["velocity_limit"])
        if (effort, rate) != ("-", "-"):
            unit = coordinate_unit(kind, "/s")
            rows.append([name, effort, effort_unit(kind), rate, unit])
        if entry["effort_table"] is not None:
            notes.append(f"{name}: its largest effort is less at other rates or positions")
    heads = ["coordinate", "largest effort", "", "largest rate", ""]
    return _table(heads, rows) + notes


def _accelerations(coordinates: Sequence[Mapping[str, Any]]) -> list[str]:
    """A table of largest accelerations and powers."""
    rows: list[list[object]] = []
    for entry in coordinates:
        acceleration = limit_text(entry["acceleration_limit"])
        power = limit_text(entry["power_limit"])
        if (acceleration, power) != ("-", "-"):
            unit = coordinate_unit(entry["type"], "/s^2")
            rows.append([entry["name"], acceleration, unit, power, "W"])
    heads = ["coordinate", "largest acceleration", "", "largest power", ""]
    return _table(heads, rows)


def _row(name: str, entry: Mapping[str, Any], keys: Mapping[str, str]) -> list[object]:
    """A name and some values of an entry."""
    return [name, *(limit_text(entry[key]) for key in keys)]


def limit_text(value: float | None) -> str:
    """A limit as text; a dash without one."""
    if value is None:
        return "-"
    return number(value)


def _table(heads: list[str], rows: list[list[object]]) -> list[str]:
    """An empty line and a table; nothing without rows."""
    if not rows:
        return []
    return ["", table(heads, rows)]
