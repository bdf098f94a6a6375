"""Which words of a format a reader knows: what it reads, and what cannot change the robot.

All others are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...description.document import KeyPath
from .elements import XmlFile
from .tree import Element

TRUTH = {"true": "1", "false": "0"}
KEYS = {"body": "links"}  # what other elements are called in messages: their tag and an s


@dataclass(frozen=True)
class Words:
    """What an element may hold: attributes, elements (None: any), and words that may have one value only."""

    attributes: frozenset[str] = frozenset()
    elements: frozenset[str] | None = frozenset()
    fixed: Mapping[str, str] = field(
        default_factory=dict
    )  # attributes and elements: values that say nothing, by |


def words(attributes: str = "", elements: str | None = "", **fixed: str) -> Words:
    """Words from names with blanks between them."""
    known = None if elements is None else frozenset(elements.split())
    return Words(frozenset(attributes.split()), known, fixed)


class WordCheck:
    """Goes through a file; `table` has the words of an element by tag, or by its parent's tag and its own (`a/b`).

    Elements without words are not looked into. `advice` ends every message. Names with a colon
    belong to others.
    """

    def __init__(self, xml: XmlFile, table: Mapping[str, Words], advice: str) -> None:
        self.xml, self.table, self.advice = xml, table, advice

    def check(self, element: Element, parent: str = "", key: KeyPath = ()) -> None:
        """Raise a DescriptionError at the first word in an element that is not known."""
        known = self.table.get(f"{parent}/{element.tag}", self.table.get(element.tag))
        if known is None:
            return
        if element.attributes.get("name"):
            key = (KEYS.get(element.tag, f"{element.tag}s"), element.attributes["name"])
        for name, value in element.attributes.items():
            if name not in known.attributes and ":" not in name and name != "xmlns":
                self.value(element, f"{name} of <{element.tag}>", value, known.fixed.get(name), key)
        for child in element.children:
            if child.tag in known.fixed:
                self.value(
                    child,
                    f"<{child.tag}> of <{element.tag}>",
                    child.text,
                    known.fixed[child.tag],
                    key,
                )
            elif (
                known.elements is not None
                and child.tag not in known.elements
                and ":" not in child.tag
            ):
                raise self.xml.error(
                    child, key or (element.tag,), f"<{child.tag}> is not covered{self.advice}"
                )
            self.check(child, element.tag, key)

    def value(
        self, element: Element, name: str, value: str, wanted: str | None, key: KeyPath
    ) -> None:
        """Raise a DescriptionError where a word has not the value it may have."""
        if wanted is None:
            raise self.xml.error(
                element, key or (element.tag,), f"{name} is not covered{self.advice}"
            )
        values = wanted.split("|")
        if value.strip() and not any(alike(value, one) for one in values):
            expected = " or ".join(f"'{one}'" for one in values)
            problem = (
                f"{name} is '{value.strip()}', which is not covered; expected"
                f" {expected}{self.advice}"
            )
            raise self.xml.error(element, key or (element.tag,), problem)


def alike(one: str, other: str) -> bool:
    """Whether two values say the same; 0 stands for any number of zeros."""
    return _plain(one) == _plain(other)


def _plain(value: str) -> list[float] | str:
    text = value.strip().lower()
    text = TRUTH.get(text, text)
    try:
        numbers = [float(part) for part in text.split()]
    except ValueError:
        return text
    while numbers and numbers[-1] == 0.0:
        numbers.pop()
    return numbers
