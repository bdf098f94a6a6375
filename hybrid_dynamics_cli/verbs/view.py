"""The robot in the browser."""

from __future__ import annotations

import signal
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import InputError

from ..bags.common import LOST, tell_losses, tell_unused
from ..parameters import loaded, robot_argument
from .bag import missing

if TYPE_CHECKING:
    from hybrid_dynamics_core.view.motion import Motion
    from hybrid_dynamics_ros.bags.analysis.recording import EvaluatedRecording

FILE = click.Path(path_type=Path)

HELP = """\
Show the robot in the browser, until Ctrl-C: sliders for its active joints, loops that close live,
efforts.

With a trajectory or a bag, the motion is played back with the efforts that it takes.
"""
EPILOG = """\b
Examples:
  hybrid-dynamics view forging_chu2020
  hybrid-dynamics view my_robot.yaml --port 9000 --no-browser
  hybrid-dynamics view excavator --trajectory dig.csv
  hybrid-dynamics view forging_chu2020 --bag recording --topic /joint_states

\b
Exit codes: 0 after Ctrl-C, 1 where nothing can be shown, 2 where the call is
wrong or the port is in use, 3 after Ctrl-C where something of the bag could
not be read.
"""


@click.command(help=HELP, epilog=EPILOG, short_help="Show the robot in the browser.")
@robot_argument
@click.option(
    "--trajectory",
    type=FILE,
    metavar="FILE",
    help="CSV or .npz file to play back, as `simulate --save` writes.",
)
@click.option("--bag", type=FILE, help="Recording (rosbag2) to play back.")
@click.option(
    "--topic",
    metavar="T",
    help="Topic of the joint states in the bag, where it is not the node's own.",
)
@click.option(
    "--host",
    default="localhost",
    show_default=True,
    help="Address to listen at; 0.0.0.0 for the network.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8080,
    show_default=True,
    help="Port to listen at; 0 for any free.",
)
@click.option(
    "--skeleton",
    is_flag=True,
    help="Show bars and plates between joints at first, in place of the robot's visuals.",
)
@click.option("--browser/--no-browser", default=True, help="Open the page in the browser.")
@click.pass_context
def command(
    context: click.Context,
    robot: str,
    trajectory: Path | None,
    bag: Path | None,
    topic: str | None,
    host: str,
    port: int,
    skeleton: bool,
    browser: bool,
) -> None:
    """Show the robot in the browser, until Ctrl-C."""
    # viser is an extra.
    from hybrid_dynamics_core.view import open_viewer  # noqa: PLC0415

    if trajectory is not None and bag is not None:
        raise click.UsageError("--trajectory and --bag cannot be shown together: give one of them")
    if topic is not None and bag is None:
        raise click.UsageError("--topic is the topic of a bag: give --bag too")
    # SIGINT too, which background jobs of a shell ignore.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    losses: list[str] = []
    try:
        machine, motion, losses = what_to_show(robot, trajectory, bag, topic)
        with open_viewer(machine, motion, host=host, port=port, skeleton=skeleton) as viewer:
            tell_losses(losses)
            click.echo(f"{machine.name}: {viewer.url} (end with Ctrl-C)")
            if browser:
                webbrowser.open(viewer.url)
            viewer.run()
    except KeyboardInterrupt:
        click.echo("ended")
    if losses:
        context.exit(LOST)


def what_to_show(
    robot: str, trajectory: Path | None, bag: Path | None, topic: str | None
) -> tuple[Robot, Motion | None, list[str]]:
    """The robot, its motion if any, and notes on unreadable parts of a recording."""
    machine = loaded(robot)
    if bag is not None:
        return _of_bag(robot, bag, topic)
    if trajectory is not None:
        return machine, _of_file(machine, trajectory), []
    return machine, None, []


def _of_file(machine: Robot, path: Path) -> Motion:
    """The motion of a trajectory file.

    Raises:
        click.ClickException: the file holds no trajectory that can be followed.
        InputError: from `read_trajectory` and `motion_of`.
    """
    from hybrid_dynamics_core.control import JointTrajectory  # noqa: PLC0415
    from hybrid_dynamics_core.view.motion import motion_of  # noqa: PLC0415
    from hybrid_dynamics_ros.bags.trajectory_file import read_trajectory  # noqa: PLC0415

    samples = read_trajectory(path, machine)
    try:
        curve = JointTrajectory(
            samples.time, samples.position, samples.velocity, samples.acceleration, at_rest=False
        )
    except InputError as error:  # an error of the file, not of the call
        raise click.ClickException(f"{path}: {error}") from error
    tell_unused(path, samples.unused)
    return motion_of(machine, curve, path.name, samples.effort)


def _of_bag(robot: str, path: Path, topic: str | None) -> tuple[Robot, Motion, list[str]]:
    """The robot, the motion of a recording, and notes on its unreadable parts."""
    from hybrid_dynamics_core.view.motion import Motion  # noqa: PLC0415

    try:
        # rosbags is an extra.
        from hybrid_dynamics_ros.bags.analysis.collect import collect  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise missing(error) from error
    recording = collect(path, robot, topic, smooth=None)
    latest = np.maximum.accumulate(recording.time)
    ascending = np.flatnonzero(np.diff(latest, prepend=-1.0) > 0.0)
    recorded = None
    if np.isfinite(recording.recorded).any():
        recorded = recording.recorded[ascending]
    motion = Motion(
        path.name,
        recording.time[ascending],
        recording.state.rows(ascending),
        recording.acceleration[ascending],
        recorded,
        acceleration_note(recording),
    )
    return recording.robot, motion, recording.losses


def acceleration_note(recording: EvaluatedRecording) -> str:
    """The source of the accelerations of a recording, and their delay.

    The computed efforts have the same delay.
    """
    lag = f"{1e3 * recording.causal_lag:.3g} ms"
    if recording.is_causal and not recording.causal_lag:
        return (
            "The model's accelerations are from the node's Kalman filter: no lag, but too large"
            " where motions are fast. The recording itself, or bag process --smooth spline, is not."
        )
    if recording.is_causal:
        return (
            f"The model's accelerations are from the node's causal filter, {lag} late: waves"
            " between model and file are this lag, not the model. The recording itself, or bag"
            " process --smooth spline, has none."
        )
    source = f"The model's accelerations are from {recording.smoother} through the recording"
    return f"{source}: no lag (the node's filter: {lag})."
