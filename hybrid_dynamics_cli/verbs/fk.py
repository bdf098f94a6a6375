"""Forward kinematics."""

from __future__ import annotations

from typing import Any

import click
import numpy as np

from hybrid_dynamics_core.ground.units import coordinate_unit

from ..limits import beyond
from ..output import ROUNDING, number, show, table
from ..parameters import frame_option, json_option, loaded, robot_argument, vector, vector_option

EPILOG = """\b
Examples:
  hybrid-dynamics fk forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics fk excavator -u q12=0.3 --frame bucket --json
"""


@click.command(epilog=EPILOG, short_help="Pose of the end effector, and all coordinates.")
@robot_argument
@vector_option(
    "-u", "--u", help="Active coordinates [rad or m]; the robot's reference where left out."
)
@vector_option("--du", help="Their rates [per second]; zero where left out.")
@frame_option("A frame or link in place of the end effector.")
@json_option
def command(robot: str, u: str | None, du: str | None, frame: str | None, as_json: bool) -> None:
    """Pose of the end effector, and all coordinates, from the active ones."""
    machine = loaded(robot)
    values = vector("-u", u, machine.active, machine.reference)
    rates = vector("--du", du, machine.active, np.zeros(len(machine.active)))
    state = machine.close(values, rates)
    pose = machine.forward_kinematics(state, frame)
    twist = machine.jacobian(state, frame) @ state.du
    told: dict[str, Any] = {
        "frame": frame or machine.end_effector,
        "position": pose.position,
        "quaternion": pose.quaternion,
        "rotation": pose.rotation,
        "twist": twist,
        "coordinates": dict(zip(machine.coordinates, state.s, strict=True)),
        "rates": dict(zip(machine.coordinates, state.ds, strict=True)),
        "branch": dict(state.branch),
        "residual": state.residual,
        "singularity": state.singularity,
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    rows = [
        [
            name,
            float(state.s[k]),
            coordinate_unit(machine.joint_types[name]),
            float(state.ds[k]),
            coordinate_unit(machine.joint_types[name], "/s"),
        ]
        for k, name in enumerate(machine.coordinates)
    ]
    lines = [
        table(["coordinate", "value", "unit", "rate", "unit"], rows),
        "",
        f"{told['frame']} in {machine.base_frame}:",
        f"  position          {listed(pose.position)}  m",
        f"  quaternion        {listed(pose.quaternion)}  (x y z w)",
        f"  linear velocity   {listed(twist[:3])}  m/s",
        f"  angular velocity  {listed(twist[3:])}  rad/s",
        (
            f"residual {number(float(state.residual))}, distance to a singularity"
            f" {number(float(state.singularity))}"
        ),
    ]
    show(told, as_json, "\n".join(lines))


def listed(values: np.ndarray) -> str:
    """Numbers in a row; what is only rounding is shown as zero."""
    return "  ".join(number(float(v) if abs(v) > ROUNDING else 0.0) for v in values)
