"""Reactions in pins, joints and the foundation."""

from __future__ import annotations

from typing import Any

import click

from ..limits import beyond
from ..load_options import (
    excess_notes,
    idle_cylinder_notes,
    load_options,
    loads_of,
    massless_notes,
    pressure_forces,
    pressures_option,
)
from ..output import by_name, show
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
from ..reaction_tables import (
    base_data,
    base_text,
    joint_data,
    joint_table,
    pin_data,
    pin_table,
)

EPILOG = """\b
Examples:
  hybrid-dynamics reactions excavator --payload 900
  hybrid-dynamics reactions forging_chu2020 -u 0,0.10,0.15,0 --pins --json
  hybrid-dynamics reactions excavator --pressures boom_cylinder=130*bar:5*bar
"""


@click.command(epilog=EPILOG, short_help="Forces and moments in pins, joints and foundation.")
@robot_argument
@u_option
@du_option
@ddu_option
@pressures_option
@load_options
@click.option("--pins", is_flag=True, help="Only the pins of loops.")
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
    """Forces and moments that pins, joints and the foundation transmit, in base axes.

    With --pressures the robot moves as these pressures make it move, else as --ddu says.
    """
    machine = loaded(robot)
    state = closed(machine, u, du)
    loads = loads_of(machine, payload, com, wrench, frame)
    if pressures and ddu is not None:
        raise click.UsageError("--pressures determine the accelerations: leave out --ddu")
    accelerations = accelerations_of(machine, ddu)
    notes = massless_notes(machine)
    if pressures:
        forces = pressure_forces(machine, pressures)
        efforts = machine.generalised_forces(state, forces)
        accelerations = machine.forward_dynamics(state, efforts, loads)
        notes += idle_cylinder_notes(machine, forces) + excess_notes(machine, pressures)
    reactions = machine.reactions(state, accelerations, loads)
    texts = [pin_table(reactions), *notes]
    data: dict[str, Any] = {"pins": pin_data(reactions)}
    if not pins:
        texts += [joint_table(reactions), base_text(reactions)]
        data |= {"joints": joint_data(reactions), "base": base_data(reactions)}
    data |= {
        "tau": by_name(machine.active, reactions.tau),
        "ddu": by_name(machine.active, accelerations),
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    show(data, as_json, "\n\n".join(texts))
