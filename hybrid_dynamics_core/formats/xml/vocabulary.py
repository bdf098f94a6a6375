"""Vocabularies of XML formats: attributes and elements that are read, or ignored with a note.

Notes list the lines of ignored words. All other words are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...description.document import KeyPath
from .located_xml import LocatedElement
from .reader import XmlReader

_BOOLEANS = {"true": "1", "false": "0"}
_SECTIONS = {"body": "links"}  # names in messages; for other elements the tag and an s
_PREFIXES = ("hybrid_dynamics:", "drake:rotor_inertia", "drake:gear_ratio")  # are read
_MAX_LINES = 5  # listed in a note


@dataclass(frozen=True)
class Vocabulary:
    """The allowed content of an element.

    Attributes:
        attributes: names of attributes.
        elements: tags of elements; None for any.
        fixed: allowed values, separated by |, of further attributes and elements; they have no
            effect.
        omitted: names of further attributes and elements, which are left out with a note. Elements
            that are also in `elements` are checked inside.
    """

    attributes: frozenset[str] = frozenset()
    elements: frozenset[str] | None = frozenset()
    fixed: Mapping[str, str] = field(default_factory=dict)
    omitted: frozenset[str] = frozenset()


def vocabulary(
    attributes: str = "", elements: str | None = "", omitted: str = "", **fixed: str
) -> Vocabulary:
    """A vocabulary from names separated by blanks."""
    tags = None
    if elements is not None:
        tags = frozenset(elements.split())
    return Vocabulary(frozenset(attributes.split()), tags, fixed, frozenset(omitted.split()))


class VocabularyCheck:
    """Checks the elements of a file.

    Elements without a vocabulary are not checked inside. Elements with a colon in their name belong
    to other programs, and are left out with a note, except those of this library.

    Args:
        xml: the file.
        table: vocabularies by tag, or by the parent's tag and the element's (`a/b`).
        advice: end of every message.
        ours: elements, and attributes as `TAG.NAME`, that this library has written into the file
            for other programs. They get no note.
    """

    def __init__(
        self,
        xml: XmlReader,
        table: Mapping[str, Vocabulary],
        advice: str,
        ours: frozenset[str] = frozenset(),
    ) -> None:
        self.xml = xml
        self.table = table
        self.advice = advice
        self.ours = ours
        self.omitted_elements: dict[str, list[LocatedElement]] = {}  # by tag
        self.omitted_attributes: dict[str, dict[str, list[LocatedElement]]] = {}  # tag and name

    def check(self, element: LocatedElement, parent: str = "", key: KeyPath = ()) -> None:
        """Check an element and all in it.

        Raises:
            DescriptionError: the first unsupported attribute or element.
        """
        in_any_parent = self.table.get(element.tag)
        covered = self.table.get(f"{parent}/{element.tag}", in_any_parent)
        if covered is None:
            return
        if element.get("name"):
            section = _SECTIONS.get(element.tag, f"{element.tag}s")
            key = (section, element.get("name"))
        self._check_attributes(element, covered, key)
        for child in element.children:
            self._check_child(element, child, covered, key)
            if covered.elements is None or child.tag in covered.elements:
                self.check(child, element.tag, key)

    def add_notes(self) -> None:
        """Add notes on words left out, with their lines."""
        notes = self.xml.document.notes
        for tag, elements in self.omitted_elements.items():
            notes.append(f"<{tag}> is left out ({self._lines_text(elements)})")
        for tag, elements_by_name in self.omitted_attributes.items():
            names = ", ".join(elements_by_name)
            verb = "is" if len(elements_by_name) == 1 else "are"
            elements = [one for several in elements_by_name.values() for one in several]
            notes.append(f"{names} of <{tag}> {verb} left out ({self._lines_text(elements)})")

    def _lines_text(self, elements: list[LocatedElement]) -> str:
        """Text of the distinct lines of elements; only the first ones of many."""
        places = dict.fromkeys((self.xml.file_of(element), element.line) for element in elements)
        in_order = sorted(places, key=lambda place: (place[0] != self.xml.file, place))
        shown: list[str] = []
        for file, line in in_order[:_MAX_LINES]:
            shown.append(str(line) if file == self.xml.file else f"{line} of {file.name}")
        listed = ", ".join(shown)
        if len(in_order) == 1:
            return f"line {listed}"
        if len(in_order) <= _MAX_LINES:
            return f"lines {listed}"
        return f"lines {listed} and {len(in_order) - _MAX_LINES} more"

    def _check_attributes(self, element: LocatedElement, covered: Vocabulary, key: KeyPath) -> None:
        for name, value in element.attributes.items():
            if name in covered.attributes or name == "xmlns" or ":" in name:
                continue
            if f"{element.tag}.{name}" in self.ours:
                continue
            if name in covered.omitted:
                elements_by_name = self.omitted_attributes.setdefault(element.tag, {})
                elements_by_name.setdefault(name, []).append(element)
                continue
            shown = f"{name} of <{element.tag}>"
            if name not in covered.fixed:
                raise self._not_covered(element, shown, key)
            self._check_value(element, shown, value, covered.fixed[name], key)

    def _check_child(
        self, element: LocatedElement, child: LocatedElement, covered: Vocabulary, key: KeyPath
    ) -> None:
        tag = child.tag
        if tag in covered.fixed:
            shown = f"<{tag}> of <{element.tag}>"
            self._check_value(child, shown, child.text, covered.fixed[tag], key)
            return
        if tag in self.ours:
            return
        if tag in covered.omitted:
            self.omitted_elements.setdefault(tag, []).append(child)
            return
        if covered.elements is None or tag in covered.elements:
            return
        if ":" in tag:
            if not tag.startswith(_PREFIXES):
                self.omitted_elements.setdefault(tag, []).append(child)
            return
        raise self._not_covered(child, f"<{tag}>", key or (element.tag,))

    def _check_value(
        self, element: LocatedElement, shown: str, value: str, fixed: str, key: KeyPath
    ) -> None:
        """Check that an attribute or element has one of its allowed values."""
        value = value.strip()
        alternatives = fixed.split("|")
        if not value or any(_equal(value, alternative) for alternative in alternatives):
            return
        expected = " or ".join(f"'{alternative}'" for alternative in alternatives)
        raise self.xml.error(
            element,
            key or (element.tag,),
            f"{shown} is '{value}', which is not covered; expected {expected}{self.advice}",
        )

    def _not_covered(self, element: LocatedElement, shown: str, key: KeyPath) -> Exception:
        problem = f"{shown} is not covered{self.advice}"
        return self.xml.error(element, key or (element.tag,), problem)


def _equal(one: str, other: str) -> bool:
    """Whether two values are equal; 0 equals any number of zeros."""
    return _normalized(one) == _normalized(other)


def _normalized(value: str) -> list[float] | str:
    text = value.strip().lower()
    text = _BOOLEANS.get(text, text)
    try:
        numbers = [float(part) for part in text.split()]
    except ValueError:
        return text
    while numbers and numbers[-1] == 0.0:
        numbers.pop()
    return numbers
