"""Hydraulic cylinders: forces and chamber pressures, rates and flows, positions and strokes.

A force gives one equation for the pressures of two chambers. The chamber that does not push is
assumed to be at the cylinder's return pressure. Compressibility, leakage and seal friction are not
modelled. Friction of the joint is a load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.scalar import Scalar, larger
from ..description.actuators import HydraulicCylinder
from ..ground.arrays import Array

SLACK = 1e-9  # share of the return pressure by which the highest pressure may be exceeded


@dataclass(frozen=True, eq=False)
class CylinderState:
    """Force, pressures, flows and stroke of a cylinder; numbers, or (N,) for a batch.

    Attributes:
        force: [N] along the joint's coordinate.
        cap_pressure: [Pa] gauge, in the chamber on the cap side.
        rod_pressure: [Pa] gauge, in the chamber on the rod side.
        cap_flow: [m^3/s] of oil into the cap chamber, negative out of it.
        rod_flow: [m^3/s] of oil into the rod chamber, negative out of it.
        demand: [m^3/s] flow that the supply gives, into the chamber that fills.
        power: [W] that the oil brings in, force times rate.
        to_lower: [m] to the lower end of the stroke, negative beyond it.
        to_upper: [m] to the upper end of the stroke, negative beyond it.
        overloaded: whether a chamber needs more than the highest pressure.
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
    cap_force = np.multiply(cap_pressure, cylinder.cap_area)
    rod_force = np.multiply(rod_pressure, cylinder.rod_area)
    return np.asarray(cylinder.sign * (cap_force - rod_force))


def chamber_pressures(cylinder: HydraulicCylinder, force: ArrayLike) -> tuple[Array, Array]:
    """Chamber pressures that give a force.

    Args:
        cylinder: the cylinder.
        force: [N] along the joint's coordinate, a number or (N,).

    Returns:
        Pressures [Pa] on the cap and the rod side. The idle one is at return pressure.
    """
    return _chamber_pressures(cylinder, np.asarray(force, dtype=float))


def _chamber_pressures(cylinder: HydraulicCylinder, force: Scalar) -> tuple[Scalar, Scalar]:
    """`chamber_pressures` of any scalar."""
    push = cylinder.sign * force
    idle = cylinder.return_pressure
    cap = (push + idle * cylinder.rod_area) / cylinder.cap_area
    rod = (idle * cylinder.cap_area - push) / cylinder.rod_area
    return larger(cap, idle), larger(rod, idle)


def chamber_flows(cylinder: HydraulicCylinder, rate: ArrayLike) -> tuple[Array, Array]:
    """Flows [m^3/s] into cap and rod side at a rate of the joint [m/s]."""
    return _chamber_flows(cylinder, np.asarray(rate, dtype=float))


def _chamber_flows(cylinder: HydraulicCylinder, rate: Scalar) -> tuple[Scalar, Scalar]:
    """`chamber_flows` of any scalar."""
    extension = cylinder.sign * rate
    return extension * cylinder.cap_area, -extension * cylinder.rod_area


def force_range(cylinder: HydraulicCylinder) -> tuple[float, float]:
    """Least and greatest force [N] along the joint between return and highest pressure."""
    low = cylinder.return_pressure
    high = cylinder.highest_pressure
    pull = low * cylinder.cap_area - high * cylinder.rod_area
    push = high * cylinder.cap_area - low * cylinder.rod_area
    if cylinder.sign > 0.0:
        return pull, push
    return -push, -pull


def cylinder_state(
    cylinder: HydraulicCylinder, position: Array, rate: Array, force: Array
) -> CylinderState:
    """Pressures, flows and stroke of a cylinder from its motion and force.

    Args:
        cylinder: the cylinder.
        position: coordinate of its joint [m], a number or (N,).
        rate: [m/s].
        force: [N] along the coordinate.
    """
    terms = cylinder_terms(cylinder, position, rate, force)
    slack = SLACK * max(cylinder.return_pressure, 1.0)
    highest = np.maximum(terms["cap_pressure"], terms["rod_pressure"])
    arrays = {name: np.asarray(value) for name, value in terms.items()}
    return CylinderState(**arrays, overloaded=highest > cylinder.highest_pressure + slack)


def cylinder_terms(
    cylinder: HydraulicCylinder, position: Scalar, rate: Scalar, force: Scalar
) -> dict[str, Scalar]:
    """The numbers of a `CylinderState` by name, over any scalar."""
    cap, rod = _chamber_pressures(cylinder, force)
    cap_flow, rod_flow = _chamber_flows(cylinder, rate)
    lower, upper = cylinder.stroke
    return {
        "force": force,
        "cap_pressure": cap,
        "rod_pressure": rod,
        "cap_flow": cap_flow,
        "rod_flow": rod_flow,
        "demand": larger(cap_flow, 0.0) + larger(rod_flow, 0.0),
        "power": force * rate,
        "to_lower": position - lower,
        "to_upper": upper - position,
    }
