"""Results as tables for people, or as JSON for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core.ground.arrays import Array

from .exit_codes import MISUSED

AS_JSON = f"{__package__}.as_json"  # in the meta of click's contexts: whether JSON is asked for,
ANSWERED = f"{__package__}.answered"  # and whether it is printed: stdout holds one document
WIDTH = 80  # letters of a terminal
ROUNDING = 1e-12  # below it a value of order one is noise
ALIKE = 1e-9  # [m] positions that differ less are one: loops close to about that


def show(told: Mapping[str, Any], as_json: bool, text: str) -> None:
    """Print one of the two forms of a result."""
    if not as_json:
        click.echo(text.rstrip())
        return
    click.echo(json.dumps(plain(told), indent=2, allow_nan=False))
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta[ANSWERED] = True


def written(path: str | Path, what: str = "") -> str:
    """The line that tells of a file or folder that was written, and what is in it."""
    return f"written: {path}" + (f" ({what})" if what else "")


def fail(context: click.Context, error: click.ClickException) -> None:
    """Print an error as JSON, unless an answer is printed already; its kind is the class of what caused it."""
    usage = isinstance(error, click.UsageError) or (
        error.exit_code == MISUSED and error.__cause__ is None
    )
    kind = "UsageError" if usage else type(error.__cause__ or error).__name__
    if not context.meta.get(ANSWERED):
        show({"error": {"kind": kind, "text": error.format_message()}}, as_json=True, text="")


def plain(value: Any) -> Any:
    """The value as JSON takes it: arrays as lists, numbers that are not finite as null."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(entry) for entry in value]
    return value


def number(value: float) -> str:
    """Six digits, as short as they can be told."""
    return "-" if not math.isfinite(value) else f"{value + 0.0:.6g}"


def table(head: Sequence[str], rows: Sequence[Sequence[object]], apart: int | None = None) -> str:
    """Columns under a head: numbers to the right, text to the left; what is only rounding is shown as zero.

    A table that is wider than a terminal goes on below, each time beside its first column and, so
    that what goes on is no lone column of text, with one before; `apart`: the column that then
    begins below in any case.
    """
    cells = [
        [number(v if abs(v) > ROUNDING else 0.0) if isinstance(v, float) else str(v) for v in row]
        for row in rows
    ]
    right = [bool(rows) and isinstance(rows[0][k], (float, int)) for k in range(len(head))]
    widths = [max(len(line[k]) for line in [list(head), *cells]) for k in range(len(head))]

    def line(parts: Sequence[str], columns: Sequence[int]) -> str:
        padded = [
            parts[k].rjust(widths[k]) if right[k] else parts[k].ljust(widths[k]) for k in columns
        ]
        return "  ".join(padded).rstrip()

    lines = [list(head), ["-" * width for width in widths], *cells]
    return "\n\n".join(
        "\n".join(line(parts, columns) for parts in lines)
        for columns in _pieces(widths, right, apart)
    )


def _pieces(widths: Sequence[int], right: Sequence[bool], apart: int | None) -> list[list[int]]:
    """Columns in groups that are no wider than a terminal, each with the first column."""
    if sum(widths) + 2 * (len(widths) - 1) <= WIDTH:
        return [list(range(len(widths)))]
    pieces = [[0]]
    for k in range(1, len(widths)):
        full = sum(widths[c] + 2 for c in pieces[-1]) + widths[k] > WIDTH
        if len(pieces[-1]) > 1 and (full or k == apart):
            pieces.append([0])
        pieces[-1].append(k)
    for before, piece in pairwise(pieces):
        lone = len(piece) == 2 and not right[piece[1]] and len(before) > 2  # a unit, or a name
        if lone and sum(widths[c] + 2 for c in (*piece, before[-1])) <= WIDTH + 2:
            piece.insert(1, before.pop())
    return pieces


def constant_axes(positions: Sequence[Array]) -> dict[str, float]:
    """Of two positions or more: coordinates that are alike in all of them [m], as that across a planar mechanism."""
    if len(positions) < 2:
        return {}
    low, high = np.min(positions, axis=0), np.max(positions, axis=0)
    alike = {axis: float(low[k]) for k, axis in enumerate("xyz") if high[k] - low[k] < ALIKE}
    return {axis: value if abs(value) > ALIKE else 0.0 for axis, value in alike.items()}
