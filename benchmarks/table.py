"""The tables in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .measure import Timing
from .side import WORKS

OURS = "hybrid_dynamics"


def time_text(seconds: float) -> str:
    """Three digits and a unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def ratio_text(ratio: float) -> str:
    """Two digits, or whole from ten on."""
    return f"{ratio:.2g}" if ratio < 10.0 else f"{ratio:.0f}"


def comparison(times: Mapping[str, Mapping[str, Timing]]) -> list[str]:
    """One row a side and work, fastest first; ratios to this library."""
    lines = ["| work | engine | time | in times of ours |", "|---|---|---:|---:|"]
    for work, rows in times.items():
        ours = rows.get(OURS)
        for name, timing in sorted(rows.items(), key=lambda item: item[1].median):
            ratio = "" if ours is None else ratio_text(timing.median / ours.median)
            shown = f"**{name}**" if name == OURS else name
            lines.append(f"| {WORKS[work]} | {shown} | {time_text(timing.median)} | {ratio} |")
    return lines


def short(times: Mapping[str, Mapping[str, Timing]]) -> list[str]:
    """One row an engine: one call of inverse dynamics, and a state of a batch."""
    one, batch = times.get("id", {}), times.get("id_batch", {})
    lines = [
        "| inverse dynamics of the forging robot | one call from Python | batch, a state |",
        "|---|---:|---:|",
    ]
    for name, timing in sorted(one.items(), key=lambda item: item[1].median):
        shown = f"**{name}**" if name == OURS else name
        many = time_text(batch[name].median) if name in batch else ""
        lines.append(f"| {shown} | {time_text(timing.median)} | {many} |")
    return lines


def scaling(rows: Sequence[tuple[int, float, float, float, float]]) -> list[str]:
    """One row a chain."""
    lines = [
        (
            "| four-bar stages | links | compiled in | inverse dynamics | forward dynamics | batch,"
            " a state |"
        ),
        "|---:|---:|---:|---:|---:|---:|",
    ]
    for count, *seconds in rows:
        lines.append(f"| {count} | {3 * count} | {' | '.join(map(time_text, seconds))} |")
    return lines
