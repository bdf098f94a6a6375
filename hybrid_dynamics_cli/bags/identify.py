"""Parameters from recorded efforts."""

from __future__ import annotations

from pathlib import Path

import click

from hybrid_dynamics_cli.output import show, table
from hybrid_dynamics_cli.parameters import RobotType, json_option, output_path
from hybrid_dynamics_ros.offline.collect import collect
from hybrid_dynamics_ros.offline.identify import identify_track
from hybrid_dynamics_ros.offline.process import SMOOTHINGS
from hybrid_dynamics_ros.offline.settings import read_settings

from .common import LOST, PATH, params_option, tell_losses, topic_option

HELD = ("recorded", "left_by_file", "left_by_estimate", "explained")
EPILOG = """\b
Examples:
  hybrid-dynamics bag identify recording --robot excavator
  hybrid-dynamics bag identify recording --robot excavator --friction q12,q22 --hold-out 0.3 --json
"""


@click.command(epilog=EPILOG)
@click.argument("bag", type=PATH)
@click.option("--robot", type=RobotType(), metavar="ROBOT", help="Robot, or its file; of a processed bag it is known.")
@topic_option
@params_option
@click.option("--smooth", type=click.Choice(SMOOTHINGS), default="spline", help="How accelerations are found.")
@click.option("--friction", metavar="JOINTS", default="", help="Joints whose friction is asked for; or all.")
@click.option("--hold-out", type=click.FloatRange(0.05, 0.9), default=0.25, help="Share of the bag to test on.")
@click.option("--samples", type=click.IntRange(100), default=5000, help="How many samples are used at most.")
@click.option("--output", metavar="FILE", help="Write the base parameters to this CSV file too.")
@json_option
@click.pass_context
def command(  # noqa: PLR0913, PLR0917 - an argument for each option
    context: click.Context,
    bag: Path,
    robot: str | None,
    topic: str | None,
    params: Path | None,
    smooth: str,
    friction: str,
    hold_out: float,
    samples: int,
    output: str | None,
    as_json: bool,
) -> None:
    """Base parameters and friction from the recorded efforts of BAG.

    The last part of the bag is held out: what the estimates leave unexplained there is told beside what the robot file
    leaves.
    """
    place = None if output is None else output_path(output)
    track = collect(bag, robot, topic, smooth, read_settings(params), most=samples)
    joints = track.robot.active if friction == "all" else tuple(name for name in friction.split(",") if name)
    found = identify_track(track, joints, hold_out)
    base = found.result.table()
    rows = [[value, low, high, name] for name, (value, low, high) in base.items()]
    per_joint = [
        [name, float(found.spread[k]), float(found.before[k]), float(found.noise[k]), float(found.explained[k])]
        for k, name in enumerate(track.robot.active)
    ]
    text = [
        f"{found.trained} samples to learn from, {found.held} held out; condition {found.result.condition:.3g}",
        "",
        table(["estimate", "95 % from", "to", "base parameter"], rows),
        "",
        table(["held-out efforts", "recorded", "left by file", "left by estimate", "explained"], per_joint),
    ]
    if 2 * len(found.unsettled) > len(found.meant):
        text += ["", excites_too_little(len(found.unsettled), len(found.meant))]
    told = {
        "unsettled": list(found.unsettled),
        "base": {name: {"estimate": v, "low": low, "high": high} for name, (v, low, high) in base.items()},
        "parameters": dict(zip(found.result.parameters.names, found.result.values, strict=True)),
        "condition": found.result.condition,
        "losses": track.losses,
        "held_out": {name: dict(zip(HELD, numbers, strict=True)) for name, *numbers in per_joint},
    }
    show(told, as_json, "\n".join(text))
    if place is not None:
        lines = ["name,estimate,low,high", *(f'"{name}",{v!r},{low!r},{high!r}' for v, low, high, name in rows)]
        place.write_text("\n".join(lines) + "\n", encoding="utf-8")
    tell_losses(track.losses)
    if track.losses:
        context.exit(LOST)


def excites_too_little(unsettled: int, meant: int) -> str:
    """What to do where most intervals do not even tell the sign."""
    return (
        f"The motion excites too little for the noise: of {meant} base parameters that are not 0 in the robot file the "
        f"intervals of {unsettled} contain 0. Record a motion that moves every joint, faster and farther, or a longer "
        "one."
    )
