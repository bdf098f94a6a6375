"""The table of problems in Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.table import time_text

from .catalogue import Problem
from .solve import Answer

HEAD = [
    "| problem | reference | error asked | reached | energy drift [J] | time | simulated |",
    "|---|---|---:|---:|---:|---:|---:|",
]
USUAL = 1e-9  # relative tolerance of `simulate`


@dataclass(frozen=True)
class Row:
    """A problem and its answers, one for each tolerance that it was solved with."""

    problem: Problem
    answers: Sequence[Answer]

    def cheapest(self) -> Answer:
        """The loosest tolerance that reaches what is asked; 1e-9 without a reference.

        Raises:
            ValueError: none does.
        """
        for answer in self.answers:
            if answer.reached <= self.problem.asked:
                return answer
            if self.problem.reference is None and answer.setting == USUAL:
                return answer
        raise ValueError(f"{self.problem.title}: the accuracy asked is not reached")


def lines(rows: Sequence[Row]) -> list[str]:
    """One line a problem."""
    table = list(HEAD)
    for row in rows:
        problem = row.problem
        answer = row.cheapest()
        asked, reached = f"{problem.asked:.0e}", f"{answer.reached:.1e}"
        if math.isnan(answer.reached):
            asked = reached = "-"
        cells = [problem.title, problem.source, asked, reached, f"{answer.drift:.1e}"]
        cells += [time_text(answer.seconds), f"{problem.end:g} s"]
        table.append(f"| {' | '.join(cells)} |")
    return table
