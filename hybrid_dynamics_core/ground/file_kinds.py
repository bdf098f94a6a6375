"""Kinds of files by their content, for messages that expected another kind."""

from __future__ import annotations

import re
import zipfile
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final

from ..errors import DescriptionError, InputError
from .regular_files import answered_in_time, open_regular, special_kind
from .suggestions import suggestion

BAG_METADATA: Final = "metadata.yaml"
STORAGE_SUFFIXES: Final = (".mcap", ".db3")  # of recordings, compressed or not
_TABLE_SUFFIXES: Final = (".csv", ".npz", ".parquet")
_TEXT_SUFFIXES: Final = (
    ".yaml",
    ".yml",
    ".json",
    ".urdf",
    ".xml",
    ".sdf",
    ".xacro",
)  # may hold a robot
_ROBOT_FILES: Final = "a robot description (YAML, URDF, SDFormat or MJCF)"
_HEAD_SIZE: Final = 65_536  # bytes that are read
_MAX_STRANGE_SHARE: Final = 0.3  # share of characters that occur in no text, in any 8-bit encoding


class FileKind(Enum):
    """Kinds of content of a path."""

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
    """A path holds no robot description: it is missing, or of another kind.

    It has the attributes of DescriptionError, and this one:

    Attributes:
        kind: kind of the path's content.
    """

    def __init__(self, path: str | Path, problem: str, kind: FileKind) -> None:
        self.kind = kind
        super().__init__(problem, file=path)


@dataclass(frozen=True)
class PathContent:
    """The kind of a path's content, and a text for it."""

    kind: FileKind
    words: str


_SIGNATURES: Final = (  # first bytes of files of each kind
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
_ZIP_SIGNATURE: Final = b"PK\x03\x04"
_UTF16_SIGNATURES: Final = (b"\xff\xfe", b"\xfe\xff")

_XML_HEAD: Final = r"\s*(<\?xml.*?\?>)?\s*"
_COMMENT: Final = r"<!--(?:(?!-->).)*-->\s*"  # one comment only, against endless backtracking
_TEXT_PATTERNS: Final = (
    (r"\s*<(!doctype html|html)\b", FileKind.PAGE, "an HTML page"),
    (
        rf"{_XML_HEAD}({_COMMENT}|<!doctype[^>]*>\s*)*<svg\b",
        FileKind.PICTURE,
        "an SVG picture",
    ),
    (
        rf"{_XML_HEAD}({_COMMENT})*<(robot|sdf|gazebo|mujoco)\b",
        FileKind.ROBOT,
        "a robot description (XML)",
    ),
    (r"\s*rosbag2_bagfile_information\s*:", FileKind.BAG_PART, "the metadata of a recording"),
    (r"(.*\n)?[ \t]+ros__parameters\s*:", FileKind.SETTINGS, "a parameter file of the node"),
    (r"\s*<", FileKind.TEXT, "an XML file"),
)
_TABLE: Final = re.compile(r"[^\n:{]*[,;\t][^\n{]*\n[-+0-9.eE,;\t \"naN]+\r?(\n|$)")
_PROGRAM: Final = re.compile(r"#!|(.*\n)?(import \w+|from \w[\w.]* import |def \w+\()", re.DOTALL)
_KEYS: Final = (
    "format|joints|links|chain|loops|closures|modules|legs|active|end_effector|urdf|closed_loop"
    "|joint_name|parameters"
)
_DESCRIPTION_KEY: Final = re.compile(
    rf"(?:^|[\n{{,])[ \t]*[\"']?({_KEYS})[\"']?[ \t]*:(?=\s|$)", re.IGNORECASE
)
_MIN_DESCRIPTION_KEYS: Final = 2  # other texts do not have two of them by chance


def classify_path(path: Path) -> PathContent:
    """Classify the content of a path.

    Raises:
        OSError: the path cannot be read.
    """
    return answered_in_time(lambda: _classify(path))


def _classify(path: Path) -> PathContent:
    if not path.exists():
        return PathContent(FileKind.MISSING, "nothing")
    if path.is_dir():
        return _classify_folder(path)
    special = special_kind(path)
    if special:
        return PathContent(FileKind.OTHER, special)
    return _classify_file(path)


def _classify_file(path: Path) -> PathContent:
    with open_regular(path) as file:
        head = file.read(_HEAD_SIZE)
    if not head.strip():
        return PathContent(FileKind.OTHER, "an empty file")
    for signature, kind, words in _SIGNATURES:
        if head.startswith(signature):
            return PathContent(kind, words)
    if head.startswith(_ZIP_SIGNATURE):
        return _classify_archive(path)
    return _classify_unsigned(path, head)


def storage_suffix(path: Path) -> str | None:
    """The suffix in STORAGE_SUFFIXES of a file, without .zstd; None for other files."""
    suffix = path.suffix
    if suffix == ".zstd":
        suffix = Path(path.stem).suffix
    if suffix not in STORAGE_SUFFIXES or path.name.startswith("."):
        return None
    return suffix


def unexpected_content(path: Path, expected: str) -> str:
    """The message for a path with unexpected content.

    Raises:
        OSError: the path cannot be read.
    """
    content = classify_path(path)
    if content.kind is not FileKind.MISSING:
        return f"seems to be {content.words}; expected {expected}"
    names: list[str] = []
    if path.parent.is_dir():
        names = [neighbour.name for neighbour in path.parent.iterdir()]
    return f"there is no such file or folder{suggestion(path.name, names)}; expected {expected}"


def require_description(path: Path) -> None:
    """Raise if a path holds no robot description; its content is checked by its reader.

    Raises:
        NoDescriptionError: the path is missing, or of another kind.
        DescriptionError: the path cannot be read.
    """
    try:
        kind = classify_path(path).kind
        if kind is FileKind.ROBOT:
            return
        if kind is FileKind.TEXT and path.suffix in _TEXT_SUFFIXES:
            return
        raise NoDescriptionError(path, unexpected_content(path, _ROBOT_FILES), kind)
    except OSError as error:
        raise DescriptionError(f"cannot be read: {error.strerror or error}", file=path) from error


def _classify_folder(path: Path) -> PathContent:
    entries = [entry for entry in path.iterdir() if not entry.name.startswith(".")]
    files = [entry for entry in entries if entry.is_file()]
    if (path / BAG_METADATA).is_file() or any(map(storage_suffix, files)):
        return PathContent(FileKind.BAG, "a recording (rosbag2)")
    if any((entry / BAG_METADATA).is_file() for entry in entries):
        return PathContent(FileKind.BAGS, "a folder of recordings")
    if files and all(file.suffix in _TABLE_SUFFIXES for file in files):
        return PathContent(FileKind.TABLES, "a folder of tables")
    if entries:
        return PathContent(FileKind.OTHER, "a folder")
    return PathContent(FileKind.OTHER, "an empty folder")


def _classify_archive(path: Path) -> PathContent:
    names: list[str] = []
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except zipfile.BadZipFile:
        pass  # a ZIP archive by its first bytes, but damaged
    if names and all(name.endswith(".npy") for name in names):
        return PathContent(FileKind.TRAJECTORY, "a table (.npz)")
    return PathContent(FileKind.OTHER, "a ZIP archive")


def _classify_unsigned(path: Path, head: bytes) -> PathContent:
    """Classify a file without a known signature."""
    if storage_suffix(path):
        return PathContent(FileKind.BAG, "a recording")
    if head.startswith(_UTF16_SIGNATURES):
        return PathContent(FileKind.TEXT, "a text in UTF-16")
    text = head.decode("utf-8", errors="replace")
    strange = sum(map(_is_strange, text))
    if "\0" in text or strange > _MAX_STRANGE_SHARE * len(text):
        return PathContent(FileKind.OTHER, "a binary file")
    return _classify_text(text.removeprefix("\ufeff"))


def _is_strange(character: str) -> bool:
    """Whether a character is not UTF-8, or a control character that texts do not have."""
    if character == "\ufffd":
        return True
    return character < " " and character not in "\t\n\r\f"


def _classify_text(text: str) -> PathContent:
    if _TABLE.match(text):
        return PathContent(FileKind.TRAJECTORY, "a table (CSV)")
    for pattern, kind, words in _TEXT_PATTERNS:
        if re.match(pattern, text, re.DOTALL | re.IGNORECASE):
            return PathContent(kind, words)
    keys = {key.lower() for key in _DESCRIPTION_KEY.findall(text)}
    if len(keys) >= _MIN_DESCRIPTION_KEYS:
        return PathContent(FileKind.ROBOT, "a robot description (YAML)")
    if _PROGRAM.match(text):
        return PathContent(FileKind.TEXT, "a program")
    return PathContent(FileKind.TEXT, "a text file that describes no robot")
