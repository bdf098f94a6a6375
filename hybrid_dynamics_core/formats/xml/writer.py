"""Writing of XML: exact numbers, comments, indentation."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

_HYPHEN_BEFORE_HYPHEN = re.compile("-(?=-)")


def number_text(value: float) -> str:
    """The shortest exact text of a number, without negative zero."""
    return repr(float(value) + 0.0)


def numbers_text(values: Iterable[float]) -> str:
    """The shortest exact texts of several numbers."""
    return " ".join(map(number_text, values))


def add_text(parent: Element, tag: str, text: str) -> Element:
    """Add an element with a text in it."""
    element = SubElement(parent, tag)
    element.text = text
    return element


def insert_comment(element: Element, text: str) -> None:
    """Insert a comment at the beginning of an element.

    Double hyphens in names, which comments may not have, are separated.
    """
    parted = _HYPHEN_BEFORE_HYPHEN.sub("- ", text)
    element.insert(0, Comment(f" {parted} "))


def xml_text(root: Element, declaration: bool = True) -> str:
    """The text of a file, indented."""
    indent(root)
    return tostring(root, encoding="unicode", xml_declaration=declaration) + "\n"
