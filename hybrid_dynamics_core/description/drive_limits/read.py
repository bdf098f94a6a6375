"""Readers for tables of efforts and for pumps of a description file."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ...ground.arrays import Array, frozen
from ...ground.suggestions import no_such_name
from ..actuators import EffortTable, Pump
from ..entries import Entry, section_entries
from ..values import ValueReader


def read_effort_table(entry: Entry) -> EffortTable | None:
    """The table of an entry; None if it is empty.

    Args:
        entry: entry with `rate`, `effort` and perhaps `position`.

    Raises:
        DescriptionError: rates or positions do not ascend, an effort is negative, all are zero, or
            a row has another length than the rates.
    """
    if not entry.data:
        return None
    rates = _ascending(entry, "rate")
    if rates[0] < 0.0:
        raise entry.error("rate", f"begins with {rates[0]:g}; expected sizes of rates, from 0 up")
    if "position" not in entry:
        row = _row(entry, entry["effort"], len(rates), None)
        return EffortTable(rates, frozen([0.0]), frozen([row]))
    positions = _ascending(entry, "position")
    rows = entry["effort"]
    if len(rows) != len(positions):
        problem = f"has {len(rows)} rows; expected one for each of {len(positions)} positions"
        raise entry.error("effort", problem)
    efforts = [_row(entry, row, len(rates), k) for k, row in enumerate(rows)]
    return EffortTable(rates, positions, frozen(efforts))


def read_pumps(values: ValueReader) -> Mapping[str, Pump]:
    """Pumps that feed several cylinders.

    Args:
        values: reader of the values of a validated document.

    Returns:
        Pumps by name.

    Raises:
        DescriptionError: a cylinder is not there, or has two pumps.
    """
    pumps: dict[str, Pump] = {}
    cylinders = values.document.entries("actuators")
    fed: dict[str, str] = {}
    for name, entry in section_entries(values, "pumps").items():
        for joint in entry["cylinders"]:
            if joint not in cylinders:
                raise entry.error("cylinders", no_such_name("cylinder", joint, cylinders))
            if joint in fed:
                problem = f"'{joint}' is fed by '{fed[joint]}' already; expected one pump for each"
                raise entry.error("cylinders", problem)
            fed[joint] = name
        flow, power = entry.bound("flow_limit"), entry.bound("power_limit")
        _warn_of_flow(values, entry, flow)
        pumps[name] = Pump(tuple(entry["cylinders"]), flow, power)
    return MappingProxyType(pumps)


_LARGE_FLOW = 1.0  # [m^3/s] 60 000 l/min


def _warn_of_flow(values: ValueReader, entry: Entry, flow: float) -> None:
    """Warn of a flow in litres a minute."""
    if _LARGE_FLOW < flow < np.inf:
        litres = f"{flow:g} l/min are written {flow:g}e-3/60"
        problem = f"{flow:g} m^3/s, which no pump gives: are these l/min? {litres}"
        values.document.warn(entry.key_path("flow_limit"), problem)


def _ascending(entry: Entry, key: str) -> Array:
    """An ascending list of numbers."""
    numbers = entry.vector(key)
    if not (np.diff(numbers) > 0.0).all():
        raise entry.error(key, f"is {numbers.tolist()}; expected ascending numbers")
    return numbers


def _row(entry: Entry, row: Any, count: int, number: int | None) -> Array:
    """Efforts (count,) of a row [N m, N].

    Args:
        entry: the table.
        row: what is written.
        count: number of rates.
        number: its place among rows; None if it is the only one.
    """
    path = entry.key_path("effort")
    where = ""
    if number is not None:
        path, where = (*path, number), f"row {number + 1} "
    nested = isinstance(row, list) and any(isinstance(item, list) for item in row)
    if nested or not isinstance(row, list):
        problem = "has rows but no `position`; expected a number for each rate"
        if number is not None:
            problem = f"{where}is no list of numbers; expected a number for each rate"
        raise entry.error("effort", problem)
    if len(row) != count:
        raise entry.error("effort", f"{where}has {len(row)} numbers; expected {count}, one a rate")
    efforts = entry.values.vector(row, path)
    if efforts.min() < 0.0 or not efforts.max() > 0.0:
        raise entry.error("effort", f"{where}is {efforts.tolist()}; expected sizes of efforts")
    return efforts
