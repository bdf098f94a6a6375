"""The limited quantities of a robot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ..ground.units import coordinate_unit, effort_unit
from .robot_interfaces import LimitedRobot


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


def rows_of(robot: LimitedRobot, drives: tuple[str, ...]) -> tuple[Row, ...]:
    """All quantities with a finite bound, those of one kind one after the other.

    Args:
        robot: the robot.
        drives: names of the drives whose forces are limited.
    """
    rows = [
        *_positions(robot),
        *_rates(robot),
        *_accelerations(robot),
        *_efforts(robot, drives),
        *_pressures(robot),
        *_flows(robot),
        *_powers(robot, drives),
        *_pump_flows(robot),
        *_pump_powers(robot),
    ]
    return tuple(row for row in rows if row.is_limited)


def _positions(robot: LimitedRobot) -> Iterator[Row]:
    joints = robot.description.joints
    count = len(robot.active)
    for k, name in enumerate(robot.coordinates):
        lower, upper = joints[name].limits
        if k < count:
            lower, upper = robot.limits[k].tolist()
        unit = coordinate_unit(robot.joint_types[name])
        yield Row("position", name, f"{name} is", unit, lower, upper)


def _rates(robot: LimitedRobot) -> Iterator[Row]:
    joints = robot.description.joints
    for name, joint_type in robot.joint_types.items():
        most = joints[name].velocity_limit
        unit = coordinate_unit(joint_type, "/s")
        yield Row("rate", name, f"{name} moves at", unit, -most, most)


def _accelerations(robot: LimitedRobot) -> Iterator[Row]:
    joints = robot.description.joints
    for name, joint_type in robot.joint_types.items():
        most = joints[name].acceleration_limit
        unit = coordinate_unit(joint_type, "/s^2")
        yield Row("acceleration", name, f"{name} accelerates by", unit, -most, most)


def _efforts(robot: LimitedRobot, drives: tuple[str, ...]) -> Iterator[Row]:
    joints = robot.description.joints
    transmissions = robot.description.transmissions
    for name in drives:
        unit = "N m or N"
        if name in joints:
            most = joints[name].effort_limit
            unit = effort_unit(robot.joint_types[name])
        else:
            most = transmissions[name].effort_limit
        yield Row("effort", name, f"{name} needs", unit, -most, most)


def _pressures(robot: LimitedRobot) -> Iterator[Row]:
    for name, cylinder in robot.description.actuators.items():
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


def _flows(robot: LimitedRobot) -> Iterator[Row]:
    for name, cylinder in robot.description.actuators.items():
        words = f"the cylinder of {name} takes"
        most = cylinder.flow_limit
        yield Row("flow", name, words, "m^3/s", -math.inf, most)


def _powers(robot: LimitedRobot, drives: tuple[str, ...]) -> Iterator[Row]:
    joints = robot.description.joints
    for name in drives:
        if name not in joints:
            continue
        words = f"the drive of {name} has a power of"
        most = joints[name].power_limit
        yield Row("power", name, words, "W", -most, most)


def _pump_flows(robot: LimitedRobot) -> Iterator[Row]:
    for name, pump in robot.description.pumps.items():
        words = f"the pump '{name}' gives a flow of"
        yield Row(
            "pump_flow",
            name,
            words,
            "m^3/s",
            -math.inf,
            pump.flow_limit,
        )


def _pump_powers(robot: LimitedRobot) -> Iterator[Row]:
    for name, pump in robot.description.pumps.items():
        words = f"the pump '{name}' gives a power of"
        yield Row(
            "pump_power",
            name,
            words,
            "W",
            -math.inf,
            pump.power_limit,
        )
