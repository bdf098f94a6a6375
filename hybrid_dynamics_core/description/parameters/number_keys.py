"""Entries of a description that are numbers, by the published schema."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..checks.schema import robot_schema
from ..document import Data, KeyPath

_BRANCHES = ("if", "then", "else")
_LISTS = ("oneOf", "anyOf", "allOf")
_ZEROS = (0, 0, 0)
_UNWRITTEN: Data = {  # numbers that count as zero where they are left out
    "mass": 0,
    "offset": 0,
    "com": _ZEROS,
    "xyz": _ZEROS,
    "rpy": _ZEROS,
    "gravity": (0, 0, -9.81),
}


def number_leaves(data: Any, path: KeyPath = ()) -> Iterator[KeyPath]:
    """Paths of all numbers and expressions in the data of a robot.

    Args:
        data: the data at `path`.
        path: keys and indices down to the data.
    """
    if isinstance(data, dict):
        for key, value in data.items():
            yield from number_leaves(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from number_leaves(value, (*path, index))
    elif is_number_key(path):
        yield path


def is_number_key(path: KeyPath) -> bool:
    """Whether the schema has a number at a path."""
    return any(_is_number(schema) for schema in _schemas_at(path))


def unwritten(path: KeyPath) -> Any:
    """The value of a key that is left out; None if it does not count as zero."""
    key = path[-1]
    if not isinstance(key, str) or key not in _UNWRITTEN:
        return None
    value = _UNWRITTEN[key]
    if isinstance(value, tuple):
        return list(value) if is_number_key((*path, 0)) else None
    return value if is_number_key(path) else None


def is_schema_key(path: KeyPath) -> bool:
    """Whether the schema names the last key of a path, as `offset` and not as a joint's name."""
    return any(path[-1] in schema.get("properties", {}) for schema in _schemas_at(path[:-1]))


def _schemas_at(path: KeyPath) -> list[Data]:
    """All schemas that may apply at a path."""
    schemas = list(_resolved(robot_schema()))
    for key in path:
        inner: list[Data] = []
        for schema in schemas:
            child = _child(schema, key)
            if child is not None:
                inner += _resolved(child)
        schemas = inner
    return schemas


def _child(schema: Data, key: str | int) -> Data | None:
    child: Any
    if isinstance(key, int):
        child = schema.get("items")
    elif key in schema.get("properties", {}):
        child = schema["properties"][key]
    else:
        child = schema.get("additionalProperties")
    return child if isinstance(child, dict) else None


def _resolved(schema: Data) -> Iterator[Data]:
    """A schema with the schemas that it refers to, and its branches."""
    yield schema
    reference = schema.get("$ref", "")
    if reference:
        name = reference.rpartition("/")[2]
        yield from _resolved(robot_schema()["$defs"][name])
    for key in _BRANCHES:
        if key in schema:
            yield from _resolved(schema[key])
    for key in _LISTS:
        for branch in schema.get(key, []):
            yield from _resolved(branch)


def _is_number(schema: Data) -> bool:
    return "number" in schema.get("type", ())
