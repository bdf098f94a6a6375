"""The plot of error against time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt

from hybrid_dynamics_core.drawing.style import BLUE, GREEN, ORANGE, PURPLE, RED, STYLE

from .catalogue import HIGH
from .table import Row

COLOURS = (BLUE, ORANGE, GREEN, RED, PURPLE)
MARKERS = ("o", "s", "^")


def save(rows: Sequence[Row], path: Path) -> None:
    """Error against time of every problem that has a reference.

    Args:
        rows: of the table.
        path: of the picture.
    """
    with plt.rc_context({**STYLE, "svg.hashsalt": "known problems"}):
        figure, axes = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
        drawn = [row for row in rows if row.problem.reference is not None]
        for k, row in enumerate(drawn):
            seconds = [answer.seconds for answer in row.answers]
            errors = [answer.reached for answer in row.answers]
            colour = COLOURS[k % len(COLOURS)]
            marker = MARKERS[k // len(COLOURS)]
            axes.loglog(seconds, errors, color=colour, marker=marker, label=row.problem.title)
        axes.axhline(HIGH, color="black", linestyle="dotted")
        axes.set_xlabel("time of the run [s]")
        axes.set_ylabel("largest relative error")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
