"""What code and units for other programs leave out of the limits of drives."""

from __future__ import annotations

import math
from collections.abc import Collection

from ...description.model import RobotDescription
from .names import comment

RATES, EFFORTS = "rates", "efforts and pressures"
TABLES = "efforts over rate and position"
OTHERS = ("accelerations", "powers", TABLES, "flows", "pumps")


def limits_not_exported(description: RobotDescription, exported: Collection[str] = ()) -> str:
    """A sentence on limits of drives that are left out; empty if there are none.

    Args:
        description: the robot.
        exported: RATES and EFFORTS, if they are not left out.
    """
    parts: list[str] = []
    for kind, names in _limited(description).items():
        if names and kind not in exported:
            listed = ", ".join(map(comment, names))
            parts.append(f"{kind} ({listed})")
    if not parts:
        return ""
    return f"Limits of drives that are not exported: {'; '.join(parts)}."


def _limited(description: RobotDescription) -> dict[str, list[str]]:
    """Names of what is limited, by kind of limit."""
    names: dict[str, list[str]] = {}
    for kind in (RATES, EFFORTS, *OTHERS):
        names[kind] = []
    for name, joint in description.joints.items():
        bounds = {
            RATES: joint.velocity_limit,
            EFFORTS: _largest_effort(description, name),
            "accelerations": joint.acceleration_limit,
            "powers": joint.power_limit,
        }
        for kind, bound in bounds.items():
            if math.isfinite(bound):
                names[kind].append(name)
        if joint.effort_table is not None:
            names[TABLES].append(name)
    for name, cylinder in description.actuators.items():
        if math.isfinite(cylinder.flow_limit):
            names["flows"].append(name)
    names["pumps"].extend(description.pumps)
    return names


def _largest_effort(description: RobotDescription, name: str) -> float:
    """The largest effort of a joint, or the largest pressure of its cylinder; finite if limited."""
    effort = description.joints[name].effort_limit
    cylinder = description.actuators.get(name)
    if cylinder is None:
        return effort
    return min(effort, cylinder.highest_pressure)
