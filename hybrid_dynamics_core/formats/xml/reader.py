"""Typed access to XML elements, and entries of a document with the lines of elements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...description.document import Data, Document, KeyPath, dotted
from ...description.geometry import rotation_from_quaternion, rpy_of
from ...errors import DescriptionError
from ...ground.wording import counted
from .located_xml import LocatedElement

_ZERO_VECTOR = (0.0, 0.0, 0.0)


class XmlReader:
    """Reads the elements of one file into a document.

    Attributes:
        file: path of the file.
        root: its root element.
        document: the document to extend.
    """

    def __init__(self, file: Path, root: LocatedElement, document: Document) -> None:
        self.file = file
        self.root = root
        self.document = document
        self._collected: dict[str, list[str]] = {}

    # -- entries

    def add(self, path: tuple[str, str], entry: Data, element: LocatedElement) -> None:
        """Add an entry with the line of an element."""
        self.document.add_located(path, entry, self.file_of(element), element.line)

    def locate(self, path: KeyPath, element: LocatedElement) -> None:
        """Let errors at a path point at an element."""
        self.document.set_location(path, self.file_of(element), element.line)

    def error(self, element: LocatedElement, key: KeyPath, problem: str) -> DescriptionError:
        """A DescriptionError at an element, with the key of its entry."""
        file = self.file_of(element)
        return DescriptionError(problem, key=dotted(key), file=file, line=element.line)

    def error_at(self, element: LocatedElement, problem: str) -> DescriptionError:
        """A DescriptionError at a named element, with a key such as `joints.NAME`."""
        return self.error(element, (f"{element.tag}s", element.get("name")), problem)

    def note(self, element: LocatedElement, text: str) -> None:
        """Add a note on an element, with its line."""
        self.document.notes.append(f"{self.file_of(element).name}:{element.line}: {text}")

    def file_of(self, element: LocatedElement) -> Path:
        """The file of an element: this one or an included one."""
        return element.file or self.file

    def collect(self, element: LocatedElement, subject: str, text: str) -> None:
        """Collect a note that several elements may share, for `note_collected`."""
        self._collected.setdefault(text, []).append(f"{subject} (line {element.line})")

    def note_collected(self) -> None:
        """Add one note for each collected text, with all its subjects."""
        for text, subjects in self._collected.items():
            listed = ", ".join(subjects)
            self.document.notes.append(f"{self.file.name}: {text}: {listed}")
        self._collected.clear()

    # -- values

    def name(self, element: LocatedElement, kind: str) -> str:
        """The name of an element, which is required; `kind` is the key in messages."""
        name = element.get("name")
        if not name:
            raise self.error(element, (kind,), f"a <{element.tag}> has no name")
        return name

    def number(
        self, element: LocatedElement, attribute: str, key: KeyPath, default: float | None = None
    ) -> float:
        """The finite number of an attribute.

        Args:
            element: element with the attribute.
            attribute: name of it.
            key: key of the entry, for messages.
            default: value without the attribute; None if it is required.
        """
        defaults = None
        if default is not None:
            defaults = [default]
        return self.numbers(element, attribute, 1, key, defaults)[0]

    def numbers(
        self,
        element: LocatedElement,
        attribute: str,
        count: int,
        key: KeyPath,
        default: Sequence[float] | None = None,
    ) -> list[float]:
        """The finite numbers of an attribute.

        Args:
            element: element with the attribute.
            attribute: name of it.
            count: count of its numbers.
            key: key of the entry, for messages.
            default: value without the attribute; None if it is required.
        """
        text = element.attributes.get(attribute)
        if text is not None:
            return self._parse(element, text, count, key, f'{attribute}="{text}"')
        if default is None:
            raise self._no_numbers(element, count, key, f"{attribute} is missing")
        return list(default)

    def leading_numbers(self, element: LocatedElement, attribute: str, key: KeyPath) -> list[float]:
        """The finite numbers of an attribute, of any count; empty if the attribute is missing."""
        text = element.get(attribute)
        count = len(text.split())
        return self._parse(element, text, count, key, f'{attribute}="{text}"')

    def text_number(self, element: LocatedElement | None, key: KeyPath, default: float) -> float:
        """The finite number between the tags of an element; the default without the element."""
        return self.text_numbers(element, 1, key, [default])[0]

    def text_numbers(
        self, element: LocatedElement | None, count: int, key: KeyPath, default: Sequence[float]
    ) -> list[float]:
        """The finite numbers between the tags of an element; the default without the element."""
        if element is None:
            return list(default)
        return self._parse(element, element.text, count, key, f"'{element.text.strip()}'")

    def origin(self, element: LocatedElement, path: KeyPath) -> Data:
        """The pose of a URDF <origin>."""
        return self.pose(element.first("origin"), (*path, "origin"))

    def pose(self, origin: LocatedElement | None, key: KeyPath) -> Data:
        """A pose from xyz, and rpy or a quaternion; the identity without the element."""
        if origin is None:
            return {"xyz": list(_ZERO_VECTOR), "rpy": list(_ZERO_VECTOR)}
        self.locate(key, origin)
        xyz = self.numbers(origin, "xyz", 3, (*key, "xyz"), _ZERO_VECTOR)
        if "quat_xyzw" not in origin.attributes:
            rpy = self.numbers(origin, "rpy", 3, (*key, "rpy"), _ZERO_VECTOR)
            return {"xyz": xyz, "rpy": rpy}
        if "rpy" in origin.attributes:
            raise self.error(origin, key, "has rpy and quat_xyzw; expected one of them")
        x, y, z, w = self.numbers(origin, "quat_xyzw", 4, key)
        if not any((x, y, z, w)):
            raise self.error(origin, key, "quat_xyzw is zero, which is no rotation")
        rotation = rotation_from_quaternion(np.array([w, x, y, z]))
        return {"xyz": xyz, "rpy": rpy_of(rotation).tolist()}

    def _parse(
        self, element: LocatedElement, text: str, count: int, key: KeyPath, shown: str
    ) -> list[float]:
        try:
            values = [float(part) for part in text.split()]
        except ValueError:
            values = []
        if len(values) != count:
            raise self._no_numbers(element, count, key, shown)
        if not all(map(math.isfinite, values)):
            problem = f"<{element.tag}> {shown}, which is not finite; expected finite numbers"
            raise self.error(element, key, problem)
        return values

    def _no_numbers(
        self, element: LocatedElement, count: int, key: KeyPath, shown: str
    ) -> DescriptionError:
        expected = "a number" if count == 1 else counted(count, "number")
        if "$(" in shown or "${" in shown:
            expected += "; this is an expression of xacro: give the file a name in .urdf.xacro"
        return self.error(element, key, f"<{element.tag}> {shown}; expected {expected}")
