"""A page about a recording."""

from __future__ import annotations

from pathlib import Path

import click

from hybrid_dynamics_cli.output import show
from hybrid_dynamics_cli.parameters import RobotType, json_option, new_file, output_path
from hybrid_dynamics_ros.offline.collect import collect
from hybrid_dynamics_ros.offline.process import SMOOTHINGS
from hybrid_dynamics_ros.offline.settings import read_settings

from .common import LOST, PATH, overwrite_option, params_option, span_of, span_options, tell_losses, topic_option

EPILOG = """\b
Examples:
  hybrid-dynamics bag report recording --robot excavator
  hybrid-dynamics bag report results --output shift_12.html
"""


@click.command(epilog=EPILOG)
@click.argument("bag", type=PATH)
@click.option("--robot", type=RobotType(), metavar="ROBOT", help="Robot, or its file; of a processed bag it is known.")
@topic_option
@params_option
@span_options
@click.option(
    "--smooth",
    type=click.Choice(SMOOTHINGS),
    help="How rates are found; causal: as the node. Unless given spline (no lag); of a processed bag as it was made.",
)
@click.option("--output", metavar="FILE", help="The page; BAG.html beside the bag, made anew, unless given.")
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

    BAG is a recording with joint states, or what `bag process` wrote (with --keep, where efforts were recorded).
    """
    try:
        from hybrid_dynamics_ros.offline.report import write_report  # noqa: PLC0415 - matplotlib is an extra
    except ModuleNotFoundError as error:
        raise click.ClickException("reports need matplotlib: pip install matplotlib") from error
    beside = bag.resolve().with_suffix(".html")  # made anew with each report
    place = new_file(output, ".html", overwrite) if output else output_path(str(beside))
    track = collect(bag, robot, topic, smooth, read_settings(params), span=span_of(start, end))
    write_report(track, bag.resolve().name, place)
    summary = track.counts.summary()
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
        "strays": [stray.told(track.measured, track.start_ns) for stray in track.strays],
        "losses": track.losses,
    }
    show(told, as_json, f"{place}: {summary}")
    tell_losses(track.losses)
    if track.losses:
        context.exit(LOST)
