"""Stiffness of a locked drive at a position of its joint."""

from __future__ import annotations

import math

from ..description.actuators import HydraulicCylinder
from ..description.elasticity import Belt, DriveStiffness, OilColumn
from ..errors import InputError

BEYOND = 1e-9  # of a stroke, by which a piston may be beyond it by rounding


class PistonError(InputError):
    """A piston is beyond its stroke at a state."""


def drive_compliance(
    name: str,
    drive: DriveStiffness,
    position: float,
    cylinder: HydraulicCylinder | None,
    *,
    turns: bool,
) -> float:
    """Deformation of a locked drive per unit of effort [rad/(N m), m/N]; 0 if it is rigid.

    Args:
        name: name of the drive, for messages.
        drive: its springs, which act in series.
        position: coordinate of its joint [rad, m].
        cylinder: cylinder on the joint; None if there is none.
        turns: whether the joint is revolute.

    Raises:
        InputError: oil without a cylinder, a piston beyond its stroke, or a belt without a
            radius on a revolute joint.
    """
    compliance = 1.0 / drive.stiffness
    if drive.oil is not None:
        if cylinder is None:
            raise InputError(
                f"drives.{name}: has oil but no cylinder; expected a joint with an entry in"
                " `actuators`"
            )
        compliance += 1.0 / oil_stiffness(drive.oil, cylinder, position)
    if drive.belt is not None:
        compliance += 1.0 / _belt_stiffness(name, drive.belt, turns=turns)
    return compliance


def oil_stiffness(oil: OilColumn, cylinder: HydraulicCylinder, position: float) -> float:
    """Axial stiffness of the oil locked into a cylinder [N/m].

    The sum of B A^2 / V over the locked chambers; Merritt (1967), Hydraulic Control Systems,
    Section 6-2. It is infinite where a chamber has no volume.

    Args:
        oil: the oil.
        cylinder: the cylinders that hold it.
        position: coordinate of the joint [m].

    Raises:
        PistonError: the piston is beyond its stroke.
        InputError: the cylinder has no stroke.
    """
    lower, upper = cylinder.stroke
    if not math.isfinite(upper - lower):
        raise InputError(
            f"drives.{cylinder.joint}: oil needs the stroke of the cylinder; give it in `actuators`"
        )
    piston = position - lower if cylinder.sign > 0.0 else upper - position
    free = upper - lower - piston
    slack = BEYOND * (upper - lower)
    if min(piston, free) < -slack:
        raise PistonError(
            f"drives.{cylinder.joint}: at {position:g} m the piston is beyond its stroke, {lower:g}"
            f" to {upper:g} m, so its oil has no volume"
        )
    chambers = (
        ("cap", cylinder.cap_area, piston),
        ("rod", cylinder.rod_area, free),
    )
    total = 0.0
    for dead, (side, area, length) in zip(oil.dead_volume, chambers, strict=True):
        volume = cylinder.count * dead + area * max(length, 0.0)
        if oil.chambers not in (side, "both"):
            continue
        if volume <= 0.0:
            return math.inf
        total += oil.bulk_modulus * area**2 / volume
    return total


def _belt_stiffness(name: str, belt: Belt, *, turns: bool) -> float:
    """Stiffness of a belt at its joint [N m/rad, N/m]."""
    if belt.radius is None and turns:
        raise InputError(
            f"drives.{name}: the belt turns a joint; give the radius of its pulley on the joint"
        )
    if belt.radius is not None and not turns:
        raise InputError(f"drives.{name}: a radius is of a revolute joint; this one is prismatic")
    return belt.along * (belt.radius or 1.0) ** 2
