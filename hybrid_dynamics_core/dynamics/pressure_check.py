"""Measured pressures that a hydraulic cylinder cannot have, or that fit its motion badly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ..description.actuators import HydraulicCylinder

HIGHEST: Final = 1e8  # [Pa] above any hydraulic system
PEAK: Final = 1.5  # times the highest pressure of the supply, up to which there are peaks at stops
VACUUM: Final = -2e5  # [Pa] gauge, below any vacuum
FAINT: Final = 1000.0  # [Pa] below which numbers are rather in bar
BETTER: Final = 0.25  # share of the squares: exchanged chambers that leave less fit better
SLACK: Final = 0.01  # share of the highest pressure: errors of sensors and valves
PEAKS: Final = 0.1  # share of the samples that may be peaks at stops
BAR: Final = 1e5  # [Pa]


def pressure_problem(cylinder: HydraulicCylinder, least: float, most: float) -> str:
    """What is wrong with the least and the highest gauge pressure [Pa] of a cylinder; or empty."""
    if least < VACUUM:
        return f"{least:.4g} Pa, below a vacuum; expected gauge Pa"
    if most > min(HIGHEST, PEAK * cylinder.highest_pressure):
        return f"{most:.4g} Pa, and its {_source(cylinder)} has {cylinder.highest_pressure:.4g} Pa"
    return ""


def is_faint(*pressures: float) -> bool:
    """Whether gauge pressures are so low that they are rather in bar; not if all are zero."""
    return 0.0 < max(pressures) < FAINT


def is_above(cylinder: HydraulicCylinder, pressures: ArrayLike) -> np.ndarray:
    """Whether pressures (...) [Pa] exceed both noise and what supply and relief valve allow."""
    return np.asarray(pressures) > (1.0 + SLACK) * cylinder.highest_pressure


def excess(cylinder: HydraulicCylinder, pressures: ArrayLike) -> str:
    """A text on pressures (...) [Pa] that stay above the supply or relief pressure; or empty.

    A tenth of the samples may be peaks at stops.
    """
    values = np.atleast_1d(pressures)
    if np.mean(is_above(cylinder, values)) <= PEAKS:
        return ""
    return excess_text(cylinder, float(values.max()))


def excess_text(cylinder: HydraulicCylinder, most: float) -> str:
    """A text on a pressure [Pa] above the supply or relief pressure of a cylinder."""
    highest = cylinder.highest_pressure / BAR
    return (
        f"{cylinder.joint}: a measured pressure of {most / BAR:.4g} bar, {most / BAR - highest:.4g}"
        f" bar beyond its {_source(cylinder)} of {highest:.4g} bar"
    )


def fits_exchanged(given: ArrayLike, exchanged: ArrayLike) -> np.ndarray:
    """Whether squares (...) that pressures leave say that their chambers are exchanged.

    An unknown load or friction does not look like exchanged chambers: these turn the sign of the
    force of the fuller side.

    Args:
        given: squares (...) of measured less required forces.
        exchanged: the same if cap and rod side are exchanged.
    """
    return np.asarray(exchanged) < BETTER * np.asarray(given)


def exchanged_text(cylinders: Sequence[str]) -> str:
    """A text on cylinders whose chambers seem to be exchanged."""
    return (
        f"{', '.join(cylinders)}: pressures fit the motion better with cap and rod side exchanged"
    )


def _source(cylinder: HydraulicCylinder) -> str:
    """What limits the pressure of a cylinder."""
    return "relief valve" if cylinder.relief_pressure < cylinder.supply_pressure else "supply"
