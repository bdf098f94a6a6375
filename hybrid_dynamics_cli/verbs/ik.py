"""Inverse kinematics."""

from __future__ import annotations

import re
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core import IKResult, IKStatus, Pose, Robot
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.decimal_commas import with_point
from hybrid_dynamics_core.ground.units import coordinate_unit

from ..limits import beyond
from ..output import by_name, number, show, table, zero_if_small
from ..parameters import json_option, loaded, options, robot_argument, vector, vector_option
from ..quantities import NumberType, coordinate_units

_PLACE_OPTIONS = ("--position", "--quaternion")
_AXES = ("x", "y", "z", "rx", "ry", "rz")

DIGITS = 6  # significant digits of the nearest solution, by the accuracy of the search
REACHED = 1e-9  # [m or rad] accuracy of a solution
EPILOG = """\b
Examples:
  hybrid-dynamics ik forging_chu2020 --position 0.32 0.38 1.12
  hybrid-dynamics ik gough --position 0 0 0.78 --quaternion 0 0 0 1 --all
  hybrid-dynamics ik five_bar --position 0.05 0.3 0 --axes x,y

Ends with 1 where there is no solution.
"""


class PlaceCommand(click.Command):
    """Command whose numbers of a pose may be separated by commas: `--position 1.4,0,1.05`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments after splitting values at commas.

        Raises:
            click.UsageError: the call is wrong; the message names a decimal comma as the probable
                cause.
        """
        try:
            return super().parse_args(ctx, _split_places(args))
        except click.UsageError as error:
            comma = next((arg for arg in args if with_point(arg)), None)
            if comma is None:
                raise
            point = with_point(comma)
            hint = f"decimals are written with a point: {point}, if {comma} is one number"
            raise click.UsageError(f"{error.message.rstrip('.')}; {hint}", ctx) from error


def _split_places(args: list[str]) -> list[str]:
    """The arguments, with the values of a pose split at commas."""
    words: list[str] = []
    for arg in args:
        option, equals, values = arg.partition("=")
        if option in _PLACE_OPTIONS and equals:
            words += [option, *_split_values(values)]
        elif words and words[-1] in _PLACE_OPTIONS:
            words += _split_values(arg)
        else:
            words.append(arg)
    return words


def _split_values(values: str) -> list[str]:
    """The parts of a text between commas, except commas within parentheses."""
    return [value.strip() for value in re.split(r",(?![^()]*\))", values)]


@click.command(
    cls=PlaceCommand,
    epilog=EPILOG,
    short_help="Active coordinates for a place of the end effector.",
)
@robot_argument
@click.option(
    "--position",
    nargs=3,
    type=NumberType("m"),
    required=True,
    metavar="X Y Z",
    help="Of the end effector, in the base; or X,Y,Z.",
)
@click.option(
    "--quaternion",
    nargs=4,
    type=NumberType("1"),
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
    type=NumberType("m"),
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
    target: Array | Pose = np.array(position)
    if quaternion:
        target = Pose.from_quaternion(position, quaternion)
    start = vector("--seed", seed, machine.active, machine.reference, coordinate_units(machine))
    mask = _mask(axes)
    if mask is not None and any(mask[3:]) and not quaternion:
        raise click.BadParameter(
            "a rotation counts, but no --quaternion is given", param_hint="--axes"
        )
    with options("tolerance"):
        result = machine.inverse_kinematics(
            target, seed=start, all_solutions=every, mask=mask, tolerance=tolerance
        )
    data: dict[str, Any] = {
        "status": result.status,
        "message": result.message,
        "residual": result.residual,
        "position_error": result.position_error,
        "angle_error": result.angle_error,
        "u": by_name(machine.active, result.u),
        "solutions": [by_name(machine.active, u) for u in result.solutions],
        "branch": dict(result.branch),
        "redundant": list(result.redundant),
        "iterations": result.iterations,
        "beyond_limits": beyond(machine, machine.active, start),
    }
    if result.status is IKStatus.SOLVED:
        show(data, as_json, _solutions(machine, result))
        return
    show(data, as_json, _failure(machine, result))
    raise SystemExit(1)


def _mask(axes: str | None) -> list[bool] | None:
    """The mask over x, y, z, rx, ry, rz; None for all."""
    if axes is None:
        return None
    names = [axis.strip() for axis in axes.split(",")]
    wrong = [axis for axis in names if axis not in _AXES]
    if wrong:
        raise click.BadParameter(
            f"'{wrong[0]}': expected some of {', '.join(_AXES)}, with commas", param_hint="--axes"
        )
    return [axis in names for axis in _AXES]


def _failure(machine: Robot, result: IKResult) -> str:
    """The reason why there is no solution, and the nearest pose."""
    if result.state is None:
        return result.message
    joints = []
    for name, value in zip(machine.active, result.u.tolist(), strict=True):
        unit = coordinate_unit(machine.joint_types[name])
        joints.append(f"{name} = {number(round(value, DIGITS))} {unit}")
    place = machine.forward_kinematics(result.state).position
    axes = []
    for axis, value in zip("xyz", place.tolist(), strict=True):
        axes.append(f"{axis} = {number(round(value, DIGITS))} m")
    return f"{result.message}\nnearest: {', '.join(joints)}\nthere: {', '.join(axes)}"


def _solutions(machine: Robot, result: IKResult) -> str:
    """The solutions as columns of a table."""
    heads = ["value"]
    if len(result.solutions) > 1:
        heads = [f"solution {k}" for k in range(1, len(result.solutions) + 1)]
    rows: list[list[object]] = []
    for k, name in enumerate(machine.active):
        values = [zero_if_small(float(u[k]), REACHED) for u in result.solutions]
        rows.append([name, *values, coordinate_unit(machine.joint_types[name])])
    lines = [table(["active joint", *heads, "unit"], rows)]
    lines.append(f"left to the target: {_errors(result)}")
    if result.redundant:
        names = ", ".join(result.redundant)
        lines.append(f"not determined by the target, and left near the seed: {names}")
    return "\n".join(lines)


def _errors(result: IKResult) -> str:
    """The errors of position and orientation at the target."""
    errors = []
    for error, unit in ((result.position_error, "m"), (result.angle_error, "rad")):
        if np.isfinite(error):
            errors.append(f"{_small(float(error))} {unit}")
    return " and ".join(errors)


def _small(error: float) -> str:
    if error > REACHED:
        return number(error)
    return f"less than {REACHED:g}"
