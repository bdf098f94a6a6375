"""Examples of entries, for errors on a bare number or name in their place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..document import KeyPath


def example(path: KeyPath, value: Any) -> str:
    """A hint on how to write an entry, such as `; as in gravity: [0, 0, -9.81]`.

    Args:
        path: path of the entry, or of the first number in a list that should be a mapping.
        value: the wrong value there.

    Returns:
        The hint, or an empty text where no example fits.
    """
    keys = [part for part in path if isinstance(part, str)]
    if not keys:
        return ""
    key = keys[-1]
    if key == "inertia" and path[-1] == 0:  # a list of moments
        return f"; as in inertia: {_EXAMPLES[key](value)}"
    if isinstance(value, (dict, list)) or value is None:
        return ""
    parent = keys[-2] if len(keys) > 1 else ""
    if parent in ("pin", "between"):  # the key is a link's name, the entry a point on it
        return f"; as in {key}: {_point(value)}"
    in_list = isinstance(path[-1], int)
    if key not in _EXAMPLES or (in_list and key != "origin"):  # elsewhere [x, y, z] is right
        return ""
    return f"; as in {key}: {_EXAMPLES[key](value)}"


def _number(value: Any, default: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return default
    return float(value)


def _size_or(value: Any, default: float) -> float:
    """The absolute value of a number; the default if it is zero or no number."""
    return abs(_number(value, default)) or default


def _as_written(value: Any, default: str) -> str:
    """A number or an expression as it was written."""
    if not isinstance(value, str):
        return f"{_number(value, float(default)):g}"
    has_digit = any(letter.isdigit() for letter in value)
    if not has_digit or "," in value:
        return default
    return value


def _name(value: Any, default: str) -> str:
    if isinstance(value, str) and value.isidentifier():
        return value
    return default


def _gravity(value: Any) -> str:
    return f"[0, 0, {-abs(_number(value, 9.81)):g}]"


def _point(value: Any) -> str:
    return f"[{_as_written(value, '0.1')}, 0, 0]"


def _angles(value: Any) -> str:
    return f"[0, 0, {_as_written(value, '0.5')}]"


def _size(value: Any) -> str:
    edge = _as_written(value, "0.1")
    return f"[{edge}, {edge}, {edge}]"


def _limits(value: Any) -> str:
    end = _size_or(value, 1.5)
    return f"[{-end:g}, {end:g}]"


def _stroke(value: Any) -> str:
    return f"[0, {_size_or(value, 0.5):g}]"


def _two_links(value: Any) -> str:
    return f"{{{_name(value, 'LINK')}: [0, 0, 0], OTHER_LINK: [0.1, 0, 0]}}"


_EXAMPLES: dict[str, Callable[[Any], str]] = {
    "gravity": _gravity,
    "end_effector": lambda value: f"{{link: {_name(value, 'LINK')}}}",
    "com": _point,
    "xyz": _point,
    "rpy": _angles,
    "origin": lambda value: f"{{xyz: {_point(value)}, rpy: [0, 0, pi/2]}}",
    "limits": _limits,
    "stroke": _stroke,
    "size": _size,
    "inertia": lambda _: "{xx: 0.1, yy: 0.1, zz: 0.1}, or {box: {size: [0.1, 0.1, 0.2]}}",
    "pin": _two_links,
    "between": _two_links,
    "active": lambda value: f"[{_name(value, 'JOINT')}]",
    "reference": lambda value: f"{{JOINT: {_number(value, 0.5):g}}}",
}
