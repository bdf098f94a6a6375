"""Assembly modes."""

from __future__ import annotations

import click

from ..output import number, show, table
from ..parameters import json_option, loaded, robot_argument, vector, vector_option


@click.command(epilog="Example: hybrid-dynamics branches staicu2015")
@robot_argument
@vector_option("-u", "--u", help="Active coordinates; the robot's reference where left out.")
@json_option
def command(robot: str, u: str | None, as_json: bool) -> None:
    """Every way in which the loops close with the same active coordinates."""
    machine = loaded(robot)
    modes = machine.assembly_modes(vector("-u", u, machine.active, machine.reference))
    told = {
        "modes": [
            {
                "branch": dict(mode.branch),
                "coordinates": dict(zip(machine.coordinates, mode.state.s, strict=True)),
                "residual": mode.state.residual,
                "singularity": mode.state.singularity,
            }
            for mode in modes
        ]
    }
    loops = list(modes[0].branch) if modes else []
    rows = [
        [str(k + 1), *(mode.branch[loop] for loop in loops), number(float(mode.state.singularity))]
        for k, mode in enumerate(modes)
    ]
    plural = "mode" if len(modes) == 1 else "modes"
    lines = [f"{len(modes)} assembly {plural}", "", table(["", *loops, "distance to singularity"], rows)]
    show(told, as_json, "\n".join(lines))
    if not modes:
        raise SystemExit(1)
