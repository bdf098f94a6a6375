"""Results as tables, or as JSON."""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core.ground.arrays import Array

from .exit_codes import MISUSED

AS_JSON = f"{__package__}.as_json"  # in `meta` of click's contexts: whether JSON is requested
ANSWERED = f"{__package__}.answered"  # in `meta` too: whether the JSON document has been printed
WIDTH = 80  # characters of a line, unless a terminal is wider
GAP = 2  # characters between columns
ROUNDING = 1e-12  # rounding error of a value of order one
SAME_POSITION = 1e-9  # [m] difference of equal positions, by the tolerance of closure


def show(data: Mapping[str, Any], as_json: bool, text: str) -> None:
    """Print a result as JSON or as text.

    Args:
        data: the result as plain data, for JSON.
        as_json: whether to print JSON.
        text: the result as text.
    """
    if not as_json:
        click.echo(text.rstrip())
        return
    click.echo(json.dumps(plain(data), indent=2, allow_nan=False))
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta[ANSWERED] = True


def show_written(path: str | Path, what: str, as_json: bool) -> None:
    """Print the name of a written file, except with JSON, which contains it already."""
    if not as_json:
        click.echo(written(path, what))


def written(path: str | Path, what: str = "") -> str:
    """The line with the name and the contents of a written file or folder."""
    if not what:
        return f"written: {path}"
    return f"written: {path} ({what})"


def fail(context: click.Context, error: click.ClickException) -> None:
    """Print an error as JSON, unless a result has already been printed."""
    if context.meta.get(ANSWERED):
        return
    report = {"kind": _kind(error), "text": error.format_message()}
    show({"error": report}, as_json=True, text="")


def _kind(error: click.ClickException) -> str:
    """The class name of the cause of an error; UsageError for all errors of usage in click."""
    if isinstance(error, click.UsageError):
        return "UsageError"
    if error.exit_code == MISUSED and error.__cause__ is None:
        return "UsageError"
    return type(error.__cause__ or error).__name__


def plain(value: Any) -> Any:
    """A value converted for JSON: arrays to lists, numbers that are not finite to null."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(entry) for entry in value]
    return value


def by_name(names: Sequence[str], values: Iterable[Any]) -> dict[str, Any]:
    """A mapping from names to values, one a name."""
    return dict(zip(names, values, strict=True))


def number(value: float) -> str:
    """A number with at most six digits; `-` if it is not finite."""
    if not math.isfinite(value):
        return "-"
    return f"{value + 0.0:.6g}"


def zero_if_small(value: float, limit: float = ROUNDING) -> float:
    """A value, or zero if its magnitude is at most a limit."""
    if abs(value) > limit:
        return value
    return 0.0


@dataclass(frozen=True)
class _Column:
    """The texts of a column, beginning with head and rule; numbers are aligned right."""

    texts: tuple[str, ...]
    width: int
    is_numeric: bool

    def line(self, k: int) -> str:
        """The k-th text, padded to the width of the column."""
        if self.is_numeric:
            return self.texts[k].rjust(self.width)
        return self.texts[k].ljust(self.width)


def line_width() -> int:
    """Characters of a line: the width of the terminal, but at least `WIDTH`."""
    if not sys.stdout.isatty():
        return WIDTH
    return max(WIDTH, shutil.get_terminal_size((WIDTH, 0)).columns)


def table(
    head: Sequence[str], rows: Sequence[Sequence[object]], break_before: int | None = None
) -> str:
    """A text table; numbers that are only rounding errors are shown as zero.

    A table wider than a terminal is split into blocks, each beginning with the first column.

    Args:
        head: (k) names of the columns.
        rows: rows of k entries.
        break_before: index of a column that begins a new block if the table is split.
    """
    columns = [_column(name, [row[k] for row in rows]) for k, name in enumerate(head)]
    blocks = [_block(group) for group in _groups(columns, break_before)]
    return "\n\n".join(blocks)


def _column(name: str, entries: Sequence[object]) -> _Column:
    cells = [_cell(entry) for entry in entries]
    width = max(map(len, [name, *cells]))
    is_numeric = bool(entries) and isinstance(entries[0], (float, int))
    return _Column((name, "-" * width, *cells), width, is_numeric)


def _cell(entry: object) -> str:
    if isinstance(entry, float):
        return number(zero_if_small(entry))
    return str(entry)


def _block(columns: Sequence[_Column]) -> str:
    """The lines of columns side by side."""
    lines = []
    for k in range(len(columns[0].texts)):
        cells = [column.line(k) for column in columns]
        lines.append((" " * GAP).join(cells).rstrip())
    return "\n".join(lines)


def _groups(columns: Sequence[_Column], break_before: int | None) -> list[list[_Column]]:
    """Groups of columns, each no wider than a terminal and with the first column."""
    most = line_width()
    if _width(columns) <= most:
        return [list(columns)]
    groups = [[columns[0]]]
    for k, column in enumerate(columns[1:], start=1):
        is_full = _width([*groups[-1], column]) > most or k == break_before
        if is_full and len(groups[-1]) > 1:
            groups.append([columns[0]])
        groups[-1].append(column)
    for previous, group in pairwise(groups):
        _join_lone_text(previous, group)
    return groups


def _join_lone_text(previous: list[_Column], group: list[_Column]) -> None:
    """Move the column before a lone column of text, such as a unit, into its group."""
    is_lone = len(group) == 2 and not group[1].is_numeric
    if not is_lone or len(previous) <= 2:
        return
    if _width([*group, previous[-1]]) <= line_width():
        group.insert(1, previous.pop())


def _width(columns: Sequence[_Column]) -> int:
    """Width of columns side by side, in characters."""
    return sum(column.width for column in columns) + GAP * (len(columns) - 1)


def constant_axes(positions: Sequence[Array]) -> dict[str, float]:
    """Coordinates [m] that are equal in all positions, as in a planar mechanism.

    Args:
        positions: positions (3,) [m]. The result is empty for fewer than two.

    Returns:
        By axis `x`, `y` or `z`: the constant value.
    """
    if len(positions) < 2:
        return {}
    low = np.min(positions, axis=0)
    extent = np.max(positions, axis=0) - low
    constant = {}
    for k, axis in enumerate("xyz"):
        if extent[k] < SAME_POSITION:
            constant[axis] = zero_if_small(float(low[k]), SAME_POSITION)
    return constant


def along_axes(values: Array) -> str:
    """Numbers as one text; rounding errors are shown as zero."""
    return "  ".join(number(zero_if_small(value)) for value in values.tolist())
