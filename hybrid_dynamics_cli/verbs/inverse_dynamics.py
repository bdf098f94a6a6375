"""Inverse dynamics."""

from __future__ import annotations

import click
import numpy as np

from ..limits import beyond
from ..output import effort_unit, show, table
from ..parameters import json_option, loaded, robot_argument, vector, vector_option

EPILOG = """\b
Examples:
  hybrid-dynamics id forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics id excavator --du q12=0.05 --ddu q12=0.1 --json
"""


@click.command(epilog=EPILOG)
@robot_argument
@vector_option("-u", "--u", help="Active coordinates; the robot's reference where left out.")
@vector_option("--du", help="Their rates; zero where left out.")
@vector_option("--ddu", help="Their accelerations; zero where left out.")
@json_option
def command(robot: str, u: str | None, du: str | None, ddu: str | None, as_json: bool) -> None:
    """Efforts that the actuators need for a motion."""
    machine = loaded(robot)
    still = np.zeros(len(machine.active))
    state = machine.close(vector("-u", u, machine.active, machine.reference), vector("--du", du, machine.active, still))
    accelerations = vector("--ddu", ddu, machine.active, still)
    tau = machine.inverse_dynamics(state, accelerations)
    mass, speed, weight = machine.minimal_form(state)
    inertia = mass @ accelerations
    rows = [
        [
            name,
            float(tau[k]),
            float(inertia[k]),
            float(speed[k]),
            float(weight[k]),
            effort_unit(machine.joint_types[name]),
        ]
        for k, name in enumerate(machine.active)
    ]
    told = {
        "tau": dict(zip(machine.active, tau, strict=True)),
        "M_ddu": inertia,
        "C_du": speed,
        "G": weight,
        "M": mass,
        "power": float(tau @ state.du),
        "residual": state.residual,
        "singularity": state.singularity,
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    show(told, as_json, table(["active joint", "effort", "M ddu", "C du", "G", "unit"], rows))
