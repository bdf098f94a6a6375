"""Default classes of MJCF: every element gets the attributes that its class gives it."""

from __future__ import annotations

from collections.abc import Mapping

from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .vocabulary import DRIVES, ORIENTATIONS

_MAIN = "main"  # the class of what has none
_WITH_DEFAULTS = frozenset({"joint", "geom", "site"})  # in bodies
_ALL_DRIVES = frozenset(DRIVES.split())
_DRIVE = "general"  # whose defaults all drives share

Attributes = Mapping[str, str]
Class = Mapping[str, Attributes]  # attributes by tag


def apply_defaults(xml: XmlReader) -> None:
    """Give every element of a file the attributes of its class.

    Raises:
        DescriptionError: an element names a class that does not exist.
    """
    _Defaults(xml).apply()


class _Defaults:
    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.root = xml.root
        self.classes: dict[str, Class] = {_MAIN: {}}
        for element in self.root.all("default"):
            self.read(element, _MAIN)
            name = element.get("class", _MAIN)
            self.classes.setdefault(name, self.classes[_MAIN])

    def read(self, element: LocatedElement, name: str, inherited: Class | None = None) -> None:
        """Read a class, and those inside it, which inherit from it."""
        attributes = dict(inherited or self.classes.get(name, {}))
        for child in element.children:
            tag = _kind(child.tag)
            if tag != "default":
                attributes[tag] = _completed(child.attributes, attributes.get(tag, {}))
        self.classes[name] = attributes
        for inner in element.all("default"):
            self.read(inner, inner.get("class"), attributes)

    def apply(self) -> None:
        for world in self.root.all("worldbody"):
            self.apply_inside(world, _MAIN)
        for section in self.root.all("equality"):
            for element in section.children:
                self.complete(element, "equality", _MAIN)
        for section in self.root.all("tendon"):
            for element in section.children:
                self.complete(element, "tendon", _MAIN)
        for section in self.root.all("actuator"):
            for element in section.children:
                self.complete(element, _DRIVE, _MAIN)

    def apply_inside(self, body: LocatedElement, name: str) -> None:
        """Complete what stands on a body or frame, under the class that holds there."""
        name = body.get("childclass", name)
        for child in body.children:
            if child.tag in _WITH_DEFAULTS:
                self.complete(child, child.tag, name)
            elif child.tag in ("body", "frame"):
                self.apply_inside(child, name)

    def complete(self, element: LocatedElement, tag: str, name: str) -> None:
        name = element.get("class", name)
        if name not in self.classes:
            hint = suggestion(name, self.classes)
            raise self.xml.error_at(element, f"there is no default class '{name}'{hint}")
        inherited = self.classes[name].get(tag, {})
        element.attributes = _completed(element.attributes, inherited)


def _completed(attributes: Attributes, inherited: Attributes) -> dict[str, str]:
    """Attributes with the inherited ones; an orientation goes before any inherited one."""
    completed = dict(inherited)
    if not ORIENTATIONS.isdisjoint(attributes):
        for name in ORIENTATIONS:
            completed.pop(name, None)
    completed.update(attributes)
    return completed


def _kind(tag: str) -> str:
    """The tag under which defaults of an element are kept."""
    if tag in _ALL_DRIVES:
        return _DRIVE
    return tag
