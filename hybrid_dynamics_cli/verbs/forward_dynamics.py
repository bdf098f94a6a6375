"""Forward dynamics."""

from __future__ import annotations

import click
import numpy as np

from hybrid_dynamics_core.ground.units import coordinate_unit

from ..limits import beyond
from ..output import show, table
from ..parameters import EFFORTS, json_option, loaded, robot_argument, vector, vector_option

EPILOG = """\b
Examples:
  hybrid-dynamics fd excavator
  hybrid-dynamics fd forging_chu2020 --tau q12=5000,q22=2000 --json
"""


@click.command(epilog=EPILOG)
@robot_argument
@vector_option(
    "-u", "--u", help="Active coordinates [rad or m]; the robot's reference where left out."
)
@vector_option("--du", help="Their rates [per second]; zero where left out.")
@vector_option(
    "--tau", form=EFFORTS, help="Efforts of the actuators [N m or N]; zero where left out."
)
@json_option
def command(robot: str, u: str | None, du: str | None, tau: str | None, as_json: bool) -> None:
    """Accelerations that the actuators' efforts give."""
    machine = loaded(robot)
    zero = np.zeros(len(machine.active))
    state = machine.close(
        vector("-u", u, machine.active, machine.reference), vector("--du", du, machine.active, zero)
    )
    ddu = machine.forward_dynamics(state, vector("--tau", tau, machine.active, zero))
    dds = machine.accelerations(state, ddu)
    rows = [
        [
            name,
            "active" if k < len(ddu) else "",
            float(dds[k]),
            coordinate_unit(machine.joint_types[name], "/s^2"),
        ]
        for k, name in enumerate(machine.coordinates)
    ]
    told = {
        "ddu": dict(zip(machine.active, ddu, strict=True)),
        "dds": dict(zip(machine.coordinates, dds, strict=True)),
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    show(told, as_json, table(["coordinate", "", "acceleration", "unit"], rows))
