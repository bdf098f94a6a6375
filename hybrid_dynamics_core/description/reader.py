"""A description file becomes a RobotDescription, or one clear DescriptionError."""

from __future__ import annotations

from pathlib import Path

from .build import build_description
from .check import check_names, check_values
from .check_loops import check_loop_names, check_loops
from .document import Document
from .expand import expand
from .files import read_text
from .located_yaml import read_yaml
from .model import RobotDescription
from .schema import check_schema


def read_description(path: str | Path) -> RobotDescription:
    """Read, check and expand a description file (YAML, UTF-8).

    Raises DescriptionError with file, line, key, what was expected and how to mend it.
    """
    return parse_description(read_text(Path(path)), file=path)


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
