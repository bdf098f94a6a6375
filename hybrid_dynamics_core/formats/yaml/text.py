"""Readable YAML of plain data: one line per entry if it fits, with exact numbers."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from typing import Any

from ...description.document import Data

WIDTH = 100  # letters of a line
_INDENT = "  "
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*")  # texts without quotes
_TAKEN = frozenset({"true", "false", "null", "yes", "no", "on", "off"})  # not text
_LARGEST_INTEGER = 1e15  # below this, integers are exact floats


class Expression(str):
    """A text that is written without quotes, such as pi/2."""

    __slots__ = ()


def yaml_text(data: Data) -> str:
    """The text of a mapping, with blank lines between sections.

    Args:
        data: dictionaries, lists, texts and numbers.
    """
    blocks: list[str] = []
    for key, value in data.items():
        is_section = isinstance(value, dict) and any(isinstance(v, dict) for v in value.values())
        lines = _section(key, value) if is_section else _entry(key, value, "")
        blocks.append("\n".join(lines))
    return "\n".join(blocks) + "\n"


def _section(key: str, entries: Data) -> Iterator[str]:
    yield f"{_scalar(key)}:"
    for name, entry in entries.items():
        yield from _entry(name, entry, _INDENT)


def _entry(key: str, value: Any, indent: str) -> Iterator[str]:
    """The lines of a key and its value: one line if it fits, otherwise one for each part."""
    line = f"{indent}{_scalar(key)}: {_flow(value)}"
    if len(line) <= WIDTH or not isinstance(value, (dict, list)):
        yield line
        return
    yield f"{indent}{_scalar(key)}:"
    inner = indent + _INDENT
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _entry(name, part, inner)
    else:
        for part in value:
            yield f"{inner}- {_flow(part)}"


def _flow(value: Any) -> str:
    """A value in one line."""
    if isinstance(value, dict):
        pairs = ", ".join(f"{_scalar(key)}: {_flow(part)}" for key, part in value.items())
        return f"{{{pairs}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return _number(float(value))
    is_plain = _PLAIN.fullmatch(value) and value.lower() not in _TAKEN
    if isinstance(value, Expression) or is_plain:
        return str(value)
    return json.dumps(value, ensure_ascii=False)


def _number(value: float) -> str:
    """The shortest exact text of a number; integers without a point."""
    if math.isinf(value):
        return ".inf" if value > 0.0 else "-.inf"
    if value.is_integer() and abs(value) < _LARGEST_INTEGER:
        return str(int(value))
    return repr(value)
