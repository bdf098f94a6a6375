"""Limits: where loops narrow those of the file, and values that are beyond them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.values import ENDLESS
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit

from .output import number

SLACK = 1e-6  # [rad or m] that tables do not show


def narrowed(machine: Robot) -> list[str]:
    """A sentence for each active joint whose loop closes over less than the file allows."""
    told = []
    for name, (lower, upper) in zip(machine.active, machine.limits.tolist(), strict=True):
        least, most = machine.description.joints[name].limits
        cut = [lower - least, most - upper]  # infinite where the file gives no limit
        if any(SLACK < by < math.inf for by in cut):
            kind = coordinate_unit(machine.joint_types[name])
            closes = f"{number(lower)} to {number(upper)} {kind}"
            told.append(
                f"{name}: the file allows {least:g} to {most:g} {kind}; its loop closes from"
                f" {closes}"
            )
    return told


def beyond(machine: Robot, names: Sequence[str], values: Array) -> list[dict[str, Any]]:
    """Coordinates beyond a limit: name, value and limit [rad or m]; each is told on stderr too."""
    active = dict(zip(machine.active, machine.limits.tolist(), strict=True))
    found = []
    for name, value in zip(names, values.tolist(), strict=True):
        lower, upper = active.get(name, machine.description.joints[name].limits)
        if not lower - SLACK <= value <= upper + SLACK:
            limit = lower if value < lower else upper
            found.append({"name": name, "value": value, "limit": limit})
            kind = coordinate_unit(machine.joint_types[name])
            told = f"{name} = {number(value)} {kind} is beyond its limit {number(limit)} {kind}"
            click.echo(f"note: {told}{_in_degrees(value, kind)}", err=True)
    return found


def _in_degrees(value: float, kind: str) -> str:
    """How an angle of more than a turn is written, where degrees seem to be meant."""
    if kind != "rad" or not math.tau < abs(value) < ENDLESS:
        return ""
    return f"; {value:g} degrees are written {value:g}*deg"
