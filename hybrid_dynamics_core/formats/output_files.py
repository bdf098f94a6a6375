"""Writing of exported files."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from ..description.model import RobotDescription
from ..errors import InputError


def write_files(
    texts: Mapping[Path, str | bytes], robot: RobotDescription, overwrite: bool = False
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
        _write(path, text)


def write_folder(texts: Mapping[str, str | bytes], folder: Path, overwrite: bool = False) -> None:
    """Write all files of an export into a folder of their own, or none.

    Args:
        texts: text of each file by its name, which may be in folders, such as "src/arm.cpp".
        folder: it is made if it is not there; otherwise it may hold files of these names alone.
        overwrite: whether existing files may be replaced.

    Raises:
        InputError: the folder is none, has other files, or files are not to be replaced.
        OSError: a file cannot be written.
    """
    require_place(folder)
    folders = _folders(texts)
    entries = _entries(folder, folders)
    _refuse_others(folder, entries, texts, folders)
    if entries and not overwrite:
        raise InputError(
            f"{folder}: has {entries[0]} already; name another folder, or give --overwrite"
        )
    folder.mkdir(exist_ok=True)
    for name in folders:
        (folder / name).mkdir(exist_ok=True)
    for name, text in texts.items():
        _write(folder / name, text)


def require_place(folder: Path) -> None:
    """Raise InputError for a folder that cannot be made."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; name a folder")
    if not folder.parent.is_dir():
        raise InputError(f"{folder}: there is no folder {folder.parent}")


def _entries(folder: Path, folders: Collection[str]) -> list[str]:
    """Names in a folder and in those of its folders that are expected, from it."""
    if not folder.is_dir():
        return []
    names = sorted(path.name for path in folder.iterdir())
    for inner in folders:
        if (folder / inner).is_dir():
            names += sorted(f"{inner}/{path.name}" for path in (folder / inner).iterdir())
    return names


def _refuse_others(
    folder: Path, entries: Iterable[str], files: Collection[str], folders: Collection[str]
) -> None:
    """Raise InputError if an entry is neither an expected file nor an expected folder."""
    for name in entries:
        is_file = name in files and (folder / name).is_file()
        is_folder = name in folders and (folder / name).is_dir()
        if not is_file and not is_folder:
            raise InputError(f"{folder}: has other files, such as {name}; name an empty folder")


def _folders(names: Iterable[str]) -> list[str]:
    """Names of all folders that files are in, each after those around it."""
    folders: set[str] = set()
    for name in names:
        parts = name.split("/")[:-1]
        folders.update("/".join(parts[:count]) for count in range(1, len(parts) + 1))
    return sorted(folders)


def _write(path: Path, content: str | bytes) -> None:
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_text(content, encoding="utf-8")


def source_files(robot: RobotDescription) -> list[Path]:
    """Every file that a robot was read from."""
    files = dict.fromkeys((robot.file, *robot.files.values()))
    return [Path(file) for file in files if file is not None]


def _is_same_file(path: Path, source: Path) -> bool:
    return path.exists() and source.exists() and path.samefile(source)
