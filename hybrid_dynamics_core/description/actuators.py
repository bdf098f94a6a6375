"""Actuators as immutable data: hydraulic cylinders, and drives that move several joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass


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
        supply_pressure: the highest available pressure.
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
