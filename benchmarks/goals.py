"""Goals of the project, as ratios of times measured in one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .measure import Timing

OURS = "hybrid_dynamics"
PLAIN = "hybrid_dynamics, no compiler"
FLOOR = "C by hand, extension module"
C_EXPORT = "C export, extension module"
BY_HAND = "Pinocchio, closure by hand"
NEWTON = "Pinocchio, Newton closure"
CONSTRAINED = "Pinocchio, constraintDynamics"


@dataclass(frozen=True)
class Goal:
    """A goal for one computation on one side, against the fastest of other sides.

    Attributes:
        work: key of WORKS.
        text: description of the comparison in the table.
        others: names of the other sides.
        faster: the least speed-up over the fastest other side; 0 if `slower` is given.
        slower: the largest slow-down against it; 0 if `faster` is given.
        side: name of the side that is compared.
    """

    work: str
    text: str
    others: tuple[str, ...]
    faster: float = 0.0
    slower: float = 0.0
    side: str = OURS

    def measured(self, times: Mapping[str, Mapping[str, Timing]]) -> float | None:
        """The speed-up if the goal is one, else the slow-down; None if a side is missing."""
        rows = times.get(self.work, {})
        others = [rows[name].median for name in self.others if name in rows]
        if self.side not in rows or not others:
            return None
        ratio = min(others) / rows[self.side].median
        if self.faster:
            return ratio
        return 1.0 / ratio

    def reached(self, value: float) -> bool:
        """Whether a measured ratio is good enough."""
        if self.faster:
            return value >= self.faster
        return value <= self.slower

    def wanted(self) -> str:
        """The goal in words."""
        if self.faster:
            return f"at least {self.in_words(self.faster)}"
        return f"at most {self.in_words(self.slower)}"

    def in_words(self, ratio: float) -> str:
        """A ratio with its direction: `22.1 times faster`."""
        if self.faster:
            return f"{ratio:.3g} times faster"
        return f"{ratio:.3g} times slower"


GOALS = (
    Goal("id", "inverse dynamics, new array: Pinocchio, closure by hand", (BY_HAND,), faster=8.0),
    Goal("id", "inverse dynamics, new array: Pinocchio, Newton closure", (NEWTON,), faster=500.0),
    Goal("id", "inverse dynamics, new array: C by hand", (FLOOR,), slower=2.0),
    Goal("id_out", "inverse dynamics, `out=`: C by hand", (FLOOR,), slower=1.5),
    Goal("id_out", "exported C: this library", (OURS,), slower=1.3, side=C_EXPORT),
    Goal("id_out", "exported C: C by hand", (FLOOR,), slower=2.0, side=C_EXPORT),
    Goal("minimal", "M-bar, C-bar u', G-bar: Pinocchio", (BY_HAND,), faster=10.0),
    Goal("fd", "forward dynamics: the fastest of Pinocchio", (BY_HAND, CONSTRAINED), faster=5.0),
    Goal("close", "closure with rates: Pinocchio, Newton closure", (NEWTON,), faster=300.0),
    Goal("id_batch", "inverse dynamics, batch: loop over Pinocchio", (BY_HAND,), faster=140.0),
    Goal("id_batch", "inverse dynamics, batch: C by hand", (FLOOR,), slower=1.4),
    Goal(
        "id",
        "without compiler, inverse dynamics: plain NumPy",
        ("plain NumPy, closure by hand",),
        6.0,
        side=PLAIN,
    ),
)


def table(times: Mapping[str, Mapping[str, Timing]], goals: Sequence[Goal] = GOALS) -> list[str]:
    """One row for each goal whose sides are installed."""
    lines = ["| this library against | goal | measured | |", "|---|---|---|---|"]
    for goal in goals:
        value = goal.measured(times)
        if value is None:
            continue
        verdict = "not reached"
        if goal.reached(value):
            verdict = "reached"
        lines.append(f"| {goal.text} | {goal.wanted()} | {goal.in_words(value)} | {verdict} |")
    return lines
