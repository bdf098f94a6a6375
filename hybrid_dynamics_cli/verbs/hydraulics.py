"""Pressures, flows and strokes of hydraulic cylinders."""

from __future__ import annotations

from dataclasses import fields

import click
import numpy as np

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.limits.limits import HYDRAULIC

from ..limits import margin_facts
from ..load_options import load_options, loads_of
from ..output import show, table
from ..parameters import (
    accelerations_of,
    closed,
    ddu_option,
    du_option,
    json_option,
    loaded,
    robot_argument,
    u_option,
)

BAR = 1e5  # [Pa]
LITRES = 6e4  # [l/min] in a m^3/s
HEAD = ["cylinder", "force N", "cap bar", "rod bar", "pump l/min", "power W", "to low m", "to up m"]
EPILOG = """\b
Examples:
  hybrid-dynamics hydraulics excavator --payload 900
  hybrid-dynamics hydraulics excavator --du boom_cylinder=0.2 --json
"""


@click.command(epilog=EPILOG, short_help="Pressures, flows and strokes of cylinders.")
@robot_argument
@u_option
@du_option
@ddu_option
@load_options
@json_option
def command(
    robot: str,
    u: str | None,
    du: str | None,
    ddu: str | None,
    payload: float | None,
    com: str | None,
    wrench: str | None,
    frame: str | None,
    as_json: bool,
) -> None:
    """Pressures of both chambers, flow of the pump, power and stroke of every cylinder.

    A chamber that does not push is at return pressure. With --json all values are in SI units.
    """
    machine = loaded(robot)
    if not machine.cylinders:
        raise InputError(f"{machine.name} has no hydraulic cylinder in its description")
    state = closed(machine, u, du)
    accelerations = accelerations_of(machine, ddu)
    loads = loads_of(machine, payload, com, wrench, frame)
    tau = machine.inverse_dynamics(state, accelerations, loads)
    data = {}
    rows: list[list[object]] = []
    margins = machine.limit_margins(state, accelerations, tau)
    notes = [f"note: {margin.text}" for margin in margins.beyond if margin.kind in HYDRAULIC]
    for name, cylinder in machine.hydraulics(state, tau).items():
        values = {one.name: np.asarray(getattr(cylinder, one.name)) for one in fields(cylinder)}
        data[name] = values
        numbers = {key: float(value) for key, value in values.items()}
        row = [numbers["force"], numbers["cap_pressure"] / BAR, numbers["rod_pressure"] / BAR]
        row += [numbers["demand"] * LITRES, numbers["power"]]
        rows.append([name, *row, numbers["to_lower"], numbers["to_upper"]])
    total = sum(float(values["demand"]) for values in data.values())
    data_all = {"cylinders": data, "demand": total, "limits": margin_facts(margins)}
    show(data_all, as_json, "\n".join([table(HEAD, rows), *notes]))
