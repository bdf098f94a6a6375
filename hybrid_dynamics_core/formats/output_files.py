"""Written files: never in place of what a robot was read from, and of others only where that is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..description.model import RobotDescription
from ..errors import InputError


def write_files(
    texts: Mapping[Path, str], robot: RobotDescription, overwrite: bool = False
) -> None:
    """Write the files that a robot was exported to: all of them, or none.

    Raises InputError where one is there already and `overwrite` is not asked for, and where one is
    a file that the robot was read from, whatever is asked for; OSError where one cannot be written.
    """
    for path in texts:
        if path.exists() and any(_same(path, source) for source in sources(robot)):
            raise InputError(
                f"{path}: the robot is read from this file, which is not replaced; name another one"
            )
    for path in texts:
        if path.exists() and not overwrite:
            raise InputError(
                f"{path}: there is a file already; name another one, or give --overwrite"
            )
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")


def sources(robot: RobotDescription) -> list[Path]:
    """Every file that a robot was read from."""
    return [
        Path(file)
        for file in dict.fromkeys((robot.file, *robot.files.values()))
        if file is not None
    ]


def _same(path: Path, source: Path) -> bool:
    return source.exists() and path.samefile(source)
