"""Units of coordinates and efforts, by the type of a joint."""

from __future__ import annotations


def coordinate_unit(joint_type: str, rate: str = "") -> str:
    """Unit of a joint's coordinate, or with `rate` of its rates: `/s`, `/s^2`."""
    if joint_type == "revolute":
        return f"rad{rate}"
    return f"m{rate}"


def effort_unit(joint_type: str) -> str:
    """Unit of the effort along a joint's coordinate."""
    if joint_type == "revolute":
        return "N m"
    return "N"
