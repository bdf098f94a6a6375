"""Inverse dynamics."""

from __future__ import annotations

from typing import Any

import click

from hybrid_dynamics_core.ground.units import effort_unit

from ..limits import beyond
from ..load_options import load_options, loads_of
from ..output import by_name, show, table
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

HEAD = ["active joint", "effort", "unit", "M ddu", "C du", "G", "passive"]
EPILOG = """\b
Examples:
  hybrid-dynamics id forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics id excavator --payload 900 --com=-0.6,0.3,0
  hybrid-dynamics id excavator --ddu boom_cylinder=0.1 --json
"""


@click.command(epilog=EPILOG, short_help="Efforts that a motion takes, and of what.")
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
    """Efforts that the actuators need for a motion, and what they are made of.

    The columns add up to the effort: inertia (M ddu), speed (C du), weight (G), friction,
    springs and wrenches (passive).
    """
    machine = loaded(robot)
    state = closed(machine, u, du)
    accelerations = accelerations_of(machine, ddu)
    loads = loads_of(machine, payload, com, wrench, frame)
    tau = machine.inverse_dynamics(state, accelerations, loads)
    mass_matrix, speed, weight = machine.minimal_form(state, loads)
    parts = {
        "M_ddu": mass_matrix @ accelerations,
        "C_du": speed,
        "G": weight,
        "passive": machine.passive_forces(state, loads),
    }
    rows: list[list[object]] = []
    for k, name in enumerate(machine.active):
        shares = [float(part[k]) for part in parts.values()]
        rows.append([name, float(tau[k]), effort_unit(machine.joint_types[name]), *shares])
    data: dict[str, Any] = {"tau": by_name(machine.active, tau)}
    for key, part in parts.items():
        data[key] = by_name(machine.active, part)
    matrix_rows = [by_name(machine.active, row) for row in mass_matrix]
    data |= {
        "M": by_name(machine.active, matrix_rows),
        "power": float(tau @ state.du),
        "residual": state.residual,
        "singularity": state.singularity,
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    notes = [f"note: {name} is idle: nobody gives the effort along it" for name in machine.idle]
    show(data, as_json, "\n".join([table(HEAD, rows), *notes]))
