"""Actuators that a description gives: hydraulic cylinders."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

Path_ = tuple[str | int, ...]
Number = Callable[[Any, Path_], float]


@dataclass(frozen=True)
class HydraulicCylinder:
    """One or several equal double-acting cylinders side by side on a prismatic joint. SI units, gauge pressures [Pa].

    `bore`, `rod`: diameters [m], rod 0 for one of two equal areas; `stroke`: (lower, upper) value
    of the joint's coordinate [m] with the piston at its two ends; `sign`: +1 where the coordinate
    grows as the cylinder extends, -1 where it shrinks; `return_pressure`: what the chamber that
    does not push is at; `supply_pressure`: the highest pressure there is.
    """

    joint: str
    bore: float
    rod: float
    stroke: tuple[float, float] = (-math.inf, math.inf)
    sign: float = 1.0
    count: int = 1
    return_pressure: float = 0.0
    supply_pressure: float = math.inf

    @property
    def cap_area(self) -> float:
        """Area on which the pressure of the cap side acts [m^2]: it pushes outward."""
        return self.count * math.pi / 4.0 * self.bore**2

    @property
    def rod_area(self) -> float:
        """Area on which the pressure of the rod side acts [m^2]: it pulls inward."""
        return self.count * math.pi / 4.0 * (self.bore**2 - self.rod**2)


def read_actuators(
    entries: Mapping[str, Any],
    joints: Mapping[str, Any],
    number: Number,
    error: Callable[[Path_, str], Exception],
) -> Mapping[str, HydraulicCylinder]:
    """Cylinders by joint from entries that the schema has checked."""
    found: dict[str, HydraulicCylinder] = {}
    for name, entry in entries.items():
        path: Path_ = ("actuators", name)
        if name not in joints:
            raise error(path, f"there is no joint '{name}'; an actuator has the name of its joint")
        if joints[name]["type"] != "prismatic":
            raise error(
                path,
                f"joint '{name}' is {joints[name]['type']}; a cylinder sits on a prismatic joint",
            )
        values: dict[str, Any] = {
            key: number(entry[key], (*path, key))
            for key in ("bore", "rod", "return_pressure", "supply_pressure")
            if key in entry
        }
        if "stroke" in entry:
            values["stroke"] = tuple(
                number(v, (*path, "stroke", k)) for k, v in enumerate(entry["stroke"])
            )
        cylinder = HydraulicCylinder(
            joint=name,
            sign=-1.0 if entry.get("pulls", False) else 1.0,
            count=entry.get("count", 1),
            **values,
        )
        _check(cylinder, path, error)
        found[name] = cylinder
    return MappingProxyType(found)


def _check(
    cylinder: HydraulicCylinder, path: Path_, error: Callable[[Path_, str], Exception]
) -> None:
    if not 0.0 <= cylinder.rod < cylinder.bore:
        problem = (
            f"is {cylinder.rod:g} m; expected zero up to less than the bore, {cylinder.bore:g} m"
        )
        raise error((*path, "rod"), problem)
    lower, upper = cylinder.stroke
    if not lower < upper:
        raise error(
            (*path, "stroke"), f"the lower end {lower:g} is not below the upper end {upper:g}"
        )
    if not 0.0 <= cylinder.return_pressure < cylinder.supply_pressure:
        problem = (
            f"{cylinder.return_pressure:g} Pa has to lie from zero to less than the supply pressure"
        )
        raise error((*path, "return_pressure"), problem)
