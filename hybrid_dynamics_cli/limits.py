"""Joint limits: those that loops narrow, and values beyond them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import click

from hybrid_dynamics_core import ClosedState, Robot, SingularityError
from hybrid_dynamics_core.description.values import ENDLESS
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.limits import LimitMargins, Margin

from .output import number

SLACK = 1e-6  # [rad or m] below the resolution of tables


def narrowed(machine: Robot) -> list[str]:
    """A sentence for each active joint whose range is narrowed by loops or by dependent joints."""
    sentences = []
    for k, name in enumerate(machine.active):
        lower, upper = machine.limits[k].tolist()
        least, most = machine.description.joints[name].limits
        cuts = [lower - least, most - upper]  # infinite without a limit in the file
        if not any(SLACK < cut < math.inf for cut in cuts):
            continue
        unit = coordinate_unit(machine.joint_types[name])
        allowed = f"the file allows {least:g} to {most:g} {unit}"
        remains = f"from {number(lower)} to {number(upper)} {unit}"
        sentence = f"{name}: {allowed}; its loop closes {remains}"
        if _is_cut_by_joints(machine, k):
            sentence = f"{name}: {allowed}; limits of joints that follow it leave it {remains}"
        sentences.append(sentence)
    return sentences


def _is_cut_by_joints(machine: Robot, k: int) -> bool:
    """Whether a limit of an active coordinate comes neither from the file nor from a loop."""
    described = machine.description.joints[machine.active[k]].limits
    closing = machine.closing_range[k].tolist()
    for end, *sources in zip(machine.limits[k].tolist(), described, closing, strict=True):
        if math.isfinite(end) and min(abs(end - source) for source in sources) > SLACK:
            return True
    return False


def role(machine: Robot, name: str) -> str:
    """The role of a coordinate: active, idle, or neither."""
    if name in machine.idle:
        return "idle"
    return "active" if name in machine.active else ""


def beyond(machine: Robot, names: Sequence[str], values: Array) -> list[dict[str, Any]]:
    """The coordinates beyond a limit, each also printed to stderr.

    Args:
        machine: the robot.
        names: names of coordinates.
        values: (n,) values of the coordinates [rad or m].

    Returns:
        For each coordinate beyond its limit: `name`, `value` and `limit` [rad or m].
    """
    active_limits = dict(zip(machine.active, machine.limits.tolist(), strict=True))
    violations = []
    for name, value in zip(names, values.tolist(), strict=True):
        lower, upper = active_limits.get(name, machine.description.joints[name].limits)
        if lower - SLACK <= value <= upper + SLACK:
            continue
        limit = upper
        if value < lower:
            limit = lower
        violations.append({"name": name, "value": value, "limit": limit})
        unit = coordinate_unit(machine.joint_types[name])
        text = f"{name} = {number(value)} {unit} is beyond its limit {number(limit)} {unit}"
        click.echo(f"note: {text}{_degrees_hint(value, unit)}", err=True)
    return violations


def margins_at(machine: Robot, state: ClosedState, ddu: Array, tau: Array) -> LimitMargins | None:
    """Margins of a motion to all limits; None where the drives cannot give its efforts."""
    try:
        return machine.limit_margins(state, ddu, tau)
    except SingularityError:
        return None


def margin_facts(margins: LimitMargins | None) -> dict[str, Any]:
    """What is beyond its limit, and the quantity nearest to one, as plain data."""
    if margins is None:
        return {"beyond": [], "nearest": None}
    nearest = margins.nearest
    return {
        "beyond": [_margin_facts(margin) for margin in margins.beyond],
        "nearest": None if nearest is None else _margin_facts(nearest),
    }


def margin_lines(margins: LimitMargins | None) -> list[str]:
    """A line for each quantity beyond its limit; those of coordinates are notes of `beyond`."""
    if margins is None:
        return []
    return [f"beyond: {one.text}" for one in margins.beyond if one.kind != "position"]


def _margin_facts(margin: Margin) -> dict[str, Any]:
    return {
        "kind": margin.kind,
        "name": margin.name,
        "value": margin.value,
        "limit": margin.limit,
        "margin": margin.margin,
        "unit": margin.unit,
    }


def _degrees_hint(value: float, unit: str) -> str:
    """The correct form for an angle of more than a turn that is probably in degrees."""
    if unit != "rad" or not math.tau < abs(value) < ENDLESS:
        return ""
    return f"; {value:g} degrees are written {value:g}*deg"
