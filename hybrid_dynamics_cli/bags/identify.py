"""Identification of parameters from recorded efforts."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_core.dynamics.parameters import Parameters
from hybrid_dynamics_core.identification import TooLittleShownError
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.identification_result import IdentificationResult
from hybrid_dynamics_ros.bags.analysis.identify import identify_recording, requested_parameters
from hybrid_dynamics_ros.bags.analysis.recording import EvaluatedRecording
from hybrid_dynamics_ros.bags.job import SMOOTHINGS
from hybrid_dynamics_ros.bags.settings import read_settings

from ..output import by_name, show, written
from ..parameters import json_option
from ..writing import output_option, overwrite_option, place_for
from .common import (
    LOST,
    PATH,
    bag_robot_option,
    params_option,
    span_of,
    span_options,
    tell_losses,
    topic_option,
)
from .identification_text import Numbers, pressure_lines, report_lines, unmeasured_lines

BASE_COLUMNS: Final = ("estimate", "low", "high", "physical", "file")
EFFORT_COLUMNS: Final = ("recorded", "left_by_file", "left_by_estimate", "explained")
HELP: Final = """Base parameters and friction from the recorded efforts of BAG: what is
determined, and how well.

The last part of the bag is held out: what the estimates leave unexplained there is told beside
what the robot file leaves; where that is more, nothing is offered as determined. Samples that
do not fit the motion around them, or whose efforts noise does not explain, are left out and
named. Exits with 3 where a part of BAG could not be read.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics bag identify recording --robot excavator
  hybrid-dynamics bag identify recording --robot excavator \\
      --friction boom_cylinder,stick_cylinder --hold-out 0.3 --json
  hybrid-dynamics bag identify recording --robot excavator --from 0.5 --to 4.5
"""


@click.command(
    epilog=EPILOG, help=HELP, short_help="Parameters of the robot from recorded efforts."
)
@click.argument("bag", type=PATH)
@bag_robot_option
@topic_option
@params_option
@span_options
@click.option(
    "--smooth",
    type=click.Choice(SMOOTHINGS),
    default="spline",
    show_default=True,
    help="How accelerations are found.",
)
@click.option(
    "--friction",
    metavar="JOINTS",
    default="",
    help="Joints whose friction is asked for, or all.  [default: none]",
)
@click.option(
    "--links", metavar="LINKS", default="", help="Links whose inertia is asked for.  [default: all]"
)
@click.option(
    "--hold-out",
    type=click.FloatRange(0.05, 0.9),
    default=0.25,
    show_default=True,
    help="Share of the bag to test on.",
)
@click.option(
    "--samples",
    type=click.IntRange(100),
    default=5000,
    show_default=True,
    help="Most samples that are used.",
)
@output_option(help="Write the base parameters to this CSV file too.")
@overwrite_option
@click.option(
    "--all", "everything", is_flag=True, help="Tell what is not determined too, and all terms."
)
@json_option
@click.pass_context
def command(  # noqa: PLR0913, PLR0917 - an argument for each option
    context: click.Context,
    bag: Path,
    robot: str | None,
    topic: str | None,
    params: Path | None,
    start: float,
    end: float,
    smooth: str,
    friction: str,
    links: str,
    hold_out: float,
    samples: int,
    output: str | None,
    overwrite: bool,
    everything: bool,
    as_json: bool,
) -> None:
    """Identify, print, and write the base parameters if requested."""
    place = None
    if output is not None:
        place = place_for(output, (".csv",), [bag], overwrite=overwrite)
    span = span_of(start, end)
    recording = collect(bag, robot, topic, smooth, read_settings(params), samples, span=span)
    machine = recording.robot
    joints = machine.active if friction == "all" else _names(friction)
    parameters = requested_parameters(machine, _names(links), joints)
    result = _identify(recording, parameters, hold_out)
    base = base_rows(result)
    efforts = effort_rows(result)
    lines = report_lines(result, base, efforts, machine.joint_types, everything=everything)
    first = pressure_lines(recording.pressure_source)
    lines = [*first, *unmeasured_lines(machine.active, result.joints), *lines]
    counts = recording.counts
    if counts.wraps:
        lines += ["", f"samples: {counts.summary()}"]
    if place is not None:
        write_base(place, base)
        lines += ["", written(place, "the base parameters")]
    answer = facts(result, base, efforts, recording.losses)
    answer |= {"summary": counts.summary(), "from_pressures": list(recording.pressed)}
    show(answer, as_json, "\n".join(lines))
    tell_losses(recording.losses)
    if recording.losses:
        context.exit(LOST)


def base_rows(result: IdentificationResult) -> Numbers:
    """By base parameter: estimate, interval, physical value and value in the robot file."""
    others = zip(result.physical.tolist(), result.file_values.tolist(), strict=True)
    rows = {}
    for (name, estimate), other in zip(result.identification.table().items(), others, strict=True):
        rows[name] = (*estimate, *other)
    return rows


def effort_rows(result: IdentificationResult) -> Numbers:
    """By joint: deviations of held-out efforts and of both residuals, and explained share."""
    columns = (
        result.effort_deviation,
        result.file_residual,
        result.residual,
        result.explained,
    )
    rows = {}
    for k, name in enumerate(result.joints):
        rows[name] = tuple(float(column[k]) for column in columns)
    return rows


def facts(
    result: IdentificationResult, base: Numbers, efforts: Numbers, losses: list[str]
) -> dict[str, Any]:
    """The whole result as plain data, for JSON."""
    identification = result.identification
    return {
        "worse_than_file": list(result.worse_than_file),
        "left_out": [asdict(sample) for sample in result.excluded],
        "determined": list(result.determined),
        "bodiless": list(result.unphysical),
        "unsettled": list(result.undetermined),
        "base": {name: by_name(BASE_COLUMNS, row) for name, row in base.items()},
        "parameters": by_name(identification.parameters.names, identification.values),
        "condition": identification.condition,
        "losses": losses,
        "held_out": {name: by_name(EFFORT_COLUMNS, row) for name, row in efforts.items()},
    }


def write_base(place: Path, base: Numbers) -> None:
    """Write all base parameters as CSV."""
    lines = [",".join(("name", *BASE_COLUMNS))]
    for name, row in base.items():
        lines.append(",".join([f'"{name}"', *map(repr, row)]))
    place.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _names(text: str) -> tuple[str, ...]:
    """The names of a comma-separated list."""
    names = [name.strip() for name in text.split(",")]
    return tuple(name for name in names if name)


def _identify(
    recording: EvaluatedRecording, parameters: Parameters, hold_out: float
) -> IdentificationResult:
    """Identify; an error names the options that reduce the number of parameters."""
    try:
        return identify_recording(recording, parameters, hold_out)
    except TooLittleShownError as error:
        last = parameters.links[-1]
        raise click.ClickException(
            f"{error}: with --links, as --links {last}, inertias of these links alone are asked"
            " for, and those of the others are taken from the robot file"
        ) from error
