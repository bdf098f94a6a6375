"""Hydraulic cylinders: forces and chamber pressures, rates and flows, positions and the stroke that is left.

Two chambers push against each other, so a force has one equation for two pressures: the chamber
that does not push is taken to be at the cylinder's return pressure. Compressibility, leakage and
seal friction are left out (friction of the joint is a load of its own).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..description.actuators import HydraulicCylinder
from ..ground.arrays import Array


@dataclass(frozen=True, eq=False)
class CylinderState:
    """What one cylinder does; each a number, or (N,) for a batch. Gauge pressures.

    Attributes:
        force: [N] along the joint's coordinate.
        cap_pressure, rod_pressure: [Pa] in the two chambers.
        cap_flow, rod_flow: [m^3/s] of oil into each chamber, negative out of it.
        demand: [m^3/s] what the supply has to give: the flow into the chamber that fills.
        power: [W] that the oil brings in, force times rate.
        to_lower, to_upper: [m] left to the ends of the stroke, negative beyond them.
        overloaded: whether a chamber would have to be above the supply pressure.
    """

    force: Array
    cap_pressure: Array
    rod_pressure: Array
    cap_flow: Array
    rod_flow: Array
    demand: Array
    power: Array
    to_lower: Array
    to_upper: Array
    overloaded: np.ndarray


def cylinder_force(
    cylinder: HydraulicCylinder, cap_pressure: ArrayLike, rod_pressure: ArrayLike
) -> Array:
    """Force [N] along the joint's coordinate from the two chamber pressures [Pa]."""
    push = np.multiply(cap_pressure, cylinder.cap_area) - np.multiply(
        rod_pressure, cylinder.rod_area
    )
    return np.asarray(cylinder.sign * push)


def chamber_pressures(cylinder: HydraulicCylinder, force: ArrayLike) -> tuple[Array, Array]:
    """Pressures [Pa] of cap and rod side that give a force [N] along the joint, the idle one at return pressure."""
    push = cylinder.sign * np.asarray(force, dtype=float)
    rest = cylinder.return_pressure
    cap = (push + rest * cylinder.rod_area) / cylinder.cap_area
    rod = (rest * cylinder.cap_area - push) / cylinder.rod_area
    return np.maximum(cap, rest), np.maximum(rod, rest)


def chamber_flows(cylinder: HydraulicCylinder, rate: ArrayLike) -> tuple[Array, Array]:
    """Flows [m^3/s] into cap and rod side at a rate of the joint [m/s]."""
    out = cylinder.sign * np.asarray(rate, dtype=float)
    return out * cylinder.cap_area, -out * cylinder.rod_area


def force_range(cylinder: HydraulicCylinder) -> tuple[float, float]:
    """Least and greatest force [N] along the joint between return and supply pressure."""
    low, high = cylinder.return_pressure, cylinder.supply_pressure
    pull = low * cylinder.cap_area - high * cylinder.rod_area
    push = high * cylinder.cap_area - low * cylinder.rod_area
    return (pull, push) if cylinder.sign > 0.0 else (-push, -pull)


def cylinder_state(
    cylinder: HydraulicCylinder, position: Array, rate: Array, force: Array
) -> CylinderState:
    """Everything about a cylinder at its joint's coordinate [m], rate [m/s] and force [N]."""
    cap, rod = chamber_pressures(cylinder, force)
    cap_flow, rod_flow = chamber_flows(cylinder, rate)
    slack = 1e-9 * max(cylinder.return_pressure, 1.0)
    return CylinderState(
        force=np.asarray(force),
        cap_pressure=cap,
        rod_pressure=rod,
        cap_flow=cap_flow,
        rod_flow=rod_flow,
        demand=np.maximum(cap_flow, 0.0) + np.maximum(rod_flow, 0.0),
        power=np.asarray(force * rate),
        to_lower=np.asarray(position - cylinder.stroke[0]),
        to_upper=np.asarray(cylinder.stroke[1] - position),
        overloaded=np.maximum(cap, rod) > cylinder.supply_pressure + slack,
    )
