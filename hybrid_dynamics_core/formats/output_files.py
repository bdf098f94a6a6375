"""Writing of exported files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..description.model import RobotDescription
from ..errors import InputError


def write_files(
    texts: Mapping[Path, str], robot: RobotDescription, overwrite: bool = False
) -> None:
    """Write all files of an export, or none.

    Args:
        texts: text of each file.
        robot: the exported robot. The files it was read from are never replaced.
        overwrite: whether existing files may be replaced.

    Raises:
        InputError: a file exists, or the robot was read from it.
        OSError: a file cannot be written.
    """
    sources = source_files(robot)
    for path in texts:
        if any(_is_same_file(path, source) for source in sources):
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


def write_folder(texts: Mapping[str, str], folder: Path, overwrite: bool = False) -> None:
    """Write all files of an export into a folder of their own, or none.

    Args:
        texts: text of each file by its name.
        folder: it is made if it is not there; otherwise it may hold files of these names alone.
        overwrite: whether existing files may be replaced.

    Raises:
        InputError: the folder is none, has other files, or files are not to be replaced.
        OSError: a file cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; name a folder")
    if not folder.parent.is_dir():
        raise InputError(f"{folder}: there is no folder {folder.parent}")
    entries = sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []
    others = [name for name in entries if name not in texts or not (folder / name).is_file()]
    if others:
        raise InputError(f"{folder}: has other files, such as {others[0]}; name an empty folder")
    if entries and not overwrite:
        raise InputError(
            f"{folder}: has {entries[0]} already; name another folder, or give --overwrite"
        )
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def source_files(robot: RobotDescription) -> list[Path]:
    """Every file that a robot was read from."""
    files = dict.fromkeys((robot.file, *robot.files.values()))
    return [Path(file) for file in files if file is not None]


def _is_same_file(path: Path, source: Path) -> bool:
    return path.exists() and source.exists() and path.samefile(source)
