"""How entries are written where a bare number or name is a natural slip."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..document import Path_


def example(path: Path_, value: Any) -> str:
    """An entry as it may stand in place of a bare value, as `; as in gravity: [0, 0, -9.81]`; nothing for others.

    path: of the entry, or of the first number in a list that should be a mapping.
    """
    keys = [part for part in path if isinstance(part, str)]
    key = keys[-1] if keys else ""
    if key == "inertia" and path[-1] == 0:  # a list of moments
        return f"; as in inertia: {_EXAMPLES[key](value)}"
    if isinstance(value, (dict, list)) or value is None:
        return ""
    if keys[-2:-1] in (["pin"], ["between"]):  # the key is a link's name, the entry a place on it
        return f"; as in {key}: [{_told(value, '0.1')}, 0, 0]"
    if key not in _EXAMPLES:
        return ""
    if path and isinstance(path[-1], int) and key != "origin":  # [x, y, z] is natural there alone
        return ""
    return f"; as in {key}: {_EXAMPLES[key](value)}"


def _number(value: Any, otherwise: float) -> float:
    return (
        float(value)
        if isinstance(value, (int, float)) and not isinstance(value, bool)
        else otherwise
    )


def _told(value: Any, otherwise: str) -> str:
    """A number or an expression as it was written."""
    if isinstance(value, str):
        return (
            value if any(letter.isdigit() for letter in value) and "," not in value else otherwise
        )
    return f"{_number(value, float(otherwise)):g}"


def _name(value: Any, otherwise: str) -> str:
    return value if isinstance(value, str) and value.isidentifier() else otherwise


def _ends(value: Any) -> str:
    end = abs(_number(value, 1.5)) or 1.5
    return f"[{-end:g}, {end:g}]"


_EXAMPLES: dict[str, Callable[[Any], str]] = {
    "gravity": lambda value: f"[0, 0, {-abs(_number(value, 9.81)):g}]",
    "end_effector": lambda value: f"{{link: {_name(value, 'LINK')}}}",
    "com": lambda value: f"[{_told(value, '0.1')}, 0, 0]",
    "xyz": lambda value: f"[{_told(value, '0.1')}, 0, 0]",
    "rpy": lambda value: f"[0, 0, {_told(value, '0.5')}]",
    "origin": lambda value: f"{{xyz: [{_told(value, '0.1')}, 0, 0], rpy: [0, 0, pi/2]}}",
    "limits": _ends,
    "stroke": lambda value: f"[0, {abs(_number(value, 0.5)) or 0.5:g}]",
    "size": lambda value: "[{0}, {0}, {0}]".format(_told(value, "0.1")),
    "inertia": lambda _: "{xx: 0.1, yy: 0.1, zz: 0.1}, or {box: {size: [0.1, 0.1, 0.2]}}",
    "pin": lambda value: f"{{{_name(value, 'LINK')}: [0, 0, 0], OTHER_LINK: [0.1, 0, 0]}}",
    "between": lambda value: f"{{{_name(value, 'LINK')}: [0, 0, 0], OTHER_LINK: [0.1, 0, 0]}}",
    "active": lambda value: f"[{_name(value, 'JOINT')}]",
    "reference": lambda value: f"{{JOINT: {_number(value, 0.5):g}}}",
}
