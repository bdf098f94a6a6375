"""A description file becomes a RobotDescription, or one clear DescriptionError."""

from __future__ import annotations

from pathlib import Path

from ..errors import DescriptionError
from .build import build_description
from .check import check_names, check_values
from .check_loops import check_loop_names, check_loops
from .document import Document
from .expand import expand
from .located_yaml import read_yaml
from .model import RobotDescription
from .schema import check_schema

MAX_BYTES = 5_000_000


def read_description(path: str | Path) -> RobotDescription:
    """Read, check and expand a description file (YAML, UTF-8).

    Raises DescriptionError with file, line, key, what was expected and how to mend it.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise DescriptionError(f"larger than {MAX_BYTES} bytes; not a robot description", file=path)
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise DescriptionError(f"not UTF-8 text (byte {error.start})", file=path) from error
    except OSError as error:
        raise DescriptionError(f"cannot be read: {error.strerror or error}", file=path) from error
    return parse_description(text, file=path)


def parse_description(text: str, file: str | Path | None = None) -> RobotDescription:
    """The same from text; `file` is named in messages."""
    document = read_yaml(text, file)
    check_schema(document)
    return describe(document)


def describe(document: Document) -> RobotDescription:
    """Expand, check and build a document that fits the schema."""
    expand(document)
    check_names(document)
    check_loop_names(document)
    description = build_description(document)
    check_values(document, description)
    check_loops(document, description)
    return description
