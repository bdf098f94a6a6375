"""Numbers replaced in the text of a YAML or JSON file; everything else stays as it was written."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

import yaml

from ..description.document import KeyPath
from .adjustable import Change

DIGITS = 12  # significant digits of a written number
_PLAIN = re.compile(r"[A-Za-z_][\w./-]*")


class NotWritableError(LookupError):
    """An entry has no place of its own in a text."""


def with_numbers(text: str, numbers: Mapping[KeyPath, Change]) -> str:
    """The text with some numbers or lists replaced, or added where they were left out.

    Args:
        text: the text of the file.
        numbers: values by path.

    Raises:
        NotWritableError: an entry is shared by an alias, or has no place in the text.
    """
    for path, value in numbers.items():
        text = _with_number(text, path, _written(value))
    return text


def without_entry(text: str, path: KeyPath) -> str:
    """The text without an entry of a mapping in braces, as `assembly: parallelogram`.

    Raises:
        NotWritableError: the entry is not in braces.
    """
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    for key in path[:-1]:
        node = _child(node, key)
    if not isinstance(node, yaml.MappingNode) or not node.flow_style:
        raise NotWritableError
    for name, value in node.value:
        if name.value == path[-1]:
            before = text[: name.start_mark.index].rstrip().removesuffix(",")
            return before + text[value.end_mark.index :]
    raise NotWritableError


def written_number(value: float) -> str:
    """A number with twelve digits."""
    return f"{value:.{DIGITS}g}"


def _written(value: Change) -> str:
    """A number, or a list, as text."""
    if not isinstance(value, list):
        return written_number(value)
    words = map(written_number, value)
    return f"[{', '.join(words)}]"


def _with_number(text: str, path: KeyPath, value: str) -> str:
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    node = root
    for depth, key in enumerate(path):
        child = _child(node, key)
        if child is None:
            return _added(text, node, path[depth:], value)
        node = child
    if not isinstance(node, yaml.ScalarNode) or _count(root, node) != 1:
        raise NotWritableError
    return _with_comment_in_place(text, node, value)


def _child(node: yaml.Node | None, key: str | int) -> yaml.Node | None:
    """What is under a key; None if nothing is."""
    if isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
        item: yaml.Node = node.value[key]
        return item
    if isinstance(node, yaml.MappingNode):
        for name, value in node.value:
            if name.value == key:
                entry: yaml.Node = value
                return entry
    return None


def _count(root: yaml.Node | None, node: yaml.Node) -> int:
    """How often a node occurs below a root: more than once if aliases stand for it."""
    total = int(root is node)
    if isinstance(root, yaml.SequenceNode):
        total += sum(_count(item, node) for item in root.value)
    elif isinstance(root, yaml.MappingNode):
        total += sum(_count(item, node) for _, item in root.value)
    return total


def _with_comment_in_place(text: str, node: yaml.Node, new: str) -> str:
    """The text with another number; a comment behind it stays in its column if there is room."""
    before, after = text[: node.start_mark.index], text[node.end_mark.index :]
    blanks = len(after) - len(after.lstrip(" "))
    longer = len(new) - (node.end_mark.index - node.start_mark.index)
    if after[blanks : blanks + 1] == "#":
        after = " " * max(blanks - longer, 1) + after[blanks:]
    return before + new + after


def _added(text: str, node: yaml.Node | None, path: KeyPath, value: str) -> str:
    """The text with an entry that was left out."""
    if not isinstance(node, yaml.MappingNode) or not isinstance(path[0], str):
        raise NotWritableError
    is_json = text.lstrip("\ufeff \t\r\n").startswith("{")
    entry = f"{_key(path[0], is_json)}: {_flow(path[1:], value, is_json)}"
    if node.flow_style:
        end = node.end_mark.index - 1
        comma = ", " if node.value else ""
        before = text[:end].rstrip()
        return f"{before}{comma}{entry}{text[end:]}"
    start = node.start_mark
    indent = " " * start.column
    return f"{text[: start.index]}{entry}\n{indent}{text[start.index :]}"


def _flow(path: KeyPath, value: str, is_json: bool) -> str:
    """The text of an entry at a path below a new key."""
    if not path:
        return value
    key = path[0]
    if isinstance(key, int):
        words = ["0", "0", "0"]
        words[key] = value
        return f"[{', '.join(words)}]"
    return f"{{{_key(key, is_json)}: {_flow(path[1:], value, is_json)}}}"


def _key(key: str, is_json: bool) -> str:
    if not is_json and _PLAIN.fullmatch(key):
        return key
    return json.dumps(key, ensure_ascii=False)
