"""Entries of nested plain data by path; changes leave the data that they start from."""

from __future__ import annotations

from typing import Any

from ..document import KeyPath
from .number_keys import unwritten


def has_entry(data: Any, path: KeyPath) -> bool:
    """Whether the data have an entry at a path."""
    for key in path:
        if not _has_key(data, key):
            return False
        data = data[key]
    return True


def entry_at(data: Any, path: KeyPath) -> Any:
    """The entry at a path; one that is left out has the value that it counts as.

    None if there is no such entry.
    """
    for k, key in enumerate(path):
        if not _has_key(data, key):
            return _omitted(path, k)
        data = data[key]
    return data


def with_entry(data: Any, path: KeyPath, value: Any) -> Any:
    """A copy of the data with another entry at a path; mappings on the way are added."""
    return _with(data, path, 0, value)


def _with(data: Any, path: KeyPath, depth: int, value: Any) -> Any:
    if depth == len(path):
        return value
    key = path[depth]
    inner = None
    if _has_key(data, key):
        inner = data[key]
    elif depth + 1 < len(path):
        inner = unwritten(path[: depth + 1])
    changed = _with(inner, path, depth + 1, value)
    if isinstance(data, list):
        copy: Any = list(data)
    else:
        copy = dict(data or {})
    copy[key] = changed
    return copy


def _omitted(path: KeyPath, depth: int) -> Any:
    """The value of an entry whose key at `depth` is left out."""
    for end in range(depth + 1, len(path) + 1):
        value = unwritten(path[:end])
        if value is not None:
            return entry_at(value, path[end:])
    return None


def _has_key(data: Any, key: str | int) -> bool:
    if isinstance(key, int):
        return isinstance(data, list) and 0 <= key < len(data)
    return isinstance(data, dict) and key in data
