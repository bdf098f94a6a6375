"""Stiffness of a frame, deflection under load, and natural frequencies, with drives locked."""

from __future__ import annotations

from typing import Any, Final

import click
import numpy as np

from hybrid_dynamics_core import InputError, Loads, Robot
from hybrid_dynamics_core.description.elasticity import Elasticity
from hybrid_dynamics_core.stiffness import Deflection, Stiffness

from ...load_options import load_options, loads_of
from ...output import along_axes, show, table
from ...parameters import closed, json_option, loaded, options, robot_argument, u_option
from ...quantities import value_of
from ...robot_options import named_pairs

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
@json_option
def command(
    robot: str,
    u: str | None,
    drives: tuple[str, ...],
    payload: float | None,
    com: str | None,
    wrench: str | None,
    frame: str | None,
    as_json: bool,
) -> None:
    """Print stiffness, deflection and frequencies."""
    machine = loaded(robot)
    on = None
    if payload is not None or wrench is not None:
        on = frame
    loads = loads_of(machine, payload, com, wrench, on)
    state = closed(machine, u, None)
    with options(drives="drive"):
        stiffness = machine.stiffness(state, with_drives(machine, drives), frame)
    data = facts(stiffness, loads)
    show(data, as_json, text_of(data))


def with_drives(machine: Robot, texts: tuple[str, ...]) -> Elasticity:
    """The elasticity of the description, with other stiffnesses of drives."""
    described = machine.description.stiffness
    drives = dict(described.drives)
    for name, text in named_pairs("--drive", texts, "=", EXAMPLE).items():
        try:
            drives[name] = value_of(text, UNITS)
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
    lines = [
        table([f"at {data['frame']}", "stiffness", "unit"], _along(data["along"])),
        "",
        f"under load  {along_axes(moved)} mm, turned {along_axes(turned)} mrad in base axes",
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
