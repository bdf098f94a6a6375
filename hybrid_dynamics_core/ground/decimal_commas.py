"""Decimal commas: what YAML and options make of 3,2 tells that a point was meant."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from .suggestions import meant

POINT = "; decimals are written with a point"
_ALONE = re.compile(r"\s*([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)\s*")


def with_point(text: str) -> str | None:
    """'3.2' for a text such as '3,2'; None for all others."""
    match = _ALONE.fullmatch(text)
    return f"{match[1]}.{match[2]}" if match else None


def comma_in_mapping(entries: Mapping[Any, Any], key: str) -> str:
    """A hint where a key is the rest of a number: {mass: 3,2} is a mass of 3 and a key 2."""
    if not key.isdigit():
        return ""
    names = [str(name) for name in entries]
    before = names[names.index(key) - 1] if key in names[1:] else ""
    value = entries.get(before)
    if (
        entries.get(key, entries.get(int(key))) is not None
        or isinstance(value, bool)
        or not isinstance(value, int)
    ):
        return ""
    return POINT + meant(f"{before}: {value}.{key}")


def comma_in_list(values: Sequence[Any], wanted: int) -> str:
    """A hint where a list has more numbers than wanted: [0,8, 0,03, 0] has five."""
    whole = [isinstance(value, int) and not isinstance(value, bool) for value in values]
    return (
        f"{POINT} (0.8), and commas part the entries" if len(values) > wanted and all(whole) else ""
    )
