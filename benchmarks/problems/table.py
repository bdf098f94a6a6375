"""The tables of problems in Markdown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from benchmarks.table import ratio_text, time_text

from .catalogue import Problem
from .sides import OURS, SIMULATE
from .turns import Result

TITLES = {
    OURS: "ours, C export",
    SIMULATE: "ours, `simulate`",
    "exudyn": "Exudyn",
    "mujoco": "MuJoCo",
    "pinocchio": "Pinocchio",
    "drake": "Drake",
}
Rows = Mapping[str, Sequence[Result]]  # by name of the problem


def times(problems: Sequence[Problem], rows: Rows, sides: Sequence[str]) -> list[str]:
    """One line a problem: CPU time to the accuracy asked, and how many times that of ours in C."""
    head = ["problem", *(TITLES[side] for side in sides)]
    table = [_line(head), _line(["---", *["---:"] * len(sides)])]
    for problem in problems:
        results = {result.side: result for result in rows[problem.name]}
        ours = results.get(OURS)
        cells = [_cell(results[side], ours) for side in sides]
        table.append(_line([problem.title, *cells]))
    return table


def _cell(result: Result, ours: Result | None) -> str:
    """A time and its ratio to ours; what was reached where that is not enough."""
    best = result.best
    if math.isnan(best.seconds):
        return result.trouble or "no end"
    time = time_text(best.seconds)
    if not result.is_reached:
        return f"not reached: {best.error:.0e} in {time}"
    if ours is None or result.side == OURS:
        return f"**{time}**"
    return f"{time} ({ratio_text(best.seconds / ours.best.seconds)})"


def accuracies(problems: Sequence[Problem], rows: Rows) -> list[str]:
    """One line a problem: what this library reaches within those times."""
    head = ["problem", "reference", "error asked"]
    head += ["C export: error", "drift [J]", "`simulate`: error", "drift [J]", "simulated"]
    table = [_line(head), _line(["---", "---", *["---:"] * 6])]
    for problem in problems:
        cells = [problem.title, problem.source, f"{problem.asked:.0e}"]
        results = {result.side: result for result in rows[problem.name]}
        for side in (OURS, SIMULATE):
            best = results[side].best
            cells += [_number(best.error), _number(best.drift)]
        table.append(_line([*cells, f"{problem.end:g} s"]))
    return table


def _number(value: float) -> str:
    if math.isfinite(value):
        return f"{value:.1e}"
    return "-"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
