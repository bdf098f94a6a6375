"""XML as plain elements with the lines of their start tags.

Document types are refused, so there are no entities.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ...description.files import read_text
from ...errors import DescriptionError

MAX_ELEMENTS = 200_000
MAX_DEPTH = 50
_COMMENT = re.compile(r"<!--(.*?)-->|<!\[CDATA\[.*?\]\]>", re.DOTALL)


@dataclass
class LocatedElement:
    """An element of a file.

    Attributes:
        tag: tag of the element.
        attributes: attributes by name.
        line: line of the start tag (1-based).
        children: elements inside it.
        text: text directly inside it.
        file: its file.
        comment: the first comment of the file, for its root.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[LocatedElement] = field(default_factory=list)
    text: str = ""
    file: Path | None = None
    comment: str = ""

    def get(self, attribute: str, default: str = "") -> str:
        """The text of an attribute."""
        return self.attributes.get(attribute, default)

    def all(self, tag: str) -> list[LocatedElement]:
        """Children with a tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> LocatedElement | None:
        """The first child with a tag."""
        return next(iter(self.all(tag)), None)


def read_xml(path: Path) -> LocatedElement:
    """The root element of a file.

    Raises:
        DescriptionError: it is not plain XML.
    """
    return parse_xml(read_text(path), path)


def parse_xml(text: str, path: Path) -> LocatedElement:
    """The root element of a text; `path` is named in messages.

    Raises:
        DescriptionError: it is not plain XML.
    """
    parser = _Parser(path)
    try:
        parser.expat.Parse(_as_strict_xml(text.removeprefix("\ufeff")), True)
    except expat.ExpatError as error:
        problem = f"not valid XML: {expat.ErrorString(error.code)}"
        raise DescriptionError(problem, file=path, line=error.lineno) from error
    comment = _COMMENT.search(text)
    if comment is not None:
        parser.root.comment = (comment[1] or "").strip()
    return parser.root


def _as_strict_xml(text: str) -> str:
    """A text without errors that other robot parsers tolerate; line numbers stay the same.

    These are `--` in comments, and a declaration after comments or blank lines.
    """
    text = _COMMENT.sub(_blank, text)
    before, declaration, after = text.partition("<?xml")
    if declaration and before and not before.strip():
        end = after.find("?>")
        text = before + after[end + 2 :]
    return text


def _blank(match: re.Match[str]) -> str:
    """The line breaks of a comment; CDATA is not changed."""
    matched = match[0]
    if not matched.startswith("<!--"):
        return matched
    return "\n" * matched.count("\n")


class _Parser:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.root = LocatedElement("", {}, 1)
        self.open: list[LocatedElement] = []
        self.count = 0
        self.expat = expat.ParserCreate()
        self.expat.StartElementHandler = self.start
        self.expat.EndElementHandler = self.end
        self.expat.CharacterDataHandler = self.characters
        self.expat.StartDoctypeDeclHandler = self.refuse_doctype

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.expat.CurrentLineNumber
        element = LocatedElement(tag, attributes, line, file=self.path)
        self.count += 1
        if self.count > MAX_ELEMENTS or len(self.open) >= MAX_DEPTH:
            problem = "too many elements for a robot"
            raise DescriptionError(problem, file=self.path, line=element.line)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def characters(self, text: str) -> None:
        self.open[-1].text += text

    def end(self, _: str) -> None:
        self.open.pop()

    def refuse_doctype(self, *_: object) -> None:
        problem = "has a document type (<!DOCTYPE ...>), which could define entities; remove it"
        raise DescriptionError(problem, file=self.path, line=self.expat.CurrentLineNumber)
