"""Results as tables for people, or as JSON for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any

import click
import numpy as np

from .exits import MISUSED

AS_JSON = f"{__package__}.as_json"  # in the meta of click's contexts: whether JSON is asked for,
ANSWERED = f"{__package__}.answered"  # and whether it is printed: stdout holds one document
ROUNDING = 1e-12  # below it a value of order one is noise


def show(told: Mapping[str, Any], as_json: bool, text: str) -> None:
    """Print one of the two forms of a result."""
    if not as_json:
        click.echo(text.rstrip())
        return
    click.echo(json.dumps(plain(told), indent=2, allow_nan=False))
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta[ANSWERED] = True


def fail(context: click.Context, error: click.ClickException) -> None:
    """Print an error as JSON, unless an answer is printed already; its kind is the class of what caused it."""
    usage = isinstance(error, click.UsageError) or (error.exit_code == MISUSED and error.__cause__ is None)
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


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Columns under a head: numbers to the right, text to the left; what is only rounding is shown as zero."""
    cells = [[number(v if abs(v) > ROUNDING else 0.0) if isinstance(v, float) else str(v) for v in row] for row in rows]
    right = [bool(rows) and isinstance(rows[0][k], (float, int)) for k in range(len(head))]
    widths = [max(len(line[k]) for line in [list(head), *cells]) for k in range(len(head))]

    def line(parts: Sequence[str]) -> str:
        padded = [p.rjust(w) if r else p.ljust(w) for p, w, r in zip(parts, widths, right, strict=True)]
        return "  ".join(padded).rstrip()

    return "\n".join([line(head), line(["-" * width for width in widths]), *map(line, cells)])


def effort_unit(joint_type: str) -> str:
    """Unit of the effort along a coordinate."""
    return "N m" if joint_type == "revolute" else "N"
