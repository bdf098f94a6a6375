"""The limited quantities of a machine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ..ground.units import coordinate_unit, effort_unit
from .machine import Machine


@dataclass(frozen=True)
class Row:
    """One limited quantity.

    Attributes:
        kind: position, rate, acceleration, effort, pressure, flow, power, pump_flow or pump_power.
        name: joint, drive or pump.
        words: beginning of a sentence that ends with the value.
        unit: unit of the value.
        lower: least value, minus infinity if none.
        upper: greatest value, infinity if none; the largest one if it varies.
        bound: name of the upper bound.
    """

    kind: str
    name: str
    words: str
    unit: str
    lower: float
    upper: float
    bound: str = "the limit"

    @property
    def is_limited(self) -> bool:
        """Whether it has a finite bound."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)


def rows_of(machine: Machine, drives: tuple[str, ...]) -> tuple[Row, ...]:
    """All quantities with a finite bound, those of one kind one after the other.

    Args:
        machine: the machine.
        drives: names of the drives whose forces are limited.
    """
    rows = [
        *_positions(machine),
        *_rates(machine),
        *_accelerations(machine),
        *_efforts(machine, drives),
        *_pressures(machine),
        *_flows(machine),
        *_powers(machine, drives),
        *_pump_flows(machine),
        *_pump_powers(machine),
    ]
    return tuple(row for row in rows if row.is_limited)


def _positions(machine: Machine) -> Iterator[Row]:
    joints = machine.description.joints
    count = len(machine.active)
    for k, name in enumerate(machine.coordinates):
        lower, upper = joints[name].limits
        if k < count:
            lower, upper = machine.limits[k].tolist()
        unit = coordinate_unit(machine.joint_types[name])
        yield Row("position", name, f"{name} is", unit, lower, upper)


def _rates(machine: Machine) -> Iterator[Row]:
    joints = machine.description.joints
    for name, joint_type in machine.joint_types.items():
        most = joints[name].velocity_limit
        unit = coordinate_unit(joint_type, "/s")
        yield Row("rate", name, f"{name} moves at", unit, -most, most)


def _accelerations(machine: Machine) -> Iterator[Row]:
    joints = machine.description.joints
    for name, joint_type in machine.joint_types.items():
        most = joints[name].acceleration_limit
        unit = coordinate_unit(joint_type, "/s^2")
        yield Row("acceleration", name, f"{name} accelerates by", unit, -most, most)


def _efforts(machine: Machine, drives: tuple[str, ...]) -> Iterator[Row]:
    joints = machine.description.joints
    transmissions = machine.description.transmissions
    for name in drives:
        unit = "N m or N"
        if name in joints:
            most = joints[name].effort_limit
            unit = effort_unit(machine.joint_types[name])
        else:
            most = transmissions[name].effort_limit
        yield Row("effort", name, f"{name} needs", unit, -most, most)


def _pressures(machine: Machine) -> Iterator[Row]:
    for name, cylinder in machine.description.actuators.items():
        bound = "its supply"
        if cylinder.relief_pressure < cylinder.supply_pressure:
            bound = "its relief valve"
        words = f"the cylinder of {name} needs"
        most = cylinder.highest_pressure
        yield Row(
            "pressure",
            name,
            words,
            "Pa",
            -math.inf,
            most,
            bound,
        )


def _flows(machine: Machine) -> Iterator[Row]:
    for name, cylinder in machine.description.actuators.items():
        words = f"the cylinder of {name} takes"
        most = cylinder.flow_limit
        yield Row("flow", name, words, "m^3/s", -math.inf, most)


def _powers(machine: Machine, drives: tuple[str, ...]) -> Iterator[Row]:
    joints = machine.description.joints
    for name in drives:
        if name not in joints:
            continue
        words = f"the drive of {name} has a power of"
        most = joints[name].power_limit
        yield Row("power", name, words, "W", -most, most)


def _pump_flows(machine: Machine) -> Iterator[Row]:
    for name, pump in machine.description.pumps.items():
        words = f"the pump '{name}' gives a flow of"
        yield Row(
            "pump_flow",
            name,
            words,
            "m^3/s",
            -math.inf,
            pump.flow_limit,
        )


def _pump_powers(machine: Machine) -> Iterator[Row]:
    for name, pump in machine.description.pumps.items():
        words = f"the pump '{name}' gives a power of"
        yield Row(
            "pump_power",
            name,
            words,
            "W",
            -math.inf,
            pump.power_limit,
        )
