"""XML as plain elements with their lines.

Document types are refused, so no entity can grow or reach outside.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ...description.files import read_text
from ...errors import DescriptionError

MAX_ELEMENTS = 200_000
MAX_DEPTH = 50


@dataclass
class Element:
    """A tag with attributes, children, the line where it opens, and the text right inside it."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> list[Element]:
        """Children with a tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Element | None:
        """The first child with a tag."""
        return next(iter(self.all(tag)), None)


def read_xml(path: Path) -> Element:
    """The root element of a file; DescriptionError where it is not plain XML."""
    return parse_xml(read_text(path), path)


def parse_xml(text: str, path: Path) -> Element:
    """The root element of a text; `path` is named in messages."""
    reader = _Reader(path)
    try:
        reader.parser.Parse(text.removeprefix("\ufeff"), True)
    except expat.ExpatError as error:
        problem = f"not valid XML: {expat.ErrorString(error.code)}"
        raise DescriptionError(problem, file=path, line=error.lineno) from error
    return reader.root


class _Reader:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.root = Element("", {}, 1)
        self.open: list[Element] = []
        self.count = 0
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.refuse_doctype

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self.parser.CurrentLineNumber)
        self.count += 1
        if self.count > MAX_ELEMENTS or len(self.open) >= MAX_DEPTH:
            raise DescriptionError(
                "too many elements for a robot", file=self.path, line=element.line
            )
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
        raise DescriptionError(problem, file=self.path, line=self.parser.CurrentLineNumber)
