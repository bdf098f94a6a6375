"""Assembly modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.closed_state.assembly_modes import AssemblyMode, Completeness, mode_of
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.ground.wording import counted

from ..limits import beyond
from ..output import by_name, constant_axes, number, show, show_written, table
from ..parameters import json_option, loaded_undecided, robot_argument, u_option, vector
from ..quantities import coordinate_units
from ..writing import draw_option, overwrite_option, picture_for

LINE = 79  # characters of a line of text
HOLD = "\u00a0"  # no-break space
EPILOG = """\b
Examples:
  hybrid-dynamics branches staicu2015
  hybrid-dynamics branches forging_chu2020 -u q12=0.2 --draw modes.svg
  hybrid-dynamics branches five_bar --json

Ends with 1 where the loops do not close.
"""


@click.command(epilog=EPILOG, short_help="Every way in which the loops close.")
@robot_argument
@u_option
@draw_option("picture", help="Draw them side by side")
@overwrite_option
@json_option
def command(robot: str, u: str | None, picture: str | None, overwrite: bool, as_json: bool) -> None:
    """Every way in which the loops close with the same active coordinates."""
    machine, undecided = loaded_undecided(robot)
    place = None
    if picture is not None:
        place = picture_for(machine, picture, overwrite=overwrite)
    values = vector("-u", u, machine.active, machine.reference, coordinate_units(machine))
    modes = machine.assembly_modes(values)
    current = None
    if not undecided:
        current = current_mode(machine, values, modes)
    data = facts(machine, values, modes, current)
    data["undecided"] = undecided
    data["completeness"] = modes.completeness.value
    data["reason"] = modes.reason
    lines = _heading(machine, values, len(modes))
    if modes:
        legend = f"{_mark(current, undecided)}; x, y, z of"
        legend += f" {machine.end_effector} in {machine.base_frame}"
        lines += ["", *_text(data["modes"], legend)]
        lines += [f"to be decided: {text}" for text in undecided]
        if modes.completeness is not Completeness.PROVEN:
            lines += wrap(f"all modes: {modes.completeness.value}; {modes.reason}", LINE)
    if place is not None and modes:
        data["picture"] = str(place)
    show(data, as_json, "\n".join(lines))
    if place is not None and modes:
        _draw(machine, values, place, decided=not undecided)
        show_written(place, "picture of the assembly modes", as_json)
    if not modes:
        # Raises StateError with the loop that does not close and the range in which it would.
        machine.close(values)
        raise SystemExit(1)


def _draw(machine: Robot, values: Array, place: Path, *, decided: bool) -> None:
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw_modes  # noqa: PLC0415

    draw_modes(machine, values, place, mark_own=decided)


def current_mode(machine: Robot, values: Array, modes: Sequence[AssemblyMode]) -> int | None:
    """Index of the mode of `close`; None if it is none of the given ones."""
    try:
        return mode_of(modes, machine.close(values))
    except StateError:
        return None


def facts(
    machine: Robot, values: Array, modes: Sequence[AssemblyMode], current: int | None
) -> dict[str, Any]:
    """The modes as plain data.

    Args:
        machine: the robot.
        values: (n,) active coordinates [rad or m].
        modes: assembly modes at these coordinates.
        current: index of the current mode, if any.
    """
    entries = []
    for k, mode in enumerate(modes):
        entry = _facts_of(machine, mode)
        entry["own"] = k == current
        entries.append(entry)
    return {
        "modes": entries,
        "u": by_name(machine.active, values),
        "beyond_limits": beyond(machine, machine.active, values),
    }


def _facts_of(machine: Robot, mode: AssemblyMode) -> dict[str, Any]:
    return {
        "branch": dict(mode.branch),
        "coordinates": by_name(machine.coordinates, mode.state.s),
        "position": machine.forward_kinematics(mode.state).position,
        "residual": mode.state.residual,
        "singularity": float(mode.state.singularity),
    }


def _heading(machine: Robot, values: Array, count: int) -> list[str]:
    """The number of modes, and the active coordinates."""
    places = []
    for name, value in zip(machine.active, values.tolist(), strict=True):
        unit = coordinate_unit(machine.joint_types[name])
        places.append(HOLD.join([name, "=", number(value), unit]))
    heading = f"{counted(count, 'assembly mode')} at {', '.join(places)}"
    return [line.replace(HOLD, " ") for line in wrap(heading, LINE)]


def _text(modes: Sequence[Mapping[str, Any]], legend: str) -> list[str]:
    """A table of the quantities in which the modes differ, followed by the common ones."""
    loops = []
    axes = []
    same = []
    for loop, way in modes[0]["branch"].items():
        if all(mode["branch"][loop] == way for mode in modes):
            same.append(f"{loop} {way}")
        else:
            loops.append(loop)
    constant = constant_axes([mode["position"] for mode in modes])
    for axis in "xyz":
        if axis in constant:
            same.append(f"{axis} = {number(constant[axis])} m")
        else:
            axes.append(axis)
    rows = [_row(k, mode, loops, axes) for k, mode in enumerate(modes, start=1)]
    head = ["mode", *loops, "singularity", *(f"{axis} [m]" for axis in axes)]
    lines = [table(head, rows, break_before=1 + len(loops)), ""]
    lines.append("singularity: distance of the nearest loop, 0 there, 1 best")
    if same:
        lines += wrap(f"in all of them: {', '.join(same)}", LINE, break_on_hyphens=False)
    lines.append(legend)
    return lines


def _row(
    mode_number: int, mode: Mapping[str, Any], loops: Sequence[str], axes: Sequence[str]
) -> list[object]:
    name = str(mode_number)
    if mode["own"]:
        name += "*"
    position = by_name("xyz", mode["position"].tolist())
    senses = [mode["branch"][loop] for loop in loops]
    places = [position[axis] for axis in axes]
    return [name, *senses, mode["singularity"], *places]


def _mark(current: int | None, undecided: Sequence[str]) -> str:
    if undecided:
        return "the file names no mode yet"
    if current is None:
        return "the robot's own mode does not close here"
    return "*: the robot's own mode"
