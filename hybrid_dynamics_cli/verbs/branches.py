"""Assembly modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.closed_state.assembly_modes import AssemblyMode, mode_of
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.ground.wording import counted

from ..limits import beyond
from ..output import constant_axes, number, show, table, written
from ..parameters import json_option, loaded_undecided, robot_argument, vector, vector_option
from ..writing import draw_option, overwrite_option, picture_for

HOLD = "\u00a0"  # a space at which no line ends
EPILOG = """\b
Examples:
  hybrid-dynamics branches staicu2015
  hybrid-dynamics branches forging_chu2020 -u q12=0.2 --draw modes.svg
  hybrid-dynamics branches five_bar --json

Ends with 1 where the loops do not close.
"""


@click.command(epilog=EPILOG, short_help="Every way in which the loops close.")
@robot_argument
@vector_option(
    "-u", "--u", help="Active coordinates [rad or m]; the robot's reference where left out."
)
@draw_option("picture", help="Draw them side by side")
@overwrite_option
@json_option
def command(robot: str, u: str | None, picture: str | None, overwrite: bool, as_json: bool) -> None:
    """Every way in which the loops close with the same active coordinates."""
    machine, undecided = loaded_undecided(robot)
    place = None if picture is None else picture_for(machine, picture, overwrite=overwrite)
    values = vector("-u", u, machine.active, machine.reference)
    modes = machine.assembly_modes(values)
    own = None if undecided else own_mode(machine, values, modes)
    told = _facts(machine, values, modes, own)
    told["undecided"] = undecided
    lines = _first(machine, values, len(modes))
    if modes:
        lines += [
            "",
            *_text(
                told["modes"],
                f"{machine.end_effector} in {machine.base_frame}",
                _mark(own, undecided),
            ),
        ]
        lines += [f"to be decided: {text}" for text in undecided]
    if place is not None and modes:
        from hybrid_dynamics_core.drawing import draw_modes  # noqa: PLC0415  Matplotlib is an extra

        draw_modes(machine, values, place, mark_own=not undecided)
        told["picture"] = str(place)
        lines.append(written(place, "picture of the assembly modes"))
    show(told, as_json, "\n".join(lines))
    if not modes:
        machine.close(
            values
        )  # raises, and says which loop does not close and within which range it would
        raise SystemExit(1)


def _facts(
    machine: Robot, values: Array, modes: Sequence[AssemblyMode], own: int | None
) -> dict[str, Any]:
    """The modes for programs."""
    return {
        "modes": [
            {
                "branch": dict(mode.branch),
                "coordinates": dict(zip(machine.coordinates, mode.state.s, strict=True)),
                "position": machine.forward_kinematics(mode.state).position,
                "residual": mode.state.residual,
                "singularity": float(mode.state.singularity),
                "own": k == own,
            }
            for k, mode in enumerate(modes)
        ],
        "u": dict(zip(machine.active, values, strict=True)),
        "beyond_limits": beyond(machine, machine.active, values),
    }


def _text(modes: Sequence[Mapping[str, Any]], place: str, mark: str) -> list[str]:
    """The modes as a table: what differs among them, and below it what does not."""
    ways = {loop: [mode["branch"][loop] for mode in modes] for loop in modes[0]["branch"]}
    loops = [loop for loop, taken in ways.items() if len(set(taken)) > 1]
    flat = constant_axes([mode["position"] for mode in modes])
    axes = [k for k, axis in enumerate("xyz") if axis not in flat]
    rows = [
        [
            f"{k + 1}{'*' * mode['own']}",
            *(mode["branch"][loop] for loop in loops),
            mode["singularity"],
            *mode["position"][axes].tolist(),
        ]
        for k, mode in enumerate(modes)
    ]
    head = ["mode", *loops, "singularity", *(f"{'xyz'[k]} [m]" for k in axes)]
    return [
        table(head, rows, apart=1 + len(loops)),
        "",
        *_key(ways, loops, flat),
        f"{mark}; x, y, z of {place}",
    ]


def _first(machine: Robot, values: Array, count: int) -> list[str]:
    """How many modes there are, and at which values."""
    at = ", ".join(
        f"{name}{HOLD}={HOLD}{number(value)}{HOLD}{coordinate_unit(machine.joint_types[name])}"
        for name, value in zip(machine.active, values.tolist(), strict=True)
    )
    return [
        line.replace(HOLD, " ") for line in wrap(f"{counted(count, 'assembly mode')} at {at}", 79)
    ]


def _key(
    ways: Mapping[str, Sequence[str]], shown: Sequence[str], flat: Mapping[str, float]
) -> list[str]:
    """What the columns mean, and what is the same in all modes: loops, and coordinates of the end effector."""
    same = [f"{loop} {own[0]}" for loop, own in ways.items() if loop not in shown]
    same += [f"{axis} = {number(value)} m" for axis, value in flat.items()]
    told = wrap(f"in all of them: {', '.join(same)}", 79, break_on_hyphens=False) if same else []
    return ["singularity: distance of the nearest loop, 0 there, 1 best", *told]


def _mark(own: int | None, undecided: Sequence[str]) -> str:
    if undecided:
        return "the file names no mode yet"
    return (
        "*: the robot's own mode" if own is not None else "the robot's own mode does not close here"
    )


def own_mode(machine: Robot, values: Array, modes: Sequence[AssemblyMode]) -> int | None:
    """Which of the modes is the one that `close` takes; None where it takes none of them."""
    try:
        return mode_of(modes, machine.close(values))
    except StateError:
        return None
