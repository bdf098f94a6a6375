"""Bags for trying things out."""

from __future__ import annotations

from pathlib import Path

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_ros.bags.make import PARTS, simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import INPUT
from hybrid_dynamics_ros.bags.provenance import robot_notes
from hybrid_dynamics_ros.bags.storage.bag_writer import require_new, require_replaceable
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory, read_trajectory

from ..output import show, written
from ..parameters import json_option, loaded
from .common import PATH, robot_option, tell_unused

EPILOG = """\b
Examples:
  hybrid-dynamics bag make recording --robot forging_chu2020 \\
      --seconds 60 --rate 1000 --noise position=1e-6,effort=2
  hybrid-dynamics bag make recording --robot excavator --trajectory dig.csv
"""


@click.command(epilog=EPILOG, short_help="A bag for trying things out.")
@click.argument("out", type=PATH)
@robot_option
@click.option(
    "--trajectory", type=PATH, metavar="FILE", help="CSV or .npz file, as `simulate --save` writes."
)
@click.option(
    "--seconds", type=click.FloatRange(0.01), help="How long, of a simulation [s].  [default: 10]"
)
@click.option(
    "--rate",
    type=click.FloatRange(0.1, 1e5),
    help="Messages a second, of a simulation.  [default: 1000]",
)
@click.option(
    "--noise",
    metavar="PART=DEVIATION",
    default="",
    help="White noise, as position=1e-6,velocity=1e-4,effort=2.  [default: none]",
)
@click.option(
    "--seed", type=int, default=0, show_default=True, help="Of the random motion and noise."
)
@click.option("--topic", default=INPUT, show_default=True, metavar="T", help="Topic.")
@click.option("--overwrite", is_flag=True, help="Replace a bag that is there already.")
@json_option
def command(  # noqa: PLR0913, PLR0917 - an argument for each option
    out: Path,
    robot: str,
    trajectory: Path | None,
    seconds: float | None,
    rate: float | None,
    noise: str,
    seed: int,
    topic: str,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Write a bag of joint states from a trajectory file, or from a motion of the model with its efforts."""
    (require_replaceable if overwrite else require_new)(out)
    if trajectory is not None and (seconds, rate) != (None, None):
        raise click.UsageError(
            "--seconds and --rate are of a simulation; a trajectory has its own times"
        )
    machine = loaded(robot)
    if trajectory is None:
        motion = simulated(
            machine, 10.0 if seconds is None else seconds, 1000.0 if rate is None else rate, seed
        )
    else:
        motion = _of_file(trajectory, machine)
    count = write_trajectory(
        out, motion.noisy(_deviations(noise), seed), topic, robot_notes(robot, machine)
    )
    told = {"bag": str(out), "topic": topic, "messages": count}
    show(told, as_json, written(out, f"{counted(count, 'message')} on {topic}"))


def _of_file(path: Path, robot: Robot) -> Trajectory:
    """The trajectory; what a bag of joint states does not hold is told."""
    motion = read_trajectory(path, robot)
    pushes = (
        [] if motion.acceleration is None else [f"{name}.acceleration" for name in robot.active]
    )
    tell_unused(path, [*pushes, *motion.unused])
    return motion


def _no_noise(problem: str) -> click.BadParameter:
    """What is wrong, and the form that is taken."""
    expected = (
        f"expected PART=DEVIATION with the parts {', '.join(PARTS)}, as position=1e-6,effort=2"
    )
    return click.BadParameter(
        f"{problem}; {expected} (rad or m, per second, N m or N)", param_hint="--noise"
    )


def _deviations(text: str) -> dict[str, float]:
    found = {}
    for part in (entry for entry in text.split(",") if entry):
        name, _, value = part.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError as error:
            raise _no_noise(f"'{part}'") from error
        if name.strip() not in PARTS:
            raise _no_noise(f"there is no part '{name.strip()}'{suggestion(name.strip(), PARTS)}")
        if not 0.0 <= found[name.strip()] < 1e300:
            raise _no_noise(f"'{part}' is no deviation of 0 or more")
    return found
