"""Forces and loads within the limits of the drives, and lifting charts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.capability import (
    Capability,
    Largest,
    LiftingChart,
    Polytope,
    lifting_chart,
)
from hybrid_dynamics_core.ground.arrays import Array

from ..output import by_name, number, show, show_written, table
from ..parameters import (
    closed,
    frame_option,
    json_option,
    loaded,
    once_each,
    options,
    robot_argument,
    u_option,
)
from ..quantities import QuantityRange, effort_units, value_of
from ..writing import draw_option, overwrite_option, picture_for

DIRECTIONS: Final = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}
HELP: Final = """\
What the robot can do at a state: the largest forces of the end effector on what it touches, the
mass that it holds, the breakout force of each drive, and which drive limits each.

Limits are effort limits and pressures of cylinders, or those of --limit. With --draw, a lifting
chart over reach and height is drawn: two joints move, the others stay where -u has them.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics capability excavator -u boom_cylinder=0.5
  hybrid-dynamics capability excavator --limit slew=90*kN*m --axes x,y,z \\
      --json
  hybrid-dynamics capability excavator --frame bucket --share 0.87 \\
      --draw lifting_chart.svg
"""


@click.command(help=HELP, epilog=EPILOG, short_help="Forces, loads and lifting charts.")
@robot_argument
@u_option
@frame_option("Frame or link in place of the end effector.")
@click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="DRIVE=EFFORT",
    help="Another largest effort of a drive [N m or N]; repeatable.",
)
@click.option(
    "--axes",
    metavar="AXES",
    help="With --json: the polytope of forces along x,y,z and moments about rx,ry,rz.",
)
@draw_option("picture", help="Draw a lifting chart")
@click.option(
    "--over", metavar="A,B", help="The two joints that move in the chart.  [default: found]"
)
@click.option(
    "--share",
    type=QuantityRange("1", 0.01, 1.0),
    default=1.0,
    show_default=True,
    help="Share of the lifted mass that the chart shows, as 0.87 for ISO 10567.",
)
@overwrite_option
@json_option
def command(
    robot: str,
    u: str | None,
    frame: str | None,
    limits: tuple[str, ...],
    axes: str | None,
    picture: str | None,
    over: str | None,
    share: float,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Print what the robot can do, or draw its chart."""
    machine = loaded(robot)
    if picture is None and over is not None:
        raise click.UsageError("--over is of the chart: give --draw FILE too")
    place = None
    if picture is not None:
        place = picture_for(machine, picture, overwrite=overwrite)
    state = closed(machine, u, None)
    with options(efforts="limit"):
        able = machine.capability(state, frame=frame, efforts=_limits(machine, limits))
    data = facts(able)
    if axes is not None:
        polytope = able.forces(tuple(name.strip() for name in axes.split(",")))
        data["polytope"] = _polytope(polytope)
    chart = None
    if place is not None:
        chart = lifting_chart(machine, _pair(over), state.u, frame, share=share)
        data["chart"] = _chart(chart)
        data["picture"] = str(place)
    show(data, as_json, text_of(data, chart))
    if place is not None and chart is not None:
        _draw(machine, chart, place)
        show_written(place, "lifting chart", as_json)


def _limits(machine: Robot, texts: tuple[str, ...]) -> dict[str, float]:
    """Largest efforts by drive."""
    units = dict(zip(machine.active, effort_units(machine), strict=True))
    return once_each("--limit", (_limit(text, units) for text in texts))


def _limit(text: str, units: Mapping[str, str]) -> tuple[str, float]:
    """The name and the effort of a text `DRIVE=EFFORT`."""
    name, _, term = text.partition("=")
    name = name.strip()
    try:
        return name, value_of(term, [units.get(name, "N"), "N m"])
    except (ValueError, ArithmeticError) as error:
        problem = f"'{text}': {error}; expected DRIVE=EFFORT, as slew=90*kN*m"
        raise click.BadParameter(problem, param_hint="--limit") from error


def _pair(over: str | None) -> tuple[str, str] | None:
    if over is None:
        return None
    names = [name.strip() for name in over.split(",")]
    if len(names) != 2:
        raise click.BadParameter(f"'{over}': expected two joints, as A,B", param_hint="--over")
    return names[0], names[1]


def facts(able: Capability) -> dict[str, Any]:
    """What a robot can do, as plain data."""
    forces = {name: _largest(able.largest_force(way)) for name, way in DIRECTIONS.items()}
    breakout: dict[str, Any] = {}
    for drive in able.drives:
        try:
            breakout[drive] = _largest(able.breakout(drive))
        except InputError:  # it does not move the frame here
            continue
    return {
        "forces": forces,
        "lifted_mass": _largest(able.lifted_mass()),
        "breakout": breakout,
        "limits": {name: list(ends) for name, ends in able.limits.items()},
    }


def _largest(answer: Largest) -> dict[str, Any]:
    return {
        "value": answer.value,
        "limited_by": list(answer.limited_by),
        "efforts": dict(answer.efforts),
    }


def _polytope(polytope: Polytope) -> dict[str, Any]:
    return {
        "axes": list(polytope.axes),
        "vertices": polytope.vertices,
        "normals": polytope.normals,
        "offsets": polytope.offsets,
        "at_limit": [list(names) for names in polytope.at_limit],
    }


def _chart(chart: LiftingChart) -> dict[str, Any]:
    return {
        "joints": list(chart.joints),
        "share": chart.share,
        "radius": chart.radius,
        "height": chart.height,
        "mass": chart.mass,
        "limited_by": _names(chart.limited_by, chart.drives),
    }


def _names(indices: Array, drives: tuple[str, ...]) -> list[list[str]]:
    """Names of the limiting drives; empty where there is none."""
    named = np.array([*drives, ""])
    return named[indices].tolist()  # type: ignore[no-any-return]


def text_of(data: dict[str, Any], chart: LiftingChart | None) -> str:
    """What a robot can do, as a table."""
    rows: list[list[object]] = []
    for name, answer in data["forces"].items():
        rows.append([f"force {name}", *_cells(answer, "N")])
    rows.append(["lifted mass", *_cells(data["lifted_mass"], "kg")])
    for name, answer in data["breakout"].items():
        rows.append([f"breakout, {name}", *_cells(answer, "N")])
    lines = [table(["at the frame", "largest", "unit", "limited by"], rows)]
    if chart is not None:
        greatest = number(float(np.nanmax(chart.mass)))
        joints = by_name(("first", "second"), chart.joints)
        lines.append(f"\nchart: up to {greatest} kg; {joints['first']} and {joints['second']} move")
    return "\n".join(lines)


def _cells(answer: dict[str, Any], unit: str) -> list[object]:
    value = answer["value"]
    if value == np.inf:
        return ["no limit", unit, ""]
    if value == -np.inf:
        return ["none", unit, "the robot itself is not held"]
    return [number(value), unit, ", ".join(answer["limited_by"])]


def _draw(machine: Robot, chart: LiftingChart, place: Path) -> None:
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw_lifting_chart  # noqa: PLC0415

    draw_lifting_chart(machine, chart, place)
