"""Stiffness of a frame, deflection under load, and natural frequencies, with drives locked."""

from __future__ import annotations

from typing import Any, Final

import click
import numpy as np

from hybrid_dynamics_core import InputError, Loads, Robot
from hybrid_dynamics_core.description.elasticity import Elasticity
from hybrid_dynamics_core.description.parameters.written import written_of
from hybrid_dynamics_core.description.value_units import units_at
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_core.stiffness import Deflection, Stiffness, StiffnessMap, stiffness_map

from ...limits import beyond
from ...load_options import COMPONENTS, load_options, loads_of, numbers
from ...output import along_axes, show, show_written, table
from ...parameters import closed, json_option, loaded, options, robot_argument, u_option
from ...quantities import value_of
from ...robot_options import named_pairs
from ...writing import draw_option, overwrite_option, picture_for
from .pictures import draw_links, draw_map

AXES: Final = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "about x": (0.0, 0.0, 0.0, 1.0, 0.0, 0.0),
    "about y": (0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
    "about z": (0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
}
UNITS: Final = ["N m/rad", "N m", "N/m"]
EXAMPLE: Final = "slew=50*MN*m/rad"
HELP: Final = """\
How much the end effector gives way with drives locked: its stiffness, its deflection under weights
and loads, what contributes how much, and natural frequencies.

Compliances are those of the section `stiffness` of the robot's file, or of --drive. All else is
rigid. Deflections are to first order.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics stiffness delta --drive theta_A=2e4*N*m/rad --payload 2
  hybrid-dynamics stiffness excavator --drive boom_cylinder=50e6*N/m \\
      --drive slew=5e7*N*m/rad --wrench 0,0,-20*kN --json
  hybrid-dynamics stiffness excavator --drive slew=5e7*N*m/rad --mode 1 \\
      --draw mode.svg
"""


@click.command(help=HELP, epilog=EPILOG, short_help="Stiffness, deflections and frequencies.")
@robot_argument
@u_option
@click.option(
    "--drive",
    "drives",
    multiple=True,
    metavar="NAME=STIFFNESS",
    help="Stiffness of a drive [N m/rad or N/m], in place of the file's; repeatable.",
)
@load_options
@draw_option("picture", help="Draw the robot under its load")
@click.option("--mode", type=click.IntRange(min=1), help="With --draw: this natural mode.")
@click.option(
    "--over",
    metavar="A,B",
    help="With --draw: a map of the deflection under --wrench, over two joints that move.",
)
@overwrite_option
@json_option
def command(
    robot: str,
    u: str | None,
    drives: tuple[str, ...],
    payload: float | None,
    com: str | None,
    wrench: str | None,
    frame: str | None,
    picture: str | None,
    mode: int | None,
    over: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Print stiffness, deflection and frequencies, or draw them."""
    machine = loaded(robot)
    if picture is None and (mode is not None or over is not None):
        raise click.UsageError("--mode and --over are of the picture: give --draw FILE too")
    place = None
    if picture is not None:
        place = picture_for(machine, picture, overwrite=overwrite)
    on = None
    if payload is not None or wrench is not None:
        on = frame
    loads = loads_of(machine, payload, com, wrench, on)
    state = closed(machine, u, None)
    with options(drives="drive"):
        elasticity = with_drives(machine, drives)
        stiffness = machine.stiffness(state, elasticity, frame)
    if mode is not None:
        _check_mode(stiffness, loads, mode)
    beyond(machine, machine.active, state.u)
    data = facts(stiffness, loads)
    if place is not None:
        data["picture"] = str(place)
    show(data, as_json, text_of(data))
    if place is None:
        return
    if over is not None:
        chart = _map(machine, over, wrench, state.u, elasticity, frame)
        draw_map(machine, chart, place)
        show_written(place, "map of deflections", as_json)
        return
    title, links = _displacements(stiffness, loads, mode)
    draw_links(machine, state, links, f"{machine.name}: {title}", place)
    show_written(place, title, as_json)


def _check_mode(stiffness: Stiffness, loads: Loads, mode: int) -> None:
    """Raise click.BadParameter if there is no such mode."""
    count = len(stiffness.modes(loads).frequencies)
    if mode > count:
        raise click.BadParameter(f"{mode}: it has {counted(count, 'mode')}", param_hint="--mode")


def _displacements(
    stiffness: Stiffness, loads: Loads, mode: int | None
) -> tuple[str, dict[str, Array]]:
    """Title and displacement (6,) of each link: under load, or in a mode."""
    if mode is None:
        return "under load", dict(stiffness.deflection(loads).links)
    modes = stiffness.modes(loads)
    links = {name: shapes[mode - 1] for name, shapes in modes.links.items()}
    return f"mode {mode}, {modes.frequencies[mode - 1]:.3g} Hz", links


def _map(
    machine: Robot,
    over: str,
    wrench: str | None,
    u: Array,
    elasticity: Elasticity,
    frame: str | None,
) -> StiffnessMap:
    """The map over two joints."""
    names = [name.strip() for name in over.split(",")]
    if len(names) != 2:
        raise click.BadParameter(f"'{over}': expected two joints, as A,B", param_hint="--over")
    if wrench is None:
        raise click.UsageError("--over maps a deflection under a force: give --wrench too")
    first, second = names
    force = numbers("--wrench", wrench, COMPONENTS, (3, 6))[:3]
    with options(joints="over"):
        return stiffness_map(
            machine,
            (first, second),
            force,
            u=u,
            elasticity=elasticity,
            frame=frame,
        )


def with_drives(machine: Robot, texts: tuple[str, ...]) -> Elasticity:
    """The elasticity of the description, with other stiffnesses of drives."""
    described = machine.description.stiffness
    drives = dict(described.drives)
    _, expanded = written_of(machine.description).expanded
    for name, text in named_pairs("--drive", texts, "=", EXAMPLE).items():
        try:
            drives[name] = value_of(
                text, units_at(expanded, ("stiffness", "drives", name)) or UNITS
            )
        except (ValueError, ArithmeticError) as error:
            problem = f"'{name}={text}': {error}; expected NAME=STIFFNESS, as {EXAMPLE}"
            raise click.BadParameter(problem, param_hint="--drive") from error
    return Elasticity(drives, described.pins, described.links)


def facts(stiffness: Stiffness, loads: Loads) -> dict[str, Any]:
    """Stiffness, deflection and modes as plain data."""
    matrix = None
    rigid = stiffness.rigid_directions
    if not len(rigid):
        matrix = stiffness.stiffness
    return {
        "frame": stiffness.frame,
        "compliance": stiffness.compliance,
        "stiffness": matrix,
        "rigid_directions": rigid,
        "along": {name: stiffness.stiffness_along(axis) for name, axis in AXES.items()},
        "deflection": _deflection(stiffness.deflection(loads)),
        "modes": _modes(stiffness, loads),
    }


def _deflection(deflection: Deflection) -> dict[str, Any]:
    return {
        "displacement": deflection.displacement,
        "distance": deflection.distance,
        "energy": deflection.energy,
        "by_element": dict(deflection.by_element),
        "energy_by_element": dict(deflection.energy_by_element),
    }


def _modes(stiffness: Stiffness, loads: Loads) -> list[dict[str, Any]]:
    """Frequency and energies of each mode; none where nothing that moves has a mass."""
    try:
        modes = stiffness.modes(loads)
    except InputError:
        return []
    listed: list[dict[str, Any]] = []
    for k, frequency in enumerate(modes.frequencies.tolist()):
        shares = {name: float(share[k]) for name, share in modes.energy_by_element.items()}
        listed.append({"frequency": frequency, "energy_by_element": shares})
    return listed


def text_of(data: dict[str, Any]) -> str:
    """Stiffness, deflection and modes as tables."""
    deflection = data["deflection"]
    moved = 1e3 * deflection["displacement"][:3]
    turned = 1e3 * deflection["displacement"][3:]
    sag = f"{along_axes(moved)} mm, turned {along_axes(turned)} mrad in base axes"
    lines = [
        table([f"at {data['frame']}", "stiffness", "unit"], _along(data["along"])),
        "",
        f"under weights and load  {sag}",
        "",
        table(["element", "mm", "share of energy"], _shares(deflection)),
    ]
    if data["modes"]:
        lines += ["", table(["mode", "Hz", "most energy in"], _frequencies(data["modes"]))]
    return "\n".join(lines)


def _along(stiffnesses: dict[str, float]) -> list[list[object]]:
    rows: list[list[object]] = []
    for name, value in stiffnesses.items():
        unit = "N m/rad" if name.startswith("about") else "N/m"
        shown: object = f"{value:.4g}"
        if value == np.inf:
            shown = "rigid"
        rows.append([name, shown, unit])
    return rows


def _shares(deflection: dict[str, Any]) -> list[list[object]]:
    """Distance that each element adds, and its share of the energy, the largest first."""
    energies = deflection["energy_by_element"]
    total = deflection["energy"] or 1.0
    rows: list[list[object]] = []
    for name in sorted(energies, key=energies.__getitem__, reverse=True):
        distance = 1e3 * float(np.linalg.norm(deflection["by_element"][name][:3]))
        rows.append([name, distance, f"{100.0 * energies[name] / total:.1f} %"])
    return rows


def _frequencies(modes: list[dict[str, Any]]) -> list[list[object]]:
    rows: list[list[object]] = []
    for k, mode in enumerate(modes):
        shares = mode["energy_by_element"]
        most = max(shares, key=shares.__getitem__)
        rows.append([k + 1, mode["frequency"], f"{most}, {100.0 * shares[most]:.0f} %"])
    return rows
