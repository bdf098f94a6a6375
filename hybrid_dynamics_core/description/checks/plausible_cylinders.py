"""Warnings of cylinders whose sizes are likely in millimetres, or pressures in bar."""

from __future__ import annotations

import math

from ..actuators import HydraulicCylinder
from ..document import Document
from ..model import RobotDescription

# The largest forging presses have pistons of 2 m. In robots a bore is far below the reach.
_LARGEST_BORE = 3.0  # [m]
_WIDE_BORE = 0.5  # [m] a smaller bore may exceed the reach of a small robot
# Pneumatics and water hydraulics begin at about a bar; a vacuum gripper is no cylinder.
_LEAST_SUPPLY = 1e4  # [Pa]
_MOST_SUPPLY = 1e9  # [Pa] strength of steel
_LONG_STROKE = 40.0  # [m]
_STROKE_RATIO = 20.0  # largest ratio of a stroke to the reach


def warn_of_cylinders(document: Document, robot: RobotDescription, reach: float) -> None:
    """Warn of bores, rods and strokes in millimetres, and of pressures in bar.

    Args:
        document: collects the warnings.
        robot: the description to check.
        reach: reach of the robot from its base [m].
    """
    for joint, cylinder in robot.actuators.items():
        for key in ("bore", "rod"):
            _warn_of_diameter(document, joint, key, getattr(cylinder, key), reach)
        _warn_of_stroke(document, joint, cylinder, reach)
        unlikely = False
        for key in ("supply_pressure", "relief_pressure"):
            pressure = getattr(cylinder, key)
            if pressure < _LEAST_SUPPLY or _MOST_SUPPLY < pressure < math.inf:
                _warn_of_pressure(document, joint, key, pressure)
                unlikely = True
        if not unlikely and 0.0 < cylinder.return_pressure < 1e-2 * _LEAST_SUPPLY:
            _warn_of_pressure(document, joint, "return_pressure", cylinder.return_pressure)


def _warn_of_diameter(
    document: Document, joint: str, key: str, diameter: float, reach: float
) -> None:
    is_wide = diameter > _WIDE_BORE and diameter > reach > 0.0
    if diameter <= _LARGEST_BORE and not is_wide:
        return
    document.warn(
        ("actuators", joint, key),
        f"{diameter:g} m, and the robot reaches {reach:.4g} m from its base: are these millimetres?"
        f" {diameter:g} mm are written {diameter:g}*mm or {diameter / 1000.0:g}",
    )


def _warn_of_stroke(
    document: Document, joint: str, cylinder: HydraulicCylinder, reach: float
) -> None:
    ends = [abs(end) for end in cylinder.stroke if math.isfinite(end)]
    end = max(ends, default=0.0)
    if end < _LONG_STROKE or end <= _STROKE_RATIO * reach:
        return
    document.warn(
        ("actuators", joint, "stroke"),
        f"{end:g} m, and the robot reaches {reach:.4g} m from its base: are these millimetres?"
        f" {end:g} mm are written {end:g}*mm or {end / 1000.0:g}",
    )


def _warn_of_pressure(document: Document, joint: str, key: str, pressure: float) -> None:
    document.warn(
        ("actuators", joint, key),
        f"{pressure:g} Pa, which no cylinder has: are these bar? {pressure:g} bar are written"
        f" {pressure:g}*bar or {pressure * 1e5:g}",
    )
