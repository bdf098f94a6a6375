"""The HTML report about a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_core.ground.units import effort_unit
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.effort_error import EffortError, effort_errors
from hybrid_dynamics_ros.bags.analysis.recording import EvaluatedRecording
from hybrid_dynamics_ros.bags.job import SMOOTHINGS
from hybrid_dynamics_ros.bags.settings import read_settings

from ..output import show, table, written
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
from .identification_text import pressure_lines

ERROR_HEAD: Final = (
    "effort error",
    "50 % within",
    "95 % within",
    "RMS",
    "far off",
    "beyond",
    "unit",
)
HELP: Final = """One HTML page about BAG: motion, efforts computed and recorded, energy, loops,
strokes, gaps, bad samples.

BAG is a recording with joint states, or what `bag process` wrote (with --keep, where efforts
were recorded).
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics bag report recording --robot excavator
  hybrid-dynamics bag report results --output shift_12.html
"""


@click.command(epilog=EPILOG, help=HELP, short_help="One HTML page about a recording.")
@click.argument("bag", type=PATH)
@bag_robot_option
@topic_option
@params_option
@span_options
@click.option(
    "--smooth",
    type=click.Choice(SMOOTHINGS),
    help=(
        "How rates are found; causal: as the node.  [default: spline, without lag; of a processed"
        " bag as it was made]"
    ),
)
@output_option(help="The page.  [default: BAG.html beside the bag]")
@overwrite_option
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
    smooth: str | None,
    output: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Write the page."""
    try:
        # Matplotlib is an extra.
        from hybrid_dynamics_ros.bags.analysis.report import write_report  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise click.ClickException("reports need matplotlib: pip install matplotlib") from error
    place = place_for(output or page_of(bag), (".html",), [bag], overwrite=overwrite)
    span = span_of(start, end)
    recording = collect(bag, robot, topic, smooth, read_settings(params), span=span)
    write_report(recording, bag.resolve().name, place)
    errors = effort_errors(recording)
    lines = [
        written(place, f"report: {recording.counts.summary()}"),
        *pressure_lines(recording.pressure_source),
        *error_lines(recording, errors),
        *outlier_lines(recording),
    ]
    show(facts(recording, errors, place), as_json, "\n".join(lines))
    tell_losses(recording.losses)
    if recording.losses:
        context.exit(LOST)


def page_of(bag: Path) -> Path:
    """Path of the report next to a bag, with the bag's name; `.` and `..` are resolved."""
    if bag.name in ("", ".."):
        bag = bag.resolve()
    return bag.with_suffix(".html")


def facts(
    recording: EvaluatedRecording, errors: Sequence[EffortError], place: Path
) -> dict[str, Any]:
    """The contents of the report as plain data, for JSON."""
    stamps = recording.stamps
    joints, start_ns = recording.measured, recording.start_ns
    return {
        "page": str(place),
        "received": recording.counts.received,
        "accepted": recording.counts.accepted,
        "summary": recording.counts.summary(),
        "smooth": recording.smooth,
        "stamps": {
            "nominal": stamps.nominal,
            "longest": stamps.longest,
            "missing": stamps.missing_count,
            "gaps": len(recording.gaps),
        },
        "from_pressures": list(recording.pressed),
        "efforts": {error.joint: error.facts for error in errors},
        "strays": [outlier.describe(joints, start_ns) for outlier in recording.outliers],
        "losses": recording.losses,
    }


def error_lines(recording: EvaluatedRecording, errors: Sequence[EffortError]) -> list[str]:
    """The table of deviations between recorded and computed efforts, one row per joint."""
    if errors:
        rows = [_error_row(recording, error) for error in errors]
        return ["", table(ERROR_HEAD, rows)]
    text = "no recorded efforts to compare with"
    if recording.is_computed:
        text += "; `bag process --keep` takes those of the recording over"
    return [text]


def _error_row(recording: EvaluatedRecording, error: EffortError) -> list[object]:
    return [
        error.joint,
        error.median,
        error.near,
        error.rms,
        f"{error.far} of {error.count}",
        error.limit,
        effort_unit(recording.robot.joint_types[error.joint]),
    ]


def outlier_lines(recording: EvaluatedRecording) -> list[str]:
    """Numbers of samples whose positions or velocities contradict the neighbouring samples."""
    if recording.is_causal:
        return []
    count = len(recording.outliers)
    them = singular_or_plural(count, "it", "them")
    samples = counted(count, "sample")
    return ["", f"{samples} with positions or velocities off the motion around {them}"]
