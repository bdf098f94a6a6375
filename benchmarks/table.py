"""The tables in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .measure import Timing
from .side import WORKS

OURS = "hybrid_dynamics"
# what the README shows: the floor, this library, its nearest peer
SHORT = ("C by hand, extension module", OURS, "Pinocchio, closure by hand")


def time_text(seconds: float) -> str:
    """Three digits and a unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def ratio_text(ratio: float) -> str:
    """Two digits, or an integer from ten on."""
    if ratio < 10.0:
        return f"{ratio:.2g}"
    return f"{ratio:.0f}"


def comparison(times: Mapping[str, Mapping[str, Timing]]) -> list[str]:
    """One row a side and work, fastest first; ratios to this library."""
    lines = ["| work | engine | time | in times of ours |", "|---|---|---:|---:|"]
    for work, rows in times.items():
        ours = rows.get(OURS)
        for name, timing in _fastest_first(rows):
            ratio = ""
            if ours is not None:
                ratio = ratio_text(timing.median / ours.median)
            time = time_text(timing.median)
            lines.append(f"| {WORKS[work]} | {_marked(name)} | {time} | {ratio} |")
    return lines


def _fastest_first(rows: Mapping[str, Timing]) -> list[tuple[str, Timing]]:
    return sorted(rows.items(), key=lambda item: item[1].median)


def _marked(name: str) -> str:
    """A side's name, that of this library in bold."""
    if name == OURS:
        return f"**{name}**"
    return name


def short(times: Mapping[str, Mapping[str, Timing]]) -> list[str]:
    """One row for each engine of `SHORT`: a call of inverse dynamics, and a state of a batch."""
    single = times.get("id", {})
    batch = times.get("id_batch", {})
    lines = [
        "| inverse dynamics of the forging robot | one call from Python | per state in a batch |",
        "|---|---:|---:|",
    ]
    for name, timing in _fastest_first(single):
        if name not in SHORT:
            continue
        batch_time = ""
        if name in batch:
            batch_time = time_text(batch[name].median)
        lines.append(f"| {_marked(name)} | {time_text(timing.median)} | {batch_time} |")
    return lines


def scaling(rows: Sequence[tuple[int, float, float, float, float]]) -> list[str]:
    """One row a chain."""
    columns = "compiled in | inverse dynamics | forward dynamics | per state in a batch"
    lines = [f"| four-bar stages | links | {columns} |", "|---:|---:|---:|---:|---:|---:|"]
    for count, *seconds in rows:
        lines.append(f"| {count} | {3 * count} | {' | '.join(map(time_text, seconds))} |")
    return lines
