"""A robot from its class, links, loops or modules, and dimensions."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.design.procedure import (
    CLASSES,
    Outcome,
    RobotClass,
    cycle_text,
    outcome_of,
    report_text,
    robot_text,
    usual_cycle,
)
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.formats.output_files import require_place, write_folder
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_core.sizing import read_catalogue, read_duty

from ...bags.common import PATH
from ...closure_coverage import closure_coverage
from ...output import show, table
from ...parameters import json_option
from ...quantities import QuantityRange
from ...writing import overwrite_option
from .cycle import tell_unused
from .margins import margins_of, margins_option
from .size import facts as facts_of_sizing

HELP: Final = """\
A robot of Class I, II or III of Chu et al. (2020), from its structure and dimensions.

\b
Class I    parallel modules in series           --modules
Class II   parallel modules under a serial arm  --modules --links
Class III  closed loops on a serial arm         --links --loops

Each is a text of parts with semicolons between them, `HEAD: KEY=VALUE KEY=VALUE; ...`.

A link is yaw, pitch or roll, with length, tail, mass, radius, at (its angle in the reference), on
(the link that carries it) and limits. A number of links takes usual ones.

A loop is A, B, C or D, with joint, pivot (on its base), pin (on the link that it drives) and base.
A and D have barrel, rod and stroke of a cylinder, or crank and coupler. B is a parallelogram, or
has bar and pin; carrier is the length on which the arm goes on. C has bar and k2. masses are those
of both added links, side is left or right.

A module is a template (3-UPU, 3-UPS/S, 6-UPS, delta) with its parameters.

DIR gets robot.yaml, cycle.csv (places over all strokes, unless --cycle), report.md, picture.svg.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics design --class III --links 3 -o crane \\
      --loops 'A: joint=q2 pivot=-0.3,0.4 pin=0.3,0 barrel=0.35'
  hybrid-dynamics design --class I -o tripod --json \\
      --modules '3-UPU: base_radius=0.4 platform_radius=0.15 height=0.6'
"""


@click.command(help=HELP, epilog=EPILOG, short_help="A robot from its class, types and dimensions.")
@click.option("--class", "robot_class", type=click.Choice(CLASSES), required=True, help="Class.")
@click.option("--links", default="", metavar="TEXT", help="Links of the arm, or their number.")
@click.option("--loops", default="", metavar="TEXT", help="Loops of Type A to D.")
@click.option("--modules", default="", metavar="TEXT", help="Parallel modules.")
@click.option("--name", default="robot", show_default=True, help="Name of the robot.")
@click.option("--cycle", type=PATH, metavar="CSV", help="Duty cycle, as that of `size`.")
@click.option(
    "--payload", type=QuantityRange("kg"), default=0.0, help="Mass at the end effector [kg]."
)
@click.option(
    "--catalogue",
    "catalogues",
    type=PATH,
    multiple=True,
    metavar="CSV",
    help="Drives to choose from, as those of `size`: cylinders, motors, or both.",
)
@margins_option
@click.option("-o", "--output", type=PATH, required=True, metavar="DIR", help="Folder to write.")
@overwrite_option
@json_option
def command(
    robot_class: RobotClass,
    links: str,
    loops: str,
    modules: str,
    name: str,
    cycle: Path | None,
    payload: float,
    catalogues: tuple[Path, ...],
    margins: tuple[str, ...],
    output: Path,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make the robot, run its duty cycle, and write the folder."""
    require_place(output)
    beyond = margins_of(margins)
    if cycle is not None and payload:
        raise click.UsageError("--payload is of the usual cycle; in a file it is a column")
    text = robot_text(robot_class, links, loops, modules, name)
    machine = Robot(parse_description(text, output / "robot.yaml"))
    drives = [read_catalogue(path) for path in catalogues]
    columns = usual_cycle(machine, payload)
    if cycle is None and not len(columns["payload"]):
        raise InputError("the loops close at no place between the limits; give --cycle")
    duty = read_duty(cycle or columns, machine)
    outcome = outcome_of(machine, duty, drives, beyond)
    files: dict[str, str | bytes] = {"robot.yaml": text}
    files["report.md"] = report_text(outcome, robot_class)
    files["picture.svg"] = _picture(machine)
    if cycle is None:
        files["cycle.csv"] = cycle_text(columns)
    write_folder(files, output, overwrite)
    coverage = closure_coverage(machine).describe()
    shown = {
        **facts(outcome),
        "closes": coverage,
        "written": [str(output / name) for name in files],
    }
    words = f"{text_of(outcome)}\n{coverage}\nwritten: {output} ({', '.join(files)})"
    show(shown, as_json, words)
    if cycle is not None:
        tell_unused(cycle, duty)


def _picture(machine: Robot) -> bytes:
    """The robot at its reference, as SVG."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.svg"
        draw(machine, path=path, names="active")
        return path.read_bytes()


def facts(outcome: Outcome) -> dict[str, Any]:
    """The design as plain data."""
    robot = outcome.robot
    loops: dict[str, Any] = {}
    for name, distance in outcome.distances.items():
        loop = robot.description.loops.get(name)
        loops[name] = {"type": None if loop is None else loop.type, "distance": distance}
    drives: dict[str, Any] = {}
    for name, demand in outcome.demands.items():
        ends = [float(demand.position.min()), float(demand.position.max())]
        drives[name] = {"range": ends, "peak": demand.peak, "rms": demand.rms}
        drives[name] |= {"speed": demand.speed, "power": demand.power}
        if name in outcome.sizings:
            drives[name]["sizing"] = facts_of_sizing(outcome.sizings[name])
    return {"name": robot.name, "active": robot.active, "loops": loops, "drives": drives}


def text_of(outcome: Outcome) -> str:
    """The design as text."""
    robot = outcome.robot
    counts = f"{len(robot.active)} active of {len(robot.coordinates)} coordinates"
    rows: list[list[object]] = []
    for name, demand in outcome.demands.items():
        choice = "-"
        if name in outcome.sizings:
            chosen = outcome.sizings[name].chosen
            choice = "none fits" if chosen is None else chosen.name
        rows.append([name, demand.travel, demand.peak, demand.rms, choice])
    drives = table(["drive", "travel", "peak", "rms", "chosen"], rows)
    loops: list[list[object]] = []
    for name, distance in outcome.distances.items():
        loop = robot.description.loops.get(name)
        loops.append([name, "-" if loop is None else loop.type, distance])
    parts = [f"{robot.name}: {counts}, {counted(len(robot.loops), 'loop')}", drives]
    if loops:
        parts.append(table(["loop", "type", "least distance to a singularity"], loops))
    return "\n\n".join(parts) + "\n"
