"""Measured tables put where people read them: between two marks of a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

START = "<!-- measured: {} -->"
END = "<!-- end -->"


def put(page: Path, name: str, lines: Sequence[str]) -> None:
    """Replace what stands between the marks of a table.

    Args:
        page: a Markdown file.
        name: of the table, as its mark has it.
        lines: of the table.

    Raises:
        ValueError: the page has no such marks.
    """
    text = page.read_text(encoding="utf-8")
    start = START.format(name)
    before, has_start, remaining = text.partition(start)
    _, has_end, after = remaining.partition(END)
    if not has_start or not has_end:
        raise ValueError(f"{page}: expected the marks {start} and {END}")
    body = "\n".join(lines).strip()
    page.write_text(f"{before}{start}\n{body}\n{END}{after}", encoding="utf-8")
