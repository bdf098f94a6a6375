"""Inverse dynamics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from hybrid_dynamics_core import ClosedState, Robot, cylinder_force
from hybrid_dynamics_core.dynamics.pressure_check import exchanged_text, fits_exchanged
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import effort_unit

from ..limits import beyond, margin_facts, margin_lines, margins_at
from ..load_options import (
    excess_notes,
    load_options,
    loads_of,
    massless_notes,
    pressures_of,
    pressures_option,
)
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
from ..reaction_tables import pin_data, pin_table, pins_option

MEASURED_HEAD = ["cylinder", "measured N", "required N", "difference N"]
HEAD = ["active joint", "effort", "unit", "M ddu", "C du", "G", "passive"]
EPILOG = """\b
Examples:
  hybrid-dynamics id forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics id excavator --payload 900 --com=-0.6,0.3,0
  hybrid-dynamics id excavator --pressures boom_cylinder=130*bar:5*bar
  hybrid-dynamics id excavator --ddu boom_cylinder=0.1 --pins --json
"""


@click.command(epilog=EPILOG, short_help="Efforts that a motion takes, and of what.")
@robot_argument
@u_option
@du_option
@ddu_option
@pressures_option
@load_options
@pins_option
@json_option
def command(
    robot: str,
    u: str | None,
    du: str | None,
    ddu: str | None,
    pressures: tuple[str, ...],
    payload: float | None,
    com: str | None,
    wrench: str | None,
    frame: str | None,
    pins: bool,
    as_json: bool,
) -> None:
    """Efforts that the actuators need for a motion, and what they are made of.

    The columns add up to the effort: inertia (M ddu), speed (C du), weight (G), friction,
    springs and wrenches (passive). --pressures stands measured forces of cylinders beside the
    required ones.
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
    margins = margins_at(machine, state, accelerations, tau)
    data["limits"] = margin_facts(margins)
    lines = [effort_table(machine, tau, parts), *margin_lines(margins)]
    texts = ["\n".join(lines)]
    if pressures:
        data["measured"], data["notes"] = measured_forces(machine, state, tau, pressures)
        rows = [[name, *forces.values()] for name, forces in data["measured"].items()]
        texts.append("\n".join([table(MEASURED_HEAD, rows), *data["notes"]]))
    if pins:
        reactions = machine.reactions(state, accelerations, loads)
        data["pins"] = pin_data(reactions)
        texts.append(pin_table(reactions))
    show(data, as_json, "\n\n".join(texts))


def effort_table(machine: Robot, tau: Array, parts: Mapping[str, Array]) -> str:
    """The effort of each active joint and its parts, with notes on idle joints."""
    rows: list[list[object]] = []
    for k, name in enumerate(machine.active):
        unit = effort_unit(machine.joint_types[name])
        shares = [float(part[k]) for part in parts.values()]
        rows.append([name, float(tau[k]), unit, *shares])
    notes = [f"note: {name} is idle: nobody gives the effort along it" for name in machine.idle]
    notes += massless_notes(machine)
    return "\n".join([table(HEAD, rows), *notes])


def measured_forces(
    machine: Robot, state: ClosedState, tau: Array, pressures: tuple[str, ...]
) -> tuple[dict[str, dict[str, float]], list[str]]:
    """Measured and required force of each cylinder with pressures, and their difference [N].

    Also lines on cylinders with exchanged chambers, and with more pressure than their supply has.
    """
    required = machine.hydraulics(state, tau)
    result: dict[str, dict[str, float]] = {}
    exchanged: list[str] = []
    for name, (cap, rod) in pressures_of(machine, pressures).items():
        cylinder = machine.cylinders[name]
        needed = float(required[name].force)
        force = float(cylinder_force(cylinder, cap, rod))
        result[name] = {"measured": force, "required": needed, "difference": force - needed}
        other = float(cylinder_force(cylinder, rod, cap))
        if fits_exchanged((force - needed) ** 2, (other - needed) ** 2):
            exchanged.append(name)
    notes = [f"note: {exchanged_text(exchanged)}"] if exchanged else []
    return result, notes + excess_notes(machine, pressures)
