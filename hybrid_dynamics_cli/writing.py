"""Files written by the verbs, and the rule for replacing existing files.

A picture, table or report made by this command is replaced, with a line on stderr. Any other file
is replaced only with --overwrite. An input of the call is never replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.output_files import source_files
from hybrid_dynamics_core.ground.file_kinds import classify_path

from .exit_codes import Misused

Command = TypeVar("Command", bound=Callable[..., Any])
PICTURES: Final = (".svg", ".png", ".pdf")
MOTIONS: Final = (".csv", ".npz")
MARKS: Final = {  # by suffix: text that marks files of this command
    ".svg": b"hybrid_dynamics, Matplotlib",
    ".png": b"hybrid_dynamics, Matplotlib",
    ".pdf": b"hybrid_dynamics, Matplotlib",
    ".npz": b"state_residual.npy",
    ".html": b'<meta name="generator" content="hybrid_dynamics">',
    ".md": b"The forging robot: CPU time, median of",
}
# Text in the first line of every table of this command.
HEADS: Final = (
    b"energy.kinetic,energy.potential",
    b"name,estimate,low,high,",
    b".deviation",  # of estimated states
)

overwrite_option = click.option(
    "--overwrite", is_flag=True, help="Replace any file, but none that this call reads."
)


def draw_option(
    *names: str,
    help: str,  # noqa: A002 - as click
) -> Callable[[Command], Command]:
    """The option --draw, or --plot, for a picture."""
    text = f"{help}: .svg, .png or .pdf."
    return click.option("--draw", "--plot", *names, metavar="FILE", help=text)


def output_option(
    *names: str,
    help: str,  # noqa: A002 - as click
) -> Callable[[Command], Command]:
    """The option -o, or --output, for a file or folder with the result."""
    return click.option("-o", "--output", *names, metavar="FILE", help=help)


def output_path(path: str | Path) -> Path:
    """The path of a file in an existing folder.

    Raises:
        Misused: the folder does not exist, or the path is a folder itself.
    """
    place = Path(path)
    if not place.parent.is_dir():
        raise Misused(f"{path}: there is no folder {place.parent}")
    if place.is_dir():
        raise Misused(f"{path}: is a folder; name a file in it")
    return place


def place_for(
    path: str | Path, endings: Sequence[str], inputs: Iterable[Path], *, overwrite: bool
) -> Path:
    """The path of a result; if the call replaces a file, a line on stderr names it.

    Args:
        path: path given by the user.
        endings: allowed suffixes.
        inputs: files or folders that this call reads.
        overwrite: whether to replace files of other origin.

    Raises:
        Misused: the file cannot be written or must not be replaced.
    """
    place = output_path(path)
    if place.suffix.lower() not in endings:
        raise Misused(f"{path}: expected a name that ends in {_alternatives(endings)}")
    if not place.exists():
        return place
    if not place.is_file():
        raise Misused(f"{path}: is no regular file; name another")
    require_unread(place, inputs)
    if not overwrite and not _made_here(place):
        what = classify_path(place).words
        raise Misused(
            f"{path}: is there already, {what} not of this command; name another file, or give"
            " --overwrite"
        )
    report = partial(_report_replaced, place, _version(place))
    click.get_current_context().call_on_close(report)
    return place


def require_unread(place: Path, inputs: Iterable[Path]) -> None:
    """Raise Misused for a result in place of a file that this call reads."""
    if place.exists() and any(_reads(source, place) for source in inputs):
        raise Misused(f"{place}: is read by this call, and is not replaced; name another file")


def _report_replaced(place: Path, before: tuple[int, ...]) -> None:
    """Print that a file was replaced, if it has changed."""
    if _version(place) != before:
        click.echo(f"replaced: {place}", err=True)


def _version(place: Path) -> tuple[int, ...]:
    status = place.stat()
    return status.st_ino, status.st_mtime_ns, status.st_size


def picture_for(machine: Robot, path: str, *, overwrite: bool) -> Path:
    """The path of a picture of a robot."""
    return place_for(path, PICTURES, read_by(machine), overwrite=overwrite)


def read_by(machine: Robot) -> list[Path]:
    """The source files of a robot."""
    return source_files(machine.description)


def _alternatives(endings: Sequence[str]) -> str:
    if len(endings) == 1:
        return endings[0]
    return f"{', '.join(endings[:-1])} or {endings[-1]}"


def _reads(source: Path, place: Path) -> bool:
    """Whether a file is an input, or inside a folder that is one."""
    if source.is_dir() and source.resolve() in place.resolve().parents:
        return True
    return source.exists() and place.samefile(source)


def _made_here(place: Path) -> bool:
    """Whether a file was made by this command."""
    content = place.read_bytes()
    ending = place.suffix.lower()
    if ending != ".csv":
        return MARKS[ending] in content
    first_line = content.partition(b"\n")[0]
    return any(head in first_line for head in HEADS)
