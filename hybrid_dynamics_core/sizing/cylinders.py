"""Cylinders of a catalogue in a duty cycle: pressure, stroke, speed, and buckling of the rod."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..description.actuators import HydraulicCylinder
from ..dynamics.hydraulics import chamber_flows, chamber_pressures
from ..errors import InputError
from ..ground.arrays import Array
from .catalogue import CatalogueCylinder
from .checks import Candidate, Check, Margins
from .demand import Demand


def cylinder_checks(
    row: CatalogueCylinder, demand: Demand, mounted: HydraulicCylinder, margins: Margins
) -> Candidate:
    """What a cylinder of a catalogue would give.

    Args:
        row: the cylinder.
        demand: what its joint has to do.
        mounted: the cylinder of the description, for its number, side and pressures.
        margins: what is needed beyond the duty cycle.

    Raises:
        InputError: neither the catalogue nor the description has a highest pressure, or buckling is
            to be checked and no length is known.
    """
    cylinder = replace(mounted, bore=row.bore, rod=row.rod)
    checks = [_pressure(row, demand, cylinder, margins)]
    checks += _stroke(row, demand, margins)
    if not math.isnan(row.speed):
        needed = margins.speed * demand.speed
        checks.append(Check("speed", needed, row.speed, "m/s"))
    if math.isfinite(mounted.flow_limit):
        needed = margins.speed * _largest_flow(demand, cylinder)
        checks.append(Check("flow", needed, mounted.flow_limit, "m^3/s"))
    if not math.isnan(row.modulus):
        checks.append(_buckling(row, demand, cylinder, margins))
    return Candidate(row.name, tuple(checks))


def _pressure(
    row: CatalogueCylinder, demand: Demand, cylinder: HydraulicCylinder, margins: Margins
) -> Check:
    highest = row.pressure
    if math.isnan(highest):
        highest = cylinder.highest_pressure
    if math.isinf(highest):
        raise InputError(
            f"{row.name}: no highest pressure; give the catalogue a column pressure, or"
            f" {cylinder.joint} a supply_pressure"
        )
    force = margins.pressure * demand.force
    cap, rod = chamber_pressures(cylinder, force)
    needed = max(cap.max(), rod.max())
    return Check("pressure", float(needed), highest, "Pa")


def _stroke(row: CatalogueCylinder, demand: Demand, margins: Margins) -> list[Check]:
    """Strokes; where the retracted length is known, lengths between the pins too."""
    needed = demand.travel + 2.0 * margins.stroke
    stroke = Check("stroke", needed, row.stroke, "m")
    if math.isnan(row.retracted) or demand.length is None:
        return [stroke]
    shortest = float(demand.length.min()) - margins.stroke
    longest = float(demand.length.max()) + margins.stroke
    extended = row.retracted + row.stroke
    return [
        stroke,
        Check("retracted length", row.retracted, shortest, "m"),
        Check("extended length", longest, extended, "m"),
    ]


def _largest_flow(demand: Demand, cylinder: HydraulicCylinder) -> float:
    """Largest flow into the chamber that fills [m^3/s]."""
    cap, rod = chamber_flows(cylinder, demand.rate)
    largest = max(cap.max(), rod.max())
    return float(largest)


def _buckling(
    row: CatalogueCylinder, demand: Demand, cylinder: HydraulicCylinder, margins: Margins
) -> Check:
    """Push of the rod against Euler's load, at the row of the cycle that is nearest to it."""
    push = cylinder.sign * demand.force / cylinder.count
    length = _free_length(row, demand)
    worst = int(np.argmax(push * length**2))
    load = euler_load(row.modulus, row.rod, float(length[worst]))
    largest = max(float(push[worst]), 0.0)
    needed = margins.buckling * largest
    return Check("buckling", needed, load, "N")


def _free_length(row: CatalogueCylinder, demand: Demand) -> Array:
    """Length that may buckle (N,) [m]."""
    if not math.isnan(row.length):
        return np.full_like(demand.force, row.length)
    if demand.length is None:
        raise InputError(
            f"{row.name}: the pins of {demand.drive} are not known, so buckling needs a column"
            " length"
        )
    return demand.length


def euler_load(modulus: float, diameter: float, length: float) -> float:
    """Force [N] under which a round bar between two pins buckles: pi^2 E I / l^2.

    Euler's case of two hinged ends: Timoshenko and Gere (1961), Theory of Elastic Stability, 2.1.

    Args:
        modulus: of elasticity [Pa].
        diameter: of the bar [m].
        length: between the pins [m].
    """
    moment = math.pi / 64.0 * diameter**4
    return math.pi**2 * modulus * moment / length**2
