"""The smallest drive of a catalogue that meets a duty cycle."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.sizing import Sizing, read_catalogue, read_duty, size_drive

from ...bags.common import PATH
from ...exit_codes import FAILED
from ...output import number, show, table
from ...parameters import json_option, loaded, robot_argument
from .cycle import tell_unused
from .margins import margins_of, margins_option

HELP: Final = """\
The smallest drive of a catalogue that meets a duty cycle, and what each of them lacks.

CYCLE is a CSV file with a column for each active coordinate, or for as many others that determine
the motion. Active coordinates that are left out stay at the reference. Further columns are time,
NAME.velocity and NAME.acceleration, payload [kg], force.x to force.z and moment.x to moment.z on
the end effector, and weight. Rates that are left out follow from time; without it they are zero.

CATALOGUE is a CSV file of cylinders (name, bore, rod, stroke; retracted, pressure, speed, modulus,
length, mass) or of motors (name, torque, speed; peak_torque, power, inertia, gear_ratio,
efficiency, lead, mass). Values are in SI units, unless the header names another: `bore [mm]`.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics size excavator --drive boom_cylinder --cycle digging.csv \\
      --catalogue cylinders.csv --margin pressure=1.2 --margin stroke=20*mm
  hybrid-dynamics size delta --drive theta_A --cycle picking.csv \\
      --catalogue motors.csv --margin rms=1.2 --json

Ends with 1 where no drive of the catalogue fits.
"""


@click.command(help=HELP, epilog=EPILOG, short_help="The smallest drive for a duty cycle.")
@robot_argument
@click.option("--cycle", type=PATH, required=True, metavar="CSV", help="The duty cycle.")
@click.option("--catalogue", type=PATH, required=True, metavar="CSV", help="The drives.")
@click.option("--drive", required=True, metavar="NAME", help="The joint that is driven.")
@margins_option
@json_option
@click.pass_context
def command(
    context: click.Context,
    robot: str,
    cycle: Path,
    catalogue: Path,
    drive: str,
    margins: tuple[str, ...],
    as_json: bool,
) -> None:
    """Size a drive, and print what each row of the catalogue gives."""
    beyond = margins_of(margins)
    machine = loaded(robot)
    drives = read_catalogue(catalogue)
    duty = read_duty(cycle, machine)
    sizing = size_drive(machine, duty, drives, drive, beyond)
    show(facts(sizing), as_json, text(sizing))
    tell_unused(cycle, duty)
    if sizing.chosen is None:
        context.exit(FAILED)


def facts(sizing: Sizing) -> dict[str, Any]:
    """The result as plain data."""
    demand = sizing.demand
    candidates: list[dict[str, Any]] = []
    for one in sizing.candidates:
        checks: dict[str, Any] = {}
        for check in one.checks:
            checks[check.quantity] = {**asdict(check), "fits": check.fits}
            del checks[check.quantity]["quantity"]
        lacking = [check.text for check in one.lacking]
        candidates.append(
            {"name": one.name, "fits": one.fits, "checks": checks, "lacking": lacking}
        )
    chosen = sizing.chosen
    return {
        "drive": demand.drive,
        "chosen": None if chosen is None else chosen.name,
        "demand": {
            "lowest": float(demand.position.min()),
            "highest": float(demand.position.max()),
            "speed": demand.speed,
            "peak": demand.peak,
            "rms": demand.rms,
            "power": demand.power,
        },
        "margins": asdict(sizing.margins),
        "candidates": candidates,
    }


def text(sizing: Sizing) -> str:
    """What is needed, the used shares of each drive, and what each lacks."""
    demand = sizing.demand
    unit = effort_unit(demand.kind)
    place = coordinate_unit(demand.kind)
    motion = f"{number(demand.travel)} {place} of travel, up to {number(demand.speed)} {place}/s"
    force = f"{number(demand.peak)} {unit} at most, {number(demand.rms)} {unit} rms"
    lines = [
        f"{demand.drive}: {motion}",
        f"  {force}, {number(demand.power)} W",
        "",
        "share of what each has that the cycle needs, with its margin [%]",
        _shares(sizing),
        "",
    ]
    for one in sizing.candidates:
        lines += [f"{one.name} fails: {check.text}" for check in one.lacking]
    chosen = sizing.chosen
    if chosen is None:
        lines.append("none of the catalogue fits")
    else:
        lines.append(f"the smallest that fits: {chosen.name}")
    return "\n".join(lines)


def _shares(sizing: Sizing) -> str:
    """A table of the used shares of each drive."""
    quantities: list[str] = []
    for one in sizing.candidates:
        quantities += [check.quantity for check in one.checks]
    head = list(dict.fromkeys(quantities))
    rows: list[list[object]] = []
    for one in sizing.candidates:
        shares: dict[str, str] = {}
        for check in one.checks:
            shares[check.quantity] = number(round(100.0 * check.share, 1))
        verdict = "fits" if one.fits else "fails"
        rows.append([one.name, verdict, *(shares.get(name, "-") for name in head)])
    return table(["drive", "", *head], rows)
