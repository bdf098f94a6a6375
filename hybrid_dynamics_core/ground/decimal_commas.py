"""Hints for numbers with a decimal comma, such as 3,2 in YAML or options."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from .suggestions import did_you_mean

POINT_HINT = "; decimals are written with a point"
_NUMBER = re.compile(r"\s*([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)\s*")


def with_point(text: str) -> str | None:
    """'3.2' for a text such as '3,2'; None for all others."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        return None
    return f"{match[1]}.{match[2]}"


def comma_in_mapping(entries: Mapping[Any, Any], key: str) -> str:
    """A hint if a key is the fraction of such a number; otherwise empty.

    YAML reads {mass: 3,2} as a mass of 3 and a key 2 without a value.
    """
    names = [str(name) for name in entries]
    if not key.isdigit() or key not in names[1:]:
        return ""
    tail = entries.get(key, entries.get(int(key)))
    before = names[names.index(key) - 1]
    number = entries.get(before)
    if tail is not None or not _is_integer(number):
        return ""
    return POINT_HINT + did_you_mean(f"{before}: {number}.{key}")


def comma_in_list(values: Sequence[Any], expected: int) -> str:
    """A hint if a list has too many numbers, as [0,8, 0,03, 0] has five; otherwise empty."""
    if len(values) <= expected or not all(map(_is_integer, values)):
        return ""
    return f"{POINT_HINT} (0.8), and commas part the entries"


def _is_integer(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)
