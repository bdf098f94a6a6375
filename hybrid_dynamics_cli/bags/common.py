"""Options and output shared by the verbs for bags."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from hybrid_dynamics_core.ground.file_kinds import FileKind
from hybrid_dynamics_core.ground.wording import counted

from ..exit_codes import LOST
from ..parameters import RobotType
from ..quantities import QuantityRange
from ..robot_options import require_robot, with_robot_options

__all__ = [
    "BAGS",
    "LOST",
    "MAX_LISTED",
    "PATH",
    "bag_robot_option",
    "list_names",
    "no_topic",
    "params_option",
    "robot_option",
    "span_of",
    "span_options",
    "tell_losses",
    "tell_unused",
    "topic_option",
]

BAGS = (FileKind.BAG, FileKind.BAGS, FileKind.BAG_PART)
MAX_LISTED = 4  # names in a line
PATH = click.Path(path_type=Path)
robot_option = with_robot_options(
    click.option(
        "--robot",
        type=RobotType(),
        required=True,
        metavar="ROBOT",
        help="Robot (a name or its file).",
    )
)
bag_robot_option = with_robot_options(
    click.option(
        "--robot",
        type=RobotType(),
        metavar="ROBOT",
        callback=require_robot,
        help=(
            "Robot (a name or its file) that the recording is held against; left out, the one that"
            " the bag was made or processed with, as noted in it."
        ),
    )
)


def no_topic(topic: str | None, path: Path) -> None:
    """Raise click.BadParameter for a topic of a file that has none."""
    if topic is not None:
        problem = f"{path} is no bag, and has no topics"
        raise click.BadParameter(problem, param_hint="--topic")


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
_from_option = click.option(
    "--from",
    "start",
    type=QuantityRange("s"),
    default=0.0,
    metavar="S",
    help="First time that counts, [s] since the first stamp of the bag.  [default: 0]",
)
_to_option = click.option(
    "--to",
    "end",
    type=QuantityRange("s"),
    default=math.inf,
    metavar="S",
    help="Last time that counts, [s] since the first stamp of the bag.  [default: the end]",
)


def span_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options --from and --to."""
    return _from_option(_to_option(function))


def span_of(start: float, end: float) -> tuple[float, float]:
    """The span of --from and --to [s]. Raises click.BadParameter if it is empty."""
    if not start < end:
        raise click.BadParameter(f"{end:g} s is not after --from {start:g} s", param_hint="--to")
    return start, end


def list_names(names: Sequence[str]) -> str:
    """The first names of a list, and the number of the others."""
    text = ", ".join(names[:MAX_LISTED])
    if len(names) > MAX_LISTED:
        text += f" and {len(names) - MAX_LISTED} more"
    return text


def tell_unused(path: Path, columns: Sequence[str]) -> None:
    """Print the unused columns of a trajectory file, if any."""
    if columns:
        names = list_names(columns)
        click.echo(f"{path}: {counted(len(columns), 'column')} not used: {names}", err=True)


def tell_losses(losses: Sequence[str]) -> None:
    """Print the messages that could not be read."""
    for loss in losses:
        click.echo(f"lost: {loss}", err=True)
