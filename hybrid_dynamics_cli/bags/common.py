"""What the verbs for bags share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from hybrid_dynamics_cli.exits import LOST
from hybrid_dynamics_cli.parameters import RobotType

__all__ = ["LOST", "PATH", "params_option", "robot_option", "tell_losses", "tell_unused", "topic_option"]

robot_option = click.option("--robot", type=RobotType(), required=True, metavar="ROBOT", help="Robot, or its file.")
topic_option = click.option("--topic", metavar="T", help="Topic of the joint states, where it is not the node's own.")
params_option = click.option(
    "--params", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Parameter file of the node."
)
PATH = click.Path(path_type=Path)


def tell_unused(path: Path, columns: Sequence[str]) -> None:
    """Print which columns of a trajectory file count for nothing."""
    if columns:
        click.echo(f"{path}: not used: {', '.join(columns)}", err=True)


def tell_losses(losses: Sequence[str]) -> None:
    """Print what could not be read."""
    for loss in losses:
        click.echo(f"lost: {loss}", err=True)
