"""A page about a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from hybrid_dynamics_core.ground.units import effort_unit
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural
from hybrid_dynamics_ros.bags.analysis.collect import Track, collect
from hybrid_dynamics_ros.bags.analysis.effort_error import EffortError, effort_errors
from hybrid_dynamics_ros.bags.process import SMOOTHINGS
from hybrid_dynamics_ros.bags.settings import read_settings

from ..output import show, table, written
from ..parameters import json_option
from ..writing import output_option, overwrite_option, place_for
from .common import (
    LOST,
    PATH,
    known_robot_option,
    params_option,
    span_of,
    span_options,
    tell_losses,
    topic_option,
)

EPILOG = """\b
Examples:
  hybrid-dynamics bag report recording --robot excavator
  hybrid-dynamics bag report results --output shift_12.html
"""


@click.command(epilog=EPILOG, short_help="One HTML page about a recording.")
@click.argument("bag", type=PATH)
@known_robot_option
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
    """One HTML page about BAG: motion, efforts computed and recorded, energy, loops, strokes, gaps, bad samples.

    BAG is a recording with joint states, or what `bag process` wrote (with --keep, where efforts
    were recorded).
    """
    try:
        from hybrid_dynamics_ros.bags.analysis.report import (  # noqa: PLC0415 - matplotlib is an extra
            write_report,
        )
    except ModuleNotFoundError as error:
        raise click.ClickException("reports need matplotlib: pip install matplotlib") from error
    place = place_for(output or beside(bag), (".html",), [bag], overwrite=overwrite)
    track = collect(bag, robot, topic, smooth, read_settings(params), span=span_of(start, end))
    write_report(track, bag.resolve().name, place)
    summary, apart = track.counts.summary(), effort_errors(track)
    told = {
        "page": str(place),
        "received": track.counts.received,
        "accepted": track.counts.accepted,
        "summary": summary,
        "smooth": track.smooth,
        "stamps": {
            "nominal": track.stamps.nominal,
            "longest": track.stamps.longest,
            "missing": sum(count for _, _, count in track.stamps.missing),
            "gaps": len(track.gaps),
        },
        "efforts": {error.joint: error.facts for error in apart},
        "strays": [outlier.describe(track.measured, track.start_ns) for outlier in track.outliers],
        "losses": track.losses,
    }
    show(
        told,
        as_json,
        "\n".join(
            [
                written(place, f"report: {summary}"),
                *efforts_of(track, apart),
                *off_the_motion(track),
            ]
        ),
    )
    tell_losses(track.losses)
    if track.losses:
        context.exit(LOST)


def beside(bag: Path) -> Path:
    """The page of a bag, as the bag was named; `.` and `..` have no name of their own."""
    return (bag.resolve() if bag.name in ("", "..") else bag).with_suffix(".html")


def efforts_of(track: Track, apart: Sequence[EffortError]) -> list[str]:
    """How far recorded and computed efforts are apart, a row a joint."""
    if not apart:
        why = "; `bag process --keep` takes those of the recording over" if track.computed else ""
        return [f"no recorded efforts to compare with{why}"]
    rows = [
        [
            s.joint,
            s.median,
            s.near,
            s.rms,
            f"{s.far} of {s.count}",
            s.limit,
            effort_unit(track.robot.joint_types[s.joint]),
        ]
        for s in apart
    ]
    return [
        "",
        table(
            ["effort error", "50 % within", "95 % within", "RMS", "far off", "beyond", "unit"], rows
        ),
    ]


def off_the_motion(track: Track) -> list[str]:
    """How many samples have positions or velocities that do not fit the motion around them."""
    if track.smooth == "causal":
        return []
    count = len(track.outliers)
    return [
        "",
        (
            f"{counted(count, 'sample')} with positions or velocities off the motion around"
            f" {singular_or_plural(count, 'it', 'them')}"
        ),
    ]
