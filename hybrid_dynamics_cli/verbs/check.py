"""Checks of a robot file, with a picture."""

from __future__ import annotations

import math
import warnings
from dataclasses import asdict
from pathlib import Path
from typing import Any, get_args

import click
import numpy as np

from hybrid_dynamics_core import ClosedState, MassSingularityError, Robot, SingularityError
from hybrid_dynamics_core.drawing.options import Names
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural

from ..closure_coverage import ClosureCoverage, closure_coverage
from ..limits import margin_lines, margins_at, narrowed
from ..output import by_name, number, show, show_written, table, written
from ..parameters import json_option, loaded, loaded_undecided, robot_argument
from ..writing import draw_option, overwrite_option, picture_for
from .info import facts
from .info import text as info_text

FAR = 0.8  # [rad] larger than the error of a rough guess of the configuration
SMALL = 1e-3  # distance to a singularity below which a reference is a poor starting point
NO_MASS = 1e-10  # rounding error of a mass matrix, relative to its largest entry
LARGE_CONDITION = 1e9  # of a mass matrix

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
@click.option(
    "--skeleton",
    is_flag=True,
    help="With --draw: bars and plates between joints in place of the robot's visuals.",
)
@click.option("--strict", is_flag=True, help="Refuse inertias that no rigid body has.")
@overwrite_option
@json_option
def command(
    robot: str,
    picture: str | None,
    names: Names | None,
    modes: bool,
    skeleton: bool,
    strict: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Check a robot: its file, its loops, its masses.

    The loops are closed at the reference and at places spread over the limits of the active joints.
    Ends with 1 if something is wrong. It is no fault if loops do not close all over the limits; the
    last line says so.
    """
    if picture is None:
        _refuse_without_picture(modes, skeleton)
    if modes and picture is not None:
        machine = _decided(robot, picture, names, overwrite, strict)
    else:
        machine = loaded(robot, strict)
    place = None
    if picture is not None:
        place = picture_for(machine, picture, overwrite=overwrite)
    data: dict[str, Any] = {"ok": True}
    data["notes"] = remarks(machine)
    data["warnings"] = list(machine.description.warnings)
    data |= facts(machine)
    data["massless"] = list(massless(machine))
    lines = _text(machine, data)
    if place is not None:
        data["picture"] = str(place)
    coverage = closure_coverage(machine)
    data["tried"] = asdict(coverage)
    if coverage.places:
        lines.append(coverage.describe())
    lines.append(verdict(machine, coverage))
    show(data, as_json, "\n".join(lines))
    if place is not None:
        if modes:
            _draw_modes(machine, place, names)
        else:
            _draw(machine, place, names, skeleton)
        show_written(place, _title(modes), as_json)


def _text(machine: Robot, data: dict[str, Any]) -> list[str]:
    """The summary of the robot, and the notes on it."""
    lines = [info_text(machine, data), ""]
    lines += _massless_lines(machine)
    lines += [f"note: {note}" for note in data["notes"]]
    lines += [f"warning: {warning}" for warning in data["warnings"]]
    return lines


def _massless_lines(machine: Robot) -> list[str]:
    """A table of the links without a mass, or one sentence if no link has a mass."""
    links = massless(machine)
    if not links or not _has_masses(machine):
        return []
    rows = [[link, joint, "none: massless in the dynamics"] for link, joint in links.items()]
    title = f"{counted(len(links), 'link')} without a mass"
    return [title, "", table(["link", "moved by", "mass"], rows), ""]


def verdict(machine: Robot, coverage: ClosureCoverage) -> str:
    """The last line, limited to the checks that were made."""
    description = machine.description
    count = len(description.warnings)
    see = ""
    if count:
        see = f", but see the {singular_or_plural(count, 'warning', 'warnings')} above"
    elif description.impossible:
        count = len(description.impossible)
        see = f", but see the {singular_or_plural(count, 'inertia', 'inertias')} noted above"
    if not machine.description.closures:
        if count:
            return f"It has no loops{see}."
        return "The description is right; it has no loops."
    if coverage.is_complete:
        if count:
            return f"Every loop closes{see}."
        return "The description is right: every loop closes."
    if coverage.is_rare:
        return (
            f"The loops close at the reference{see}, and hardly anywhere else: are limits and"
            " lengths meant so?"
        )
    return (
        f"The description is right{see}; its loops close at the reference, and not all over the"
        " limits."
    )


def massless(machine: Robot) -> dict[str, str]:
    """By moving link without mass and inertia: the joint that moves it."""
    moved_by = {joint.child: name for name, joint in machine.description.joints.items()}
    links = {}
    for name, link in machine.description.links.items():
        has_inertia = link.mass or link.inertia.any()
        is_listed = name in moved_by and name not in machine.description.links_in_rows
        if is_listed and not has_inertia:
            links[name] = moved_by[name]
    return links


def _has_masses(machine: Robot) -> bool:
    return any(link.mass for link in machine.description.links.values())


def remarks(machine: Robot) -> list[str]:
    """Notes on unusual properties that are no errors."""
    state = machine.close(machine.reference)
    description = machine.description
    notes = [note for note in description.notes if note not in description.warnings]
    notes += narrowed(machine)
    notes += _distant_angles(machine, state)
    if machine.measured_at_reference:
        notes.append(
            "no link of its loops has a length and no slide limits: distances to singularities are"
            " measured by the loops' size at the reference, and depend on it"
        )
    distance = float(state.singularity)
    if distance < SMALL:
        loop = state.singular_loop
        notes.append(f"the reference is near a singularity of {loop} ({number(distance)})")
    if _has_masses(machine):
        notes += _mass_remarks(machine, state)
        notes += _held_remarks(machine, state)
    else:
        notes.append("no link has a mass: kinematics only, all efforts are zero")
    return notes


def _held_remarks(machine: Robot, state: ClosedState) -> list[str]:
    """Notes on drives that cannot hold the robot at its reference."""
    still = np.zeros(len(machine.active))
    tau = machine.inverse_dynamics(state, still)
    lines = margin_lines(margins_at(machine, state, still, tau))
    return [f"held at rest at the reference, {line}" for line in lines]


def _distant_angles(machine: Robot, state: ClosedState) -> list[str]:
    """Notes on angles of the reference in the file that are far from the closed configuration.

    Such a reference may select a wrong assembly mode.
    """
    closed = by_name(machine.coordinates, state.s.tolist())
    notes = []
    for name, value in machine.description.reference.items():
        if name not in closed or name in machine.active:
            continue
        difference = math.remainder(closed[name] - value, math.tau)
        if machine.joint_types[name] == "revolute" and abs(difference) > FAR:
            notes.append(
                f"{name} is {number(value)} rad in the reference, and its loop closes at"
                f" {number(closed[name])} rad: is another assembly mode meant? `branches` lists"
                " them"
            )
    return notes


def _mass_remarks(machine: Robot, state: ClosedState) -> list[str]:
    """Notes on the mass matrix at a state, for forward dynamics."""
    try:
        mass_matrix = machine.minimal_form(state)[0]
        ddu = machine.forward_dynamics(state, np.zeros(len(machine.active)))
    except (MassSingularityError, SingularityError) as error:
        return [f"no forward dynamics: {error}"]
    omitted = _without_mass(machine, mass_matrix, ddu)
    reason = "is idle and moves no mass: forward dynamics leaves it out"
    notes = [f"{name} {reason}" for name in omitted]
    others = [k for k, name in enumerate(machine.active) if name not in omitted]
    if not others:
        return notes
    condition = np.linalg.cond(mass_matrix[np.ix_(others, others)])
    if condition > LARGE_CONDITION:
        text = f"M-bar has the condition number {number(condition)}"
        notes.append(f"{text}: some motion moves hardly any mass")
    return notes


def _without_mass(machine: Robot, mass_matrix: Array, ddu: Array) -> list[str]:
    """The idle coordinates that forward dynamics leaves out, because they have no mass."""
    largest = np.abs(mass_matrix).max(initial=0.0)
    names: list[str] = []
    for k, name in enumerate(machine.active):
        has_mass = np.abs(mass_matrix[k]).max() > NO_MASS * largest
        if name in machine.idle and ddu[k] == 0.0 and not has_mass:
            names.append(name)
    return names


def _refuse_without_picture(modes: bool, skeleton: bool) -> None:
    """Refuse options of a picture that is not drawn."""
    if modes:
        raise click.UsageError("--modes draws assembly modes; give --draw FILE too")
    if skeleton:
        raise click.UsageError("--skeleton is of the picture; give --draw FILE too")


def _decided(robot: str, picture: str, names: Names | None, overwrite: bool, strict: bool) -> Robot:
    """The robot; if its file does not decide the assembly modes, draw them and exit.

    The picture helps the user to choose.
    """
    machine, undecided = loaded_undecided(robot, strict)
    if undecided:
        place = picture_for(machine, picture, overwrite=overwrite)
        _draw_modes(machine, place, names, mark_current=False)
        raise click.ClickException("\n".join([*undecided, _drawn(place, modes=True)]))
    return machine


def _drawn(place: Path, modes: bool) -> str:
    """The line with the name and the contents of the picture."""
    return written(place, _title(modes))


def _title(modes: bool) -> str:
    """Description of the contents of a picture."""
    if modes:
        return "picture of the assembly modes"
    return "picture of the robot"


def _draw_modes(machine: Robot, path: Path, names: Names | None, mark_current: bool = True) -> None:
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw_modes  # noqa: PLC0415

    draw_modes(machine, path=path, names=names or "none", mark_own=mark_current)


def _draw(machine: Robot, path: Path, names: Names | None, skeleton: bool) -> None:
    """Draw the robot; meshes that are not shown are named on stderr."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw  # noqa: PLC0415

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        draw(machine, path=path, names=names or "active", skeleton=skeleton)
    for warning in caught:
        click.echo(f"note: {warning.message}", err=True)
