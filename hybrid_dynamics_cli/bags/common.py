"""What the verbs for bags share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from hybrid_dynamics_core.ground.wording import counted

from ..exit_codes import LOST
from ..parameters import RobotType

__all__ = [
    "LOST",
    "PATH",
    "first_few",
    "known_robot_option",
    "params_option",
    "robot_option",
    "span_of",
    "span_options",
    "tell_losses",
    "tell_unused",
    "topic_option",
]

PATH = click.Path(path_type=Path)
robot_option = click.option(
    "--robot", type=RobotType(), required=True, metavar="ROBOT", help="Robot (a name or its file)."
)
known_robot_option = click.option(
    "--robot",
    type=RobotType(),
    metavar="ROBOT",
    help=(
        "Robot (a name or its file) that the recording is held against; left out, the one that the"
        " bag was made or processed with, as noted in it."
    ),
)
topic_option = click.option(
    "--topic",
    metavar="T",
    help="Topic of the joint states.  [default: the node's own, or the only one]",
)
params_option = click.option(
    "--params",
    type=PATH,
    metavar="FILE",
    help="Parameter file of the node.  [default: the node's defaults]",
)
FEW = 4  # names in a line


def span_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """--from and --to."""
    after = "[s] since the first stamp of the bag."
    ends = (("--to", "end", math.inf, "Last", "the end"), ("--from", "start", 0.0, "First", "0"))
    for name, key, default, text, shown in ends:
        kind = click.FloatRange(0.0)
        help_text = f"{text} time that counts, {after}  [default: {shown}]"
        function = click.option(name, key, type=kind, default=default, metavar="S", help=help_text)(
            function
        )
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
        click.echo(
            f"{path}: {counted(len(columns), 'column')} not used: {first_few(columns)}", err=True
        )


def tell_losses(losses: Sequence[str]) -> None:
    """Print what could not be read."""
    for loss in losses:
        click.echo(f"lost: {loss}", err=True)
