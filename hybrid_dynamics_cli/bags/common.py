"""What the verbs for bags share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from hybrid_dynamics_cli.exits import LOST
from hybrid_dynamics_cli.parameters import RobotType
from hybrid_dynamics_core.description.wording import counted

__all__ = [
    "LOST",
    "PATH",
    "first_few",
    "overwrite_option",
    "params_option",
    "robot_option",
    "span_of",
    "span_options",
    "tell_losses",
    "tell_unused",
    "topic_option",
]

PATH = click.Path(path_type=Path)
robot_option = click.option("--robot", type=RobotType(), required=True, metavar="ROBOT", help="Robot, or its file.")
topic_option = click.option("--topic", metavar="T", help="Topic of the joint states, where it is not the node's own.")
params_option = click.option(
    "--params", type=PATH, metavar="FILE", help="Parameter file of the node; its defaults unless given."
)
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace the file of --output if it is there.")
FEW = 4  # names in a line


def span_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """--from and --to."""
    after = "[s] since the first stamp of the bag."
    for name, key, default, text in (("--to", "end", math.inf, "Last"), ("--from", "start", 0.0, "First")):
        kind = click.FloatRange(0.0)
        help_text = f"{text} time that counts, {after}"
        function = click.option(name, key, type=kind, default=default, metavar="S", help=help_text)(function)
    return function


def span_of(start: float, end: float) -> tuple[float, float]:
    """The span of --from and --to; it is not empty."""
    if not start < end:
        raise click.BadParameter(f"{end:g} s is not after --from {start:g} s", param_hint="--to")
    return start, end


def first_few(names: Sequence[str]) -> str:
    """The first few names, and how many more there are."""
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return ", ".join(names[:FEW]) + more


def tell_unused(path: Path, columns: Sequence[str]) -> None:
    """Print which columns of a trajectory file count for nothing: the first few, and how many more there are."""
    if columns:
        click.echo(f"{path}: {counted(len(columns), 'column')} not used: {first_few(columns)}", err=True)


def tell_losses(losses: Sequence[str]) -> None:
    """Print what could not be read."""
    for loss in losses:
        click.echo(f"lost: {loss}", err=True)
