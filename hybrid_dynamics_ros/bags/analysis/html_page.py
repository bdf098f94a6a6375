"""HTML of a report: a self-contained page, and its tables."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Final

_NUMBER_STARTS: Final = tuple("-0123456789")
_STYLE: Final = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1080px; \
margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0; } \
h2 { font-size: 1.15em; margin-top: 2.2em; border-bottom: 1px solid #ddd; }
p.quiet { color: #666; margin-top: .2em; } div.wide { overflow-x: auto; }
svg { width: 100%; min-width: 640px; height: auto; }
table { border-collapse: collapse; margin: .6em 0; } th { text-align: left; font-weight: 600; }
td, th { padding: .15em 1.2em .15em 0; border-bottom: 1px solid #eee; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.warn { background: #fff4e5; border-left: 4px solid #e08a00; padding: .5em 1em; }
"""


def page(title: str, parts: Sequence[str]) -> str:
    """A page.

    Args:
        title: plain text.
        parts: parts of its body, as HTML.
    """
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="generator" content="hybrid_dynamics">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n"
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def quiet(text: str) -> str:
    """A paragraph in grey; the text is HTML."""
    return f'<p class="quiet">{text}</p>'


def warning(text: str, entries: Sequence[str]) -> str:
    """A box with a list of plain texts."""
    items = "".join(f"<li>{html.escape(entry)}</li>" for entry in entries)
    return f'<div class="warn">{text}<ul>{items}</ul></div>'


def wide(part: str) -> str:
    """A part that scrolls horizontally by itself on a narrow screen."""
    return f'<div class="wide">{part}</div>'


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of plain texts.

    Args:
        head: titles of the columns; if there are any, columns of numbers are right-aligned.
        rows: the cells of each row.
    """
    is_numeric = [False] * len(rows[0])
    if head:
        is_numeric = [_is_numeric(column) for column in zip(*rows, strict=True)]
    lines = [_line(row, "td", is_numeric) for row in rows]
    if head:
        lines.insert(0, _line(head, "th", is_numeric))
    return wide(f"<table>{''.join(lines)}</table>")


def _is_numeric(cells: Sequence[str]) -> bool:
    return all(cell[:1] in _NUMBER_STARTS for cell in cells)


def _line(cells: Sequence[str], tag: str, is_numeric: Sequence[bool]) -> str:
    parts = []
    for cell, numeric in zip(cells, is_numeric, strict=True):
        style = " class=n" if numeric else ""
        parts.append(f"<{tag}{style}>{html.escape(cell)}</{tag}>")
    return f"<tr>{''.join(parts)}</tr>"


def digits(value: float) -> str:
    """A number with four significant digits; large ones without an exponent."""
    if abs(value) < 1e4:
        return f"{value:.4g}"
    rounded = float(f"{value:.4g}")
    return f"{rounded:,.0f}"
