"""Inverse kinematics."""

from __future__ import annotations

import re
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core import IKResult, IKStatus, Pose, Robot
from hybrid_dynamics_core.ground.decimal_commas import with_point
from hybrid_dynamics_core.ground.units import coordinate_unit

from ..limits import beyond
from ..output import number, show, table
from ..parameters import NUMBER, json_option, loaded, options, robot_argument, vector, vector_option

_PLACES = ("--position", "--quaternion")
_AXES = ("x", "y", "z", "rx", "ry", "rz")

DIGITS = 6  # of the nearest joints: where a target is out of reach, the search settles no more
REACHED = 1e-9  # [m or rad] a solution is settled to this
EPILOG = """\b
Examples:
  hybrid-dynamics ik forging_chu2020 --position 0.32 0.38 1.12
  hybrid-dynamics ik gough --position 0 0 0.78 --quaternion 0 0 0 1 --all
  hybrid-dynamics ik five_bar --position 0.05 0.3 0 --axes x,y

Ends with 1 where there is no solution.
"""


class Places(click.Command):
    """Takes the numbers of a place with commas as well: `--position 1.4,0,1.05`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Values with commas become values of their own."""
        taken: list[str] = []
        for arg in args:
            option, equals, values = arg.partition("=")
            if option in _PLACES and equals:
                taken += [option, *_parted(values)]
            else:
                taken += _parted(arg) if taken and taken[-1] in _PLACES else [arg]
        try:
            return super().parse_args(ctx, taken)
        except click.UsageError as error:
            comma = next((arg for arg in args if with_point(arg)), None)
            if comma is None:
                raise
            hint = (
                f"decimals are written with a point: {with_point(comma)}, if {comma} is one number"
            )
            raise click.UsageError(f"{error.message.rstrip('.')}; {hint}", ctx) from error


def _parted(values: str) -> list[str]:
    """At commas, but for those between the brackets of a term."""
    return [part.strip() for part in re.split(r",(?![^()]*\))", values)]


@click.command(
    cls=Places, epilog=EPILOG, short_help="Active coordinates for a place of the end effector."
)
@robot_argument
@click.option(
    "--position",
    nargs=3,
    type=NUMBER,
    required=True,
    metavar="X Y Z",
    help="Of the end effector, in the base; or X,Y,Z.",
)
@click.option(
    "--quaternion",
    nargs=4,
    type=NUMBER,
    metavar="X Y Z W",
    help="Its orientation; left out, it is free.",
)
@click.option(
    "--axes",
    metavar="AXES",
    help="What counts of the target: some of x,y,z,rx,ry,rz; all that is given.",
)
@vector_option("--seed", help="Where the search starts; the robot's reference where left out.")
@click.option(
    "--tolerance",
    type=NUMBER,
    default=1e-5,
    show_default=True,
    help=(
        "Within it the target counts as reached [m]; an angle [rad] counts times the robot's reach."
    ),
)
@click.option("--all", "every", is_flag=True, help="All distinct solutions found.")
@json_option
def command(
    robot: str,
    position: tuple[float, ...],
    quaternion: tuple[float, ...] | None,
    axes: str | None,
    seed: str | None,
    tolerance: float,
    every: bool,
    as_json: bool,
) -> None:
    """Active coordinates that bring the end effector to a place, within the limits."""
    machine = loaded(robot)
    target = np.array(position) if not quaternion else Pose.from_quaternion(position, quaternion)
    start = vector("--seed", seed, machine.active, machine.reference)
    counts = _mask(axes)
    if counts is not None and any(counts[3:]) and not quaternion:
        raise click.BadParameter(
            "a rotation counts, but no --quaternion is given", param_hint="--axes"
        )
    with options("tolerance"):
        result = machine.inverse_kinematics(
            target, seed=start, all_solutions=every, mask=counts, tolerance=tolerance
        )
    told: dict[str, Any] = {
        "status": result.status,
        "message": result.message,
        "residual": result.residual,
        "position_error": result.position_error,
        "angle_error": result.angle_error,
        "u": dict(zip(machine.active, result.u, strict=True)),
        "solutions": [dict(zip(machine.active, u, strict=True)) for u in result.solutions],
        "branch": dict(result.branch),
        "redundant": list(result.redundant),
        "iterations": result.iterations,
        "beyond_limits": beyond(machine, machine.active, start),
    }
    show(told, as_json, text(machine, result))
    if result.status is not IKStatus.SOLVED:
        raise SystemExit(1)


def _mask(axes: str | None) -> list[bool] | None:
    if axes is None:
        return None
    told = [axis.strip() for axis in axes.split(",")]
    wrong = [axis for axis in told if axis not in _AXES]
    if wrong:
        raise click.BadParameter(
            f"'{wrong[0]}': expected some of {', '.join(_AXES)}, with commas", param_hint="--axes"
        )
    return [axis in told for axis in _AXES]


def text(machine: Robot, result: IKResult) -> str:
    """Solutions as columns, or why there is none."""
    if result.status is not IKStatus.SOLVED:
        near = ", ".join(
            f"{name} = {number(round(float(value), DIGITS))} {coordinate_unit(machine.joint_types[name])}"
            for name, value in zip(machine.active, result.u, strict=True)
        )
        if result.state is None:
            return result.message
        place = machine.forward_kinematics(result.state).position
        there = ", ".join(
            f"{axis} = {number(round(float(v), DIGITS))} m"
            for axis, v in zip("xyz", place, strict=True)
        )
        return f"{result.message}\nnearest: {near}\nthere: {there}"
    rows = [
        [
            name,
            *(_told(float(u[k])) for u in result.solutions),
            coordinate_unit(machine.joint_types[name]),
        ]
        for k, name in enumerate(machine.active)
    ]
    heads = (
        ["value"]
        if len(result.solutions) == 1
        else [f"solution {k + 1}" for k in range(len(result.solutions))]
    )
    errors = ((result.position_error, "m"), (result.angle_error, "rad"))
    left = " and ".join(
        f"{_small(float(error))} {kind}" for error, kind in errors if np.isfinite(error)
    )
    lines = [table(["active joint", *heads, "unit"], rows), f"left to the target: {left}"]
    if result.redundant:
        lines.append(
            f"not determined by the target, and left near the seed: {', '.join(result.redundant)}"
        )
    return "\n".join(lines)


def _told(value: float) -> float:
    """A coordinate; what the search does not settle is shown as zero."""
    return value if abs(value) > REACHED else 0.0


def _small(error: float) -> str:
    return number(error) if error > REACHED else f"less than {REACHED:g}"
