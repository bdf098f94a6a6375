"""Pressures that a hydraulic cylinder cannot have, as numbers in another unit."""

from __future__ import annotations

from typing import Final

from ..description.actuators import HydraulicCylinder

HIGHEST: Final = 1e8  # [Pa] above any hydraulic system
PEAK: Final = 1.5  # times the supply pressure, up to which there are peaks at stops
VACUUM: Final = -2e5  # [Pa] gauge, below any vacuum
FAINT: Final = 1000.0  # [Pa] below which numbers are rather in bar


def pressure_problem(cylinder: HydraulicCylinder, least: float, most: float) -> str:
    """What is wrong with the least and the highest gauge pressure [Pa] of a cylinder; or empty."""
    supply = cylinder.supply_pressure
    if least < VACUUM:
        return f"{least:.4g} Pa, below a vacuum; expected gauge Pa"
    if most > min(HIGHEST, PEAK * supply):
        return f"{most:.4g} Pa, and its supply has {supply:.4g} Pa"
    return ""


def is_faint(*pressures: float) -> bool:
    """Whether gauge pressures are so low that they are rather in bar; not if all are zero."""
    return 0.0 < max(pressures) < FAINT
