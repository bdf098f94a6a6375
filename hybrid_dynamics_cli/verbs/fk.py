"""Forward kinematics."""

from __future__ import annotations

from typing import Any

import click

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.ground.units import coordinate_unit

from ..limits import beyond
from ..output import along_axes, by_name, number, show, table
from ..parameters import (
    closed,
    du_option,
    frame_option,
    json_option,
    loaded,
    robot_argument,
    u_option,
)

EPILOG = """\b
Examples:
  hybrid-dynamics fk forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics fk excavator -u boom_cylinder=0.3 --frame bucket --json
"""


@click.command(epilog=EPILOG, short_help="Pose of the end effector, and all coordinates.")
@robot_argument
@u_option
@du_option
@frame_option("A frame or link in place of the end effector.")
@json_option
def command(robot: str, u: str | None, du: str | None, frame: str | None, as_json: bool) -> None:
    """Pose of the end effector, and all coordinates, from the active ones."""
    machine = loaded(robot)
    state = closed(machine, u, du)
    pose = machine.forward_kinematics(state, frame)
    twist = machine.jacobian(state, frame) @ state.du
    data: dict[str, Any] = {
        "frame": frame or machine.end_effector,
        "position": pose.position,
        "quaternion": pose.quaternion,
        "rotation": pose.rotation,
        "twist": twist,
        "coordinates": by_name(machine.coordinates, state.s),
        "rates": by_name(machine.coordinates, state.ds),
        "branch": dict(state.branch),
        "residual": state.residual,
        "singularity": state.singularity,
        "beyond_limits": beyond(machine, machine.coordinates, state.s),
    }
    distance = number(float(state.singularity))
    lines = [
        _coordinate_table(machine, state),
        "",
        f"{data['frame']} in {machine.base_frame}:",
        f"  position          {along_axes(pose.position)}  m",
        f"  quaternion        {along_axes(pose.quaternion)}  (x y z w)",
        f"  linear velocity   {along_axes(twist[:3])}  m/s",
        f"  angular velocity  {along_axes(twist[3:])}  rad/s",
        f"residual {number(float(state.residual))}, distance to a singularity {distance}",
    ]
    show(data, as_json, "\n".join(lines))


def _coordinate_table(machine: Robot, state: ClosedState) -> str:
    rows: list[list[object]] = []
    values = zip(machine.coordinates, state.s.tolist(), state.ds.tolist(), strict=True)
    for name, value, rate in values:
        kind = machine.joint_types[name]
        rows.append([name, value, coordinate_unit(kind), rate, coordinate_unit(kind, "/s")])
    return table(["coordinate", "value", "unit", "rate", "unit"], rows)
