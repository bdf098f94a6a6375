"""Measured tables put where people read them: between two marks of a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

START, END = "<!-- measured: {} -->", "<!-- end -->"


def put(page: Path, name: str, lines: Sequence[str]) -> None:
    """Replace what stands between the marks of `name`.

    ValueError where the page has no such marks.
    """
    text = page.read_text(encoding="utf-8")
    start = START.format(name)
    before, found, rest = text.partition(start)
    _, closed, after = rest.partition(END)
    if not found or not closed:
        raise ValueError(f"{page}: expected the marks {start} and {END}")
    body = "\n".join(lines).strip()
    page.write_text(f"{before}{start}\n{body}\n{END}{after}", encoding="utf-8")
