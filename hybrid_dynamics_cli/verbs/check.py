"""Whether a description is right, and a picture of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, get_args

import click
import numpy as np

from hybrid_dynamics_core import ClosedState, MassSingularityError, Robot, SingularityError
from hybrid_dynamics_core.drawing.options import Names
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural

from ..closure_coverage import Tried, try_loops
from ..limits import narrowed
from ..output import number, show, table, written
from ..parameters import json_option, loaded, loaded_undecided, robot_argument
from ..writing import draw_option, overwrite_option, picture_for
from .info import facts
from .info import text as info_text

FAR = 0.8  # [rad] a rough guess of where a loop closes is nearer
SMALL = 1e-3  # distance to a singularity below which a reference is a poor place to start from

EPILOG = """\b
Examples:
  hybrid-dynamics check my_robot.yaml
  hybrid-dynamics check my_robot.yaml --draw my_robot.svg --names all
"""


@click.command(epilog=EPILOG)
@robot_argument
@draw_option("picture", help="Draw the mechanism")
@click.option(
    "--names",
    type=click.Choice(get_args(Names)),
    help="Whose names are drawn.  [default: active; with --modes: none]",
)
@click.option(
    "--modes", is_flag=True, help="With --draw: all assembly modes of the reference, side by side."
)
@overwrite_option
@json_option
def command(
    robot: str,
    picture: str | None,
    names: Names | None,
    modes: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Check a robot: its file, its loops, its masses.

    The loops are closed at the reference and at places spread over the limits of the active joints.
    Ends with 1 where something is wrong; that loops do not close all over the limits is told, and
    no fault.
    """
    if modes and picture is None:
        raise click.UsageError("--modes draws assembly modes; give --draw FILE too")
    machine = (
        _decided(robot, picture, names, overwrite)
        if modes and picture is not None
        else loaded(robot)
    )
    place = None if picture is None else picture_for(machine, picture, overwrite=overwrite)
    notes = remarks(machine)
    warnings = machine.description.warnings
    light = massless(machine)
    told: dict[str, Any] = {
        "ok": True,
        "notes": notes,
        "warnings": list(warnings),
        **facts(machine),
    }
    told["massless"] = list(light)
    lines = [info_text(machine, told), ""]
    if (
        any(link.mass for link in machine.description.links.values()) and light
    ):  # else a note says it of all
        rows = [[link, joint, "none: massless in the dynamics"] for link, joint in light.items()]
        lines += [
            f"{counted(len(light), 'link')} without a mass",
            "",
            table(["link", "moved by", "mass"], rows),
            "",
        ]
    lines += [f"note: {note}" for note in notes]
    lines += [f"warning: {doubt}" for doubt in warnings]
    if place is not None:
        draw(machine, place, names, modes)
        told["picture"] = str(place)
        lines.append(drawn(place, modes))
    tried = try_loops(machine)
    told["tried"] = {"places": tried.places, "closed": tried.closed}
    lines += [
        *([tried.told()] if tried.places else []),
        verdict(tried, len(warnings), loops=bool(machine.description.closures)),
    ]
    show(told, as_json, "\n".join(lines))


def verdict(tried: Tried, warnings: int, *, loops: bool) -> str:
    """The last line: it says no more than what was seen."""
    see = (
        f", but see the {singular_or_plural(warnings, 'warning', 'warnings')} above"
        if warnings
        else ""
    )
    if not loops:
        return (
            f"It has no loops{see}." if warnings else "The description is right; it has no loops."
        )
    if tried.everywhere:
        return (
            f"Every loop closes{see}."
            if warnings
            else "The description is right: every loop closes."
        )
    if tried.hardly:
        return (
            f"The loops close at the reference{see}, and hardly anywhere else: are limits and"
            " lengths meant so?"
        )
    return (
        f"The description is right{see}; its loops close at the reference, and not all over the"
        " limits."
    )


def massless(machine: Robot) -> dict[str, str]:
    """Links that move and have neither mass nor inertia, and the joint that moves each."""
    links, joints = machine.description.links, machine.description.joints
    moved = {joint.child: name for name, joint in joints.items()}
    return {
        name: moved[name]
        for name, link in links.items()
        if name in moved and not (link.mass or link.inertia.any())
    }


def elsewhere(machine: Robot, state: ClosedState) -> list[str]:
    """Angles that the file's reference gives far from where the loops close: the mode it names may not be meant."""
    told = machine.description.reference
    closed = dict(zip(machine.coordinates, state.s.tolist(), strict=True))
    off = {
        name: math.remainder(closed[name] - value, math.tau)
        for name, value in told.items()
        if name in closed
    }
    return [
        f"{name} is {number(told[name])} rad in the reference, and its loop closes at"
        f" {number(closed[name])} rad: is another assembly mode meant? `branches` lists them"
        for name, by in off.items()
        if name not in machine.active and machine.joint_types[name] == "revolute" and abs(by) > FAR
    ]


def remarks(machine: Robot) -> list[str]:
    """What is no fault, and yet to be known."""
    state = machine.close(machine.reference)
    description = machine.description
    notes = [note for note in description.notes if note not in description.warnings] + narrowed(
        machine
    )
    notes += elsewhere(machine, state)
    if float(state.singularity) < SMALL:
        notes.append(
            f"the reference is near a singularity of {state.singular_loop}"
            f" ({number(float(state.singularity))})"
        )
    if not any(link.mass for link in machine.description.links.values()):
        notes.append("no link has a mass: kinematics only, all efforts are zero")
        return notes
    try:
        mass = machine.minimal_form(state)[0]
        machine.forward_dynamics(state, np.zeros(len(machine.active)))
        spread = np.linalg.cond(mass)
        if spread > 1e9:
            notes.append(
                f"M-bar has the condition number {number(spread)}: some motion moves hardly any"
                " mass"
            )
    except (MassSingularityError, SingularityError) as error:
        notes.append(f"no forward dynamics: {error}")
    return notes


def _decided(robot: str, picture: str, names: Names | None, overwrite: bool) -> Robot:
    """The robot; where its file leaves modes open, draw them, the picture that helps to choose, and end."""
    machine, undecided = loaded_undecided(robot)
    if undecided:
        place = picture_for(machine, picture, overwrite=overwrite)
        draw(machine, place, names, modes=True, mark_own=False)
        raise click.ClickException("\n".join([*undecided, drawn(place, modes=True)]))
    return machine


def drawn(place: Path, modes: bool) -> str:
    """That the picture is written, and of what it is."""
    return written(place, "picture of the assembly modes" if modes else "picture of the robot")


def draw(
    machine: Robot, path: Path, names: Names | None, modes: bool, mark_own: bool = True
) -> None:
    """Write the picture."""
    from hybrid_dynamics_core.drawing import (  # noqa: PLC0415  Matplotlib is an extra
        draw as draw_robot,
    )
    from hybrid_dynamics_core.drawing import draw_modes  # noqa: PLC0415

    if modes:
        draw_modes(machine, path=path, names=names or "none", mark_own=mark_own)
    else:
        draw_robot(machine, path=path, names=names or "active")
