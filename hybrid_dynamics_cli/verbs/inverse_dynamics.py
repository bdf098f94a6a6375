"""Inverse dynamics."""

from __future__ import annotations

from typing import Any

import click
import numpy as np

from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import effort_unit

from ..limits import beyond
from ..output import show, table
from ..parameters import json_option, loaded, robot_argument, vector, vector_option

HEAD = ["active joint", "effort", "unit", "M ddu", "C du", "G", "passive"]
EPILOG = """\b
Examples:
  hybrid-dynamics id forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics id excavator --du q12=0.05 --ddu q12=0.1 --json
"""


@click.command(epilog=EPILOG, short_help="Efforts that a motion takes, and of what.")
@robot_argument
@vector_option(
    "-u", "--u", help="Active coordinates [rad or m]; the robot's reference where left out."
)
@vector_option("--du", help="Their rates [per second]; zero where left out.")
@vector_option("--ddu", help="Their accelerations [per second squared]; zero where left out.")
@json_option
def command(robot: str, u: str | None, du: str | None, ddu: str | None, as_json: bool) -> None:
    """Efforts that the actuators need for a motion, and what they are made of.

    The columns add up to the effort: inertia (M ddu), speed (C du), weight (G), friction and
    springs (passive).
    """
    machine = loaded(robot)
    still = np.zeros(len(machine.active))
    state = machine.close(
        vector("-u", u, machine.active, machine.reference),
        vector("--du", du, machine.active, still),
    )
    accelerations = vector("--ddu", ddu, machine.active, still)
    tau = machine.inverse_dynamics(state, accelerations)
    mass, speed, weight = machine.minimal_form(state)
    parts = {
        "M_ddu": mass @ accelerations,
        "C_du": speed,
        "G": weight,
        "passive": machine.passive_forces(state),
    }
    rows = [
        [
            name,
            float(tau[k]),
            effort_unit(machine.joint_types[name]),
            *(float(part[k]) for part in parts.values()),
        ]
        for k, name in enumerate(machine.active)
    ]

    def named(values: Array) -> dict[str, Any]:
        return dict(zip(machine.active, values, strict=True))

    told = {
        "tau": named(tau),
        **{key: named(part) for key, part in parts.items()},
        "M": {name: named(row) for name, row in zip(machine.active, mass, strict=True)},
        "power": float(tau @ state.du),
        "residual": state.residual,
        "singularity": state.singularity,
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    show(told, as_json, table(HEAD, rows))
