"""Forward dynamics."""

from __future__ import annotations

import click
import numpy as np

from hybrid_dynamics_core.ground.units import coordinate_unit

from ..limits import beyond, margin_facts, margin_lines, margins_at, role
from ..load_options import (
    excess_notes,
    idle_cylinder_notes,
    load_options,
    loads_of,
    pressure_forces,
    pressures_option,
)
from ..output import by_name, show, table
from ..parameters import (
    EFFORTS,
    closed,
    du_option,
    json_option,
    loaded,
    robot_argument,
    u_option,
    vector,
    vector_option,
)
from ..quantities import effort_units
from ..reaction_tables import pin_data, pin_table, pins_option

EPILOG = """\b
Examples:
  hybrid-dynamics fd excavator
  hybrid-dynamics fd excavator --pressures boom_cylinder=130*bar:5*bar
  hybrid-dynamics fd forging_chu2020 --tau q12=5000,q22=2000 --pins --json
"""


@click.command(epilog=EPILOG)
@robot_argument
@u_option
@du_option
@vector_option(
    "--tau", form=EFFORTS, help="Efforts of the actuators [N m or N]; zero where left out."
)
@pressures_option
@load_options
@pins_option
@json_option
def command(
    robot: str,
    u: str | None,
    du: str | None,
    tau: str | None,
    pressures: tuple[str, ...],
    payload: float | None,
    com: str | None,
    wrench: str | None,
    frame: str | None,
    pins: bool,
    as_json: bool,
) -> None:
    """Accelerations that the actuators' efforts give, or pressures of their cylinders."""
    machine = loaded(robot)
    state = closed(machine, u, du)
    efforts = vector(
        "--tau", tau, machine.active, np.zeros(len(machine.active)), effort_units(machine)
    )
    forces = pressure_forces(machine, pressures)
    notes = idle_cylinder_notes(machine, forces, by_name(machine.active, efforts))
    notes += excess_notes(machine, pressures)
    efforts = efforts + machine.generalised_forces(state, forces)
    loads = loads_of(machine, payload, com, wrench, frame)
    ddu = machine.forward_dynamics(state, efforts, loads)
    dds = machine.accelerations(state, ddu)
    rows: list[list[object]] = []
    for name, acceleration in zip(machine.coordinates, dds.tolist(), strict=True):
        unit = coordinate_unit(machine.joint_types[name], "/s^2")
        rows.append([name, role(machine, name), acceleration, unit])
    data = {
        "ddu": by_name(machine.active, ddu),
        "dds": by_name(machine.coordinates, dds),
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    margins = margins_at(machine, state, ddu, efforts)
    data["limits"] = margin_facts(margins)
    table_text = table(["coordinate", "", "acceleration", "unit"], rows)
    text = "\n".join([table_text, *notes, *margin_lines(margins)])
    if pins:
        reactions = machine.reactions(state, ddu, loads)
        data["pins"] = pin_data(reactions)
        text += "\n\n" + pin_table(reactions)
    show(data, as_json, text)
