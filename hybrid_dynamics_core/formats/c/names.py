"""Names of a description as C identifiers, and as text that no compiler can misread."""

from __future__ import annotations

import re
from collections.abc import Iterable

_SAFE = re.compile(r"[A-Za-z0-9_./-]")


def identifier(name: str) -> str:
    """A C identifier: other characters become `_`, without two in a row or one at an end."""
    parts = re.findall(r"[A-Za-z0-9]+", name)
    text = "_".join(parts) or "robot"
    if text[0].isdigit():
        return f"robot_{text}"
    return text


def identifiers(names: Iterable[str]) -> dict[str, str]:
    """Different identifiers by name; equal ones are numbered.

    They follow a prefix, and so may begin with a digit.
    """
    result: dict[str, str] = {}
    for name in names:
        base = "_".join(re.findall(r"[A-Za-z0-9]+", name)) or "coordinate"
        text, number = base, 1
        while text in result.values():
            number += 1
            text = f"{base}_{number}"
        result[name] = text
    return result


def comment(name: str) -> str:
    """A name inside a comment: other characters as `<U+002A>`."""
    return "".join(x if _SAFE.fullmatch(x) else f"<U+{ord(x):04X}>" for x in name)


def literal(name: str) -> str:
    """A name as a C string: other characters as octal bytes of UTF-8."""
    text = ""
    for character in name:
        if _SAFE.fullmatch(character):
            text += character
        else:
            text += "".join(f"\\{byte:03o}" for byte in character.encode())
    return f'"{text}"'


def package_name(prefix: str) -> str:
    """A name of a ROS package: small letters, digits and `_`."""
    return f"{prefix.lower()}_model"
