"""Actuators as immutable data: cylinders, pumps, and drives that move several joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..ground.arrays import Array


@dataclass(frozen=True, eq=False)
class EffortTable:
    """Largest effort of a drive over its rate and position, both directions alike.

    Between entries it is linear, beyond them constant.

    Attributes:
        rates: (k,) sizes of the rate, ascending [rad/s, m/s].
        positions: (m,) ascending [rad, m]; one number where the position does not matter.
        efforts: (m, k) [N m, N].
    """

    rates: Array
    positions: Array
    efforts: Array

    @property
    def largest(self) -> float:
        """The largest entry [N m, N]."""
        return float(self.efforts.max())

    def at(self, position: ArrayLike, rate: ArrayLike) -> Array:
        """Largest efforts (...) at positions (...) and rates (...)."""
        row, along = _place(self.positions, np.asarray(position, dtype=float))
        column, across = _place(self.rates, np.abs(rate))
        next_row = np.minimum(row + 1, len(self.positions) - 1)
        next_column = np.minimum(column + 1, len(self.rates) - 1)
        slow = (1.0 - along) * self.efforts[row, column] + along * self.efforts[next_row, column]
        fast = (1.0 - along) * self.efforts[row, next_column]
        fast = fast + along * self.efforts[next_row, next_column]
        return np.asarray((1.0 - across) * slow + across * fast)


def _place(ends: Array, values: Array) -> tuple[np.ndarray, Array]:
    """Index of the entry below each value, and its share of the way to the next one."""
    index = np.searchsorted(ends, values, side="right") - 1
    index = np.clip(index, 0, max(len(ends) - 2, 0))
    following = np.minimum(index + 1, len(ends) - 1)
    width = ends[following] - ends[index]
    share = (values - ends[index]) / np.where(width > 0.0, width, 1.0)
    return index, np.clip(np.where(width > 0.0, share, 0.0), 0.0, 1.0)


@dataclass(frozen=True)
class Pump:
    """A pump that feeds several cylinders.

    It gives one pressure: the highest that one of the filling chambers needs.

    Attributes:
        cylinders: joints of the cylinders that it feeds.
        flow_limit: largest flow into all of them together [m^3/s].
        power_limit: largest product of its pressure and its flow [W].
    """

    cylinders: tuple[str, ...]
    flow_limit: float = math.inf
    power_limit: float = math.inf


@dataclass(frozen=True)
class HydraulicCylinder:
    """One or several equal double-acting cylinders side by side on a prismatic joint.

    SI units, gauge pressures [Pa].

    Attributes:
        joint: name of the prismatic joint.
        bore: diameter of the piston [m].
        rod: diameter of the rod [m]; 0 for a cylinder of two equal areas.
        stroke: (lower, upper) value of the coordinate [m] with the piston at its two ends.
        sign: +1 where the coordinate grows as the cylinder extends, -1 where it shrinks.
        count: number of cylinders.
        return_pressure: pressure of the chamber that does not push.
        supply_pressure: the highest pressure of the supply.
        relief_pressure: pressure at which the relief valve opens.
        flow_limit: largest flow into the chamber that fills [m^3/s].
    """

    joint: str
    bore: float
    rod: float
    stroke: tuple[float, float] = (-math.inf, math.inf)
    sign: float = 1.0
    count: int = 1
    return_pressure: float = 0.0
    supply_pressure: float = math.inf
    relief_pressure: float = math.inf
    flow_limit: float = math.inf

    @property
    def highest_pressure(self) -> float:
        """The lower one of supply pressure and relief pressure [Pa]."""
        return min(self.supply_pressure, self.relief_pressure)

    @property
    def cap_area(self) -> float:
        """Area on which the pressure of the cap side acts [m^2]. It pushes outward."""
        return self.count * math.pi / 4.0 * self.bore**2

    @property
    def rod_area(self) -> float:
        """Area on which the pressure of the rod side acts [m^2]. It pulls inward."""
        squares = self.bore**2 - self.rod**2
        return self.count * math.pi / 4.0 * squares


@dataclass(frozen=True)
class Transmission:
    """A drive that moves several joints together, as those of a differential do.

    Its coordinate is a sum of multiplier * coordinate of each joint, plus the offset. So a force f
    of it acts as multiplier * f along each joint.

    Attributes:
        multipliers: rate of the drive over rate of each joint, by name.
        offset: its coordinate with the joints at zero [rad or m].
        effort_limit: its largest force [N] or torque [N m].
    """

    multipliers: Mapping[str, float]
    offset: float = 0.0
    effort_limit: float = math.inf
