"""The plot of times: one line a problem, one mark an engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt

from hybrid_dynamics_core.drawing.style import BLUE, GREEN, ORANGE, PURPLE, RED, STYLE

from .catalogue import Problem
from .sides import OURS, SIMULATE
from .table import TITLES, Rows

MARKS = {
    OURS: (BLUE, "D"),
    SIMULATE: (BLUE, "o"),
    "exudyn": (ORANGE, "s"),
    "mujoco": (GREEN, "^"),
    "pinocchio": (RED, "v"),
    "drake": (PURPLE, "P"),
}


def save(problems: Sequence[Problem], rows: Rows, sides: Sequence[str], path: Path) -> None:
    """CPU time to the accuracy asked; hollow marks do not reach it.

    Args:
        problems: from the top down.
        rows: results.
        sides: that are drawn.
        path: of the picture.
    """
    with plt.rc_context({**STYLE, "svg.hashsalt": "known problems"}):
        figure, axes = plt.subplots(figsize=(7.6, 4.6), layout="constrained")
        for side in sides:
            colour, marker = MARKS[side]
            label = TITLES[side].replace("`", "")
            axes.plot([], [], linestyle="none", color=colour, marker=marker, label=label)
        for place, problem in enumerate(problems):
            for result in rows[problem.name]:
                if math.isnan(result.best.seconds):
                    continue
                colour, marker = MARKS[result.side]
                face = colour if result.is_reached else "white"
                axes.plot(
                    result.best.seconds,
                    place,
                    linestyle="none",
                    marker=marker,
                    color=colour,
                    markerfacecolor=face,
                    zorder=3 if colour == BLUE else 2,
                )
        axes.set_xscale("log")
        axes.set_yticks(range(len(problems)), [problem.title for problem in problems])
        axes.invert_yaxis()
        axes.grid(axis="y", alpha=0.4)
        axes.set_xlabel("CPU time of the run [s]; hollow: the accuracy asked is not reached")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
