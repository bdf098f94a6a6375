"""Files that verbs write: the one rule of what may be replaced.

A picture, table or page that this command made is replaced, and that is told; any other file only
with --overwrite. What a call reads is never replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.output_files import sources
from hybrid_dynamics_core.ground.file_kinds import classify_path

from .exit_codes import Misused

Command = TypeVar("Command", bound=Callable[..., Any])
PICTURES: Final = (".svg", ".png", ".pdf")
MOTIONS: Final = (".csv", ".npz")
MARKS: Final = {  # what files of this command have in them
    ".svg": b"hybrid_dynamics, Matplotlib",
    ".png": b"hybrid_dynamics, Matplotlib",
    ".pdf": b"hybrid_dynamics, Matplotlib",
    ".npz": b"state_residual.npy",
    ".html": b'<meta name="generator" content="hybrid_dynamics">',
    ".md": b"The forging robot: CPU time, median of",
}
HEADS: Final = (
    b"energy.kinetic,energy.potential",
    b"name,estimate,low,high,",
)  # of tables, in their first line

overwrite_option = click.option(
    "--overwrite", is_flag=True, help="Replace any file, but none that this call reads."
)


def draw_option(*names: str, help: str) -> Callable[[Command], Command]:  # noqa: A002 - click's own word
    """--draw, or --plot: a picture."""
    return click.option(
        "--draw", "--plot", *names, metavar="FILE", help=f"{help}: .svg, .png or .pdf."
    )


def output_option(*names: str, help: str) -> Callable[[Command], Command]:  # noqa: A002
    """-o, or --output: a file or folder with the result."""
    return click.option("-o", "--output", *names, metavar="FILE", help=help)


def output_path(path: str | Path) -> Path:
    """A file that can be written: its folder is there."""
    place = Path(path)
    if not place.parent.is_dir():
        raise Misused(f"{path}: there is no folder {place.parent}")
    if place.is_dir():
        raise Misused(f"{path}: is a folder; name a file in it")
    return place


def place_for(
    path: str | Path, endings: Sequence[str], inputs: Iterable[Path], *, overwrite: bool
) -> Path:
    """Where a result goes; what it has replaced when the call ends is told.

    `inputs`: files, or folders with files, that this call reads. Raises Misused where the file is
    not to be replaced.
    """
    place = output_path(path)
    if place.suffix.lower() not in endings:
        raise Misused(f"{path}: expected a name that ends in {_either(endings)}")
    if not place.exists():
        return place
    if not place.is_file():
        raise Misused(f"{path}: is no regular file; name another")
    if any(_reads(source, place) for source in inputs):
        raise Misused(f"{path}: is read by this call, and is not replaced; name another file")
    if not overwrite and not _made_here(place):
        what = classify_path(place).words
        raise Misused(
            f"{path}: is there already, {what} not of this command; name another file, or give"
            " --overwrite"
        )
    click.get_current_context().call_on_close(partial(_tell_replaced, place, _version(place)))
    return place


def _tell_replaced(place: Path, before: tuple[int, ...]) -> None:
    """Only of what was written: a call may end before."""
    if _version(place) != before:
        click.echo(f"replaced: {place}", err=True)


def _version(place: Path) -> tuple[int, ...]:
    found = place.stat()
    return found.st_ino, found.st_mtime_ns, found.st_size


def picture_for(machine: Robot, path: str, *, overwrite: bool) -> Path:
    """Where a picture of a robot goes."""
    return place_for(path, PICTURES, read_by(machine), overwrite=overwrite)


def read_by(machine: Robot) -> list[Path]:
    """The files that a robot was read from."""
    return sources(machine.description)


def _either(endings: Sequence[str]) -> str:
    return endings[0] if len(endings) == 1 else f"{', '.join(endings[:-1])} or {endings[-1]}"


def _reads(source: Path, place: Path) -> bool:
    inside = source.is_dir() and source.resolve() in place.resolve().parents
    return inside or (source.exists() and place.samefile(source))


def _made_here(place: Path) -> bool:
    content = place.read_bytes()
    if place.suffix.lower() == ".csv":
        return any(head in content.partition(b"\n")[0] for head in HEADS)
    return MARKS[place.suffix.lower()] in content
