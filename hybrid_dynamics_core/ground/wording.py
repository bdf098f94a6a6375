"""Counts and line breaks in messages."""

from __future__ import annotations

_SENTENCE_ENDS = (".", ":", ";", ",")


def counted(count: int, what: str, plural: str = "") -> str:
    """`1 loop`, `2 loops`; `plural` is for words that take more than an s."""
    return f"{count} {singular_or_plural(count, what, plural or what + 's')}"


def singular_or_plural(count: int, singular: str, plural: str) -> str:
    """The word that fits a count: `singular_or_plural(1, "is", "are")` is `is`."""
    return singular if count == 1 else plural


def one_line(text: object) -> str:
    """A message of several lines joined into one, as sentences."""
    joined = ""
    for line in str(text).splitlines():
        words = " ".join(line.split())
        if not words:
            continue
        if joined:
            joined += " " if joined.endswith(_SENTENCE_ENDS) else "; "
        joined += words
    return joined
