"""What a path seems to be, told by its content: for messages where another kind of file was expected."""

from __future__ import annotations

import re
import zipfile
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final

from ..errors import DescriptionError, InputError
from .suggestions import nearest

ROBOTS: Final = "a robot description (YAML, URDF, SDFormat or MJCF)"
HEAD: Final = 65_536  # bytes that are looked at
ODD: Final = 0.3  # share of characters that no text has, in an encoding that is not UTF-8 either
STORAGES: Final = (".mcap", ".db3")  # of recordings, packed or not
TABLES: Final = (".csv", ".npz", ".parquet")
METADATA: Final = "metadata.yaml"


class FileKind(Enum):
    """Kinds that ask for different things to be done with them."""

    MISSING = "missing"
    ROBOT = "robot"
    BAG = "bag"
    BAGS = "folder of bags"
    BAG_PART = "part of a bag"
    TRAJECTORY = "trajectory"
    TABLES = "folder of tables"
    SETTINGS = "parameters of the node"
    PICTURE = "picture"
    PAGE = "page"
    TEXT = "text"
    OTHER = "other"


class NoDescriptionError(DescriptionError, InputError):
    """There is no robot description at a path: nothing, or something of another kind.

    Attributes: those of a DescriptionError; ``kind``, what is there instead (`FileKind`).
    """

    def __init__(self, path: str | Path, problem: str, kind: FileKind) -> None:
        self.kind = kind
        super().__init__(problem, file=path)


@dataclass(frozen=True)
class Seen:
    """A kind, and in words what was seen."""

    kind: FileKind
    words: str


_MAGIC: Final = (
    (b"\x89PNG\r\n\x1a\n", FileKind.PICTURE, "a PNG picture"),
    (b"\xff\xd8\xff", FileKind.PICTURE, "a JPEG picture"),
    (b"GIF8", FileKind.PICTURE, "a GIF picture"),
    (b"%PDF-", FileKind.PICTURE, "a PDF file"),
    (b"\x89MCAP0\r\n", FileKind.BAG, "a recording (MCAP)"),
    (b"SQLite format 3\0", FileKind.BAG, "a recording (sqlite3)"),
    (b"#ROSBAG V2.0", FileKind.OTHER, "a recording of ROS 1"),
    (b"\x93NUMPY", FileKind.OTHER, "a single array (.npy)"),
    (b"\x7fELF", FileKind.OTHER, "a program"),
    (b"\x1f\x8b", FileKind.OTHER, "a gzip archive"),
)
_KEYS: Final = "format|joints|links|chain|loops|closures|modules|legs|active|end_effector|urdf|closed_loop|joint_name|parameters"
_ENTRY: Final = re.compile(
    rf"(?:^|[\n{{,])[ \t]*[\"']?({_KEYS})[\"']?[ \t]*:(?=\s|$)", re.IGNORECASE
)
_ENTRIES: Final = 2  # different keys of a description: no other text has so many by chance
_PROGRAM: Final = re.compile(r"#!|(.*\n)?(import \w+|from \w[\w.]* import |def \w+\()", re.DOTALL)
_COMMENT: Final = (
    r"<!--(?:(?!-->).)*-->\s*"  # never two as one: many lines of comments would take for ever
)
_TEXTS: Final = (
    (r"\s*<(!doctype html|html)\b", FileKind.PAGE, "an HTML page"),
    (
        rf"\s*(<\?xml.*?\?>)?\s*({_COMMENT}|<!doctype[^>]*>\s*)*<svg\b",
        FileKind.PICTURE,
        "an SVG picture",
    ),
    (
        rf"\s*(<\?xml.*?\?>)?\s*({_COMMENT})*<(robot|sdf|mujoco)\b",
        FileKind.ROBOT,
        "a robot description (XML)",
    ),
    (r"\s*rosbag2_bagfile_information\s*:", FileKind.BAG_PART, "the metadata of a recording"),
    (r"(.*\n)?[ \t]+ros__parameters\s*:", FileKind.SETTINGS, "a parameter file of the node"),
    (r"\s*<", FileKind.TEXT, "an XML file"),
)
_TABLE: Final = re.compile(r"[^\n:{]*[,;\t][^\n{]*\n[-+0-9.eE,;\t \"naN]+\r?(\n|$)")


def look(path: Path) -> Seen:
    """What there is at a path. Raises OSError where it cannot be read."""
    if not path.exists():
        return Seen(FileKind.MISSING, "nothing")
    if path.is_dir():
        return _folder(path)
    with path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        return Seen(FileKind.OTHER, "an empty file")
    magic = next(
        (Seen(kind, words) for magic, kind, words in _MAGIC if head.startswith(magic)), None
    )
    if magic is not None:
        return magic
    return _archive(path) if head.startswith(b"PK\x03\x04") else _plain(path, head)


def storage_of(path: Path) -> str | None:
    """Which of STORAGES a file is, by its name; None where it is none of them."""
    suffix = Path(path.stem).suffix if path.suffix == ".zstd" else path.suffix
    return suffix if suffix in STORAGES and not path.name.startswith(".") else None


def instead(path: Path, expected: str) -> str:
    """What to say where something else was expected at a path."""
    seen = look(path)
    if seen.kind is not FileKind.MISSING:
        return f"seems to be {seen.words}; expected {expected}"
    names = [other.name for other in path.parent.iterdir()] if path.parent.is_dir() else []
    return f"there is no such file or folder{nearest(path.name, names)}; expected {expected}"


def require_description(path: Path) -> None:
    """Refuse what is no robot description at all; what is wrong inside one is for those who read it.

    Raises:
        NoDescriptionError: there is nothing, or something of another kind.
        DescriptionError: it cannot be looked at.
    """
    try:
        seen = look(path)
        if seen.kind is FileKind.ROBOT:
            return
        if seen.kind is FileKind.TEXT and path.suffix in (
            ".yaml",
            ".yml",
            ".urdf",
            ".xml",
            ".sdf",
            ".xacro",
        ):
            return
        raise NoDescriptionError(path, instead(path, ROBOTS), seen.kind)
    except OSError as error:
        raise DescriptionError(f"cannot be read: {error.strerror or error}", file=path) from error


def _folder(path: Path) -> Seen:
    there = [entry for entry in path.iterdir() if not entry.name.startswith(".")]
    files = [entry for entry in there if entry.is_file()]
    if (path / METADATA).is_file() or any(map(storage_of, files)):
        return Seen(FileKind.BAG, "a recording (rosbag2)")
    if any((entry / METADATA).is_file() for entry in there):
        return Seen(FileKind.BAGS, "a folder of recordings")
    if files and all(file.suffix in TABLES for file in files):
        return Seen(FileKind.TABLES, "a folder of tables")
    return Seen(FileKind.OTHER, "a folder" if there else "an empty folder")


def _plain(path: Path, head: bytes) -> Seen:
    """What has no mark at its beginning."""
    if storage_of(path):
        return Seen(FileKind.BAG, "a recording")
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return Seen(FileKind.TEXT, "a text in UTF-16")
    text = head.decode("utf-8", errors="replace")
    odd = sum(c == "\ufffd" or (c < " " and c not in "\t\n\r\f") for c in text)
    return (
        Seen(FileKind.OTHER, "a binary file")
        if "\0" in text or odd > ODD * len(text)
        else _text(text)
    )


def _archive(path: Path) -> Seen:
    try:
        with zipfile.ZipFile(path) as archive:
            arrays = archive.namelist() and all(
                name.endswith(".npy") for name in archive.namelist()
            )
    except zipfile.BadZipFile:
        arrays = False
    return (
        Seen(FileKind.TRAJECTORY, "a table (.npz)")
        if arrays
        else Seen(FileKind.OTHER, "a ZIP archive")
    )


def _text(text: str) -> Seen:
    text = text.removeprefix("\ufeff")
    if _TABLE.match(text):
        return Seen(FileKind.TRAJECTORY, "a table (CSV)")
    for pattern, kind, words in _TEXTS:
        if re.match(pattern, text, re.DOTALL | re.IGNORECASE):
            return Seen(kind, words)
    if len({key.lower() for key in _ENTRY.findall(text)}) >= _ENTRIES:
        return Seen(FileKind.ROBOT, "a robot description (YAML)")
    return Seen(
        FileKind.TEXT,
        "a program" if _PROGRAM.match(text) else "a text file that describes no robot",
    )
