"""Synthetic bags for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.make import PARTS, simulated, write_trajectory
from hybrid_dynamics_ros.bags.provenance import robot_notes
from hybrid_dynamics_ros.bags.storage.bag_writer import require_new, require_replaceable
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory, read_trajectory

from ..output import show, written
from ..parameters import json_option, loaded, once_each
from ..quantities import QuantityRange
from .common import PATH, robot_option, tell_unused

DEFAULT_SECONDS: Final = 10.0
DEFAULT_RATE: Final = 1000.0  # [Hz]
MAX_DEVIATION: Final = 1e300
HELP: Final = """Write a bag of joint states from a trajectory file, or from a motion of the model
with its efforts."""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics bag make recording --robot forging_chu2020 \\
      --seconds 60 --rate 1000 --noise position=1e-6,effort=2
  hybrid-dynamics bag make recording --robot excavator --trajectory dig.csv
"""


@click.command(epilog=EPILOG, help=HELP, short_help="A bag for trying things out.")
@click.argument("out", type=PATH)
@robot_option
@click.option(
    "--trajectory", type=PATH, metavar="FILE", help="CSV or .npz file, as `simulate --save` writes."
)
@click.option(
    "--seconds", type=QuantityRange("s", 0.01), help="How long, of a simulation [s].  [default: 10]"
)
@click.option(
    "--rate",
    type=QuantityRange("1/s", 0.1, 1e5),
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
    """Make the bag."""
    require_place = require_replaceable if overwrite else require_new
    require_place(out)
    if trajectory is not None and (seconds is not None or rate is not None):
        raise click.UsageError(
            "--seconds and --rate are of a simulation; a trajectory has its own times"
        )
    machine = loaded(robot)
    if trajectory is None:
        motion = simulated(machine, seconds or DEFAULT_SECONDS, rate or DEFAULT_RATE, seed)
    else:
        motion = _motion_of(trajectory, machine)
    noisy = motion.noisy(_deviations(noise), seed)
    count = write_trajectory(out, noisy, topic, robot_notes(robot, machine))
    facts = {"bag": str(out), "topic": topic, "messages": count}
    show(facts, as_json, written(out, f"{counted(count, 'message')} on {topic}"))


def _motion_of(path: Path, robot: Robot) -> Trajectory:
    """The motion of a file; a note names columns that do not fit into a bag of joint states."""
    motion = read_trajectory(path, robot)
    unused = list(motion.unused)
    if motion.acceleration is not None:
        unused = [*(f"{name}.acceleration" for name in robot.active), *unused]
    tell_unused(path, unused)
    return motion


def _deviations(text: str) -> dict[str, float]:
    """Standard deviations by quantity. Raises click.BadParameter."""
    entries = [entry for entry in text.split(",") if entry]
    return once_each("--noise", map(_deviation, entries))


def _deviation(entry: str) -> tuple[str, float]:
    """The quantity and the deviation of a text `PART=DEVIATION`. Raises click.BadParameter."""
    name, _, value = entry.partition("=")
    name = name.strip()
    try:
        deviation = float(value)
    except ValueError as error:
        raise _noise_error(f"'{entry}'") from error
    if name not in PARTS:
        raise _noise_error(f"there is no part '{name}'{suggestion(name, PARTS)}")
    if not 0.0 <= deviation < MAX_DEVIATION:
        raise _noise_error(f"'{entry}' is no deviation of 0 or more")
    return name, deviation


def _noise_error(problem: str) -> click.BadParameter:
    """The error about --noise, with the correct form."""
    parts = ", ".join(PARTS)
    expected = f"expected PART=DEVIATION with the parts {parts}, as position=1e-6,effort=2"
    return click.BadParameter(
        f"{problem}; {expected} (rad or m, per second, N m or N)", param_hint="--noise"
    )
