"""Entries of a document: mappings with typed access to their values."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ..errors import DescriptionError
from ..ground.arrays import Array
from .document import Data, KeyPath
from .geometry import Transform
from .values import ValueReader

_ZERO_VECTOR = (0, 0, 0)


class Entry:
    """A mapping at a path of a document.

    A key that is left out is zero, or the identity for a pose.

    Attributes:
        values: reads the values.
        data: the mapping.
        path: path of the mapping.
    """

    def __init__(self, values: ValueReader, data: Data | None, path: KeyPath) -> None:
        self.values = values
        self.data = data or {}
        self.path = path

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __getitem__(self, key: str) -> Any:
        """The plain data of a key that the schema requires."""
        return self.data[key]

    def get(self, key: str, default: Any = None) -> Any:
        """The plain data of a key."""
        return self.data.get(key, default)

    def sub(self, key: str) -> Entry:
        """The mapping of a key; empty if the key is left out."""
        data = self.data.get(key)
        return Entry(self.values, data, self.key_path(key))

    def number(self, key: str, default: float = 0.0) -> float:
        """A finite number."""
        value = self.data.get(key, default)
        return self.values.number(value, self.key_path(key))

    def length(self, key: str) -> float:
        """A number [m] above zero."""
        return self.values.length(self.data[key], self.key_path(key))

    def coordinate(self, key: str, joint_type: str) -> float:
        """A value of a joint's coordinate [rad or m]."""
        value = self.data.get(key, 0)
        if joint_type == "revolute":
            return self.values.angle(value, self.key_path(key))
        return self.values.number(value, self.key_path(key))

    def vector(self, key: str) -> Array:
        """An array; zeros (3,) if the key is left out."""
        vector = self.data.get(key, _ZERO_VECTOR)
        return self.values.vector(vector, self.key_path(key))

    def axis(self, key: str) -> Array:
        """A unit vector (3,)."""
        return self.values.axis(self.data[key], self.key_path(key))

    def limits(self, key: str) -> tuple[float, float]:
        """(lower, upper); infinite if the key is left out."""
        limits = self.data.get(key)
        return self.values.limits(limits, self.key_path(key))

    def bound(self, key: str) -> float:
        """A number above zero; infinite if the key is left out."""
        value = self.data.get(key, math.inf)
        number = self.values.number_or_infinity(value, self.key_path(key))
        if not number > 0.0:
            raise self.error(key, f"is {number:g}; expected a number above zero")
        return number

    def pose(self, key: str) -> Transform:
        """A pose from {xyz, rpy}, or from a list of such steps."""
        pose = self.data.get(key, {})
        return self.values.pose(pose, self.key_path(key))

    def as_pose(self) -> Transform:
        """The pose that this mapping gives."""
        return self.values.pose(self.data, self.path)

    def key_path(self, key: str) -> KeyPath:
        """The path of a value."""
        return (*self.path, key)

    def error(self, key: str, problem: str) -> DescriptionError:
        """A DescriptionError at a key."""
        return self.values.document.error(self.key_path(key), problem)


def section_entry(values: ValueReader, section: str) -> Entry:
    """A top-level mapping; empty if the document has none."""
    data = values.document.entries(section)
    return Entry(values, data, (section,))


def section_entries(values: ValueReader, section: str) -> dict[str, Entry]:
    """The mappings of a section by name."""
    top = section_entry(values, section)
    return {name: top.sub(name) for name in top}
