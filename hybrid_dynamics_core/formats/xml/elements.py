"""A robot's XML file: names and numbers out of its elements, with messages that name file, line and entry."""

from __future__ import annotations

import math
from pathlib import Path

from ...description.document import Document, KeyPath, dotted
from ...errors import DescriptionError
from ...ground.wording import counted
from .tree import Element


class XmlFile:
    """A file and its root element."""

    def __init__(self, file: Path, root: Element) -> None:
        self.file, self.root = file, root

    def error(self, element: Element, key: KeyPath, problem: str) -> DescriptionError:
        """A DescriptionError at an element."""
        return DescriptionError(problem, key=dotted(key), file=self.file, line=element.line)

    def name(self, element: Element, kind: str) -> str:
        """The name of an element that has to have one."""
        name = element.attributes.get("name", "")
        if not name:
            raise self.error(element, (kind,), f"a <{element.tag}> has no name")
        return name

    def origin(self, element: Element, path: KeyPath, document: Document) -> dict[str, list[float]]:
        """The <origin> of an element, as URDF has it."""
        origin = element.first("origin")
        if origin is None:
            return {"xyz": [0.0, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]}
        document.set_location((*path, "origin"), self.file, origin.line)
        zero = [0.0, 0.0, 0.0]
        return {
            key: self.numbers(origin, key, 3, (*path, "origin", key), zero)
            for key in ("xyz", "rpy")
        }

    def numbers(
        self,
        element: Element,
        attribute: str,
        count: int,
        key: KeyPath,
        default: list[float] | None = None,
    ) -> list[float]:
        """The finite numbers of an attribute."""
        text = element.attributes.get(attribute)
        if text is None and default is not None:
            return default
        told = f"{attribute} is missing" if text is None else f'{attribute}="{text}"'
        return self._numbers(element, text or "", count, key, told)

    def inside(
        self, element: Element | None, count: int, key: KeyPath, default: list[float]
    ) -> list[float]:
        """The finite numbers between the tags of an element; `default` where there is no such element."""
        if element is None:
            return default
        return self._numbers(element, element.text, count, key, f"'{element.text.strip()}'")

    def _numbers(
        self, element: Element, text: str, count: int, key: KeyPath, told: str
    ) -> list[float]:
        try:
            values = [float(part) for part in text.split()]
        except ValueError:
            values = []
        if len(values) != count or not all(math.isfinite(v) for v in values):
            wanted = "a number" if count == 1 else counted(count, "number")
            raise self.error(element, key, f"<{element.tag}> {told}; expected {wanted}")
        return values
