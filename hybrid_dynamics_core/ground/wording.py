"""Counts and units in messages."""

from __future__ import annotations


def counted(count: int, what: str, more: str = "") -> str:
    """`1 loop`, `2 loops`; `more`: the plural, where it is no mere s."""
    return f"{count} {agreed(count, what, more or what + 's')}"


def one_line(text: object) -> str:
    """A message of several lines in one: lines are parted as sentences are."""
    lines = [" ".join(line.split()) for line in str(text).splitlines()]
    whole = ""
    for line in filter(None, lines):
        whole += (" " if whole.endswith((".", ":", ";", ",")) else "; ") + line if whole else line
    return whole


def unit(joint_type: str, rate: str = "") -> str:
    """Unit of a joint's coordinate, or with `rate` of its rates: `/s`, `/s^2`."""
    return ("rad" if joint_type == "revolute" else "m") + rate


def agreed(count: int, one: str, many: str) -> str:
    """The word that fits a count: `agreed(1, "is", "are")` is `is`."""
    return one if count == 1 else many
