"""The figure: four efforts and the path of the end effector, as Figures 10 and 8 of the paper."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.scene.style import BLUE, GREEN, ORANGE, PANES, PURPLE, QUIET, RED, STYLE

from .path_plot import draw_path
from .results import Results

# Joint, symbol of the paper, unit, what it drives, colour.
_EFFORTS: Final = (
    ("q1", r"$\tau_1$", "N m", "column", BLUE),
    ("q12", r"$F_{12}$", "N", "cylinder 1", RED),
    ("q22", r"$F_{22}$", "N", "cylinder 2", GREEN),
    ("q4", r"$\tau_4$", "N m", "gripper roll", ORANGE),
)
_NOTHING: Final = 1e-9  # [N m or N], smaller efforts are rounding


def save_figure(results: Results, robot: Robot, stem: Path, subtitle: str) -> tuple[Path, Path]:
    """Draw the figure and write ``stem``.png and ``stem``.svg; their paths.

    Args:
        results: what was received from the node.
        robot: the robot, for its configuration.
        stem: path without suffix.
        subtitle: where the motion and the numbers come from.
    """
    with mpl.rc_context({**STYLE, **PANES}):
        figure = draw(results, robot, subtitle)
        png, svg = stem.with_suffix(".png"), stem.with_suffix(".svg")
        _save(figure, png, dpi=110, pil_kwargs={"optimize": True})
        _save(figure, svg, metadata={"Date": None})
    return png, svg


def draw(results: Results, robot: Robot, subtitle: str) -> Figure:
    """The figure, not yet written."""
    figure = Figure(figsize=(13.0, 7.0))
    left = figure.add_gridspec(
        2, 2, left=0.07, right=0.59, bottom=0.085, top=0.845, wspace=0.36, hspace=0.38
    )
    time = (results.efforts.stamp_ns - results.start_ns) * 1e-9
    for k, (joint, symbol, unit, part, colour) in enumerate(_EFFORTS):
        axes = figure.add_subplot(left[k // 2, k % 2])
        _draw_effort(
            axes, time, results.efforts.effort[:, results.efforts.names.index(joint)], colour
        )
        axes.set_title(f"{symbol}   {part}")
        axes.set_ylabel(f"{symbol} [{unit}]")
    draw_path(figure.add_axes((0.615, 0.355, 0.39, 0.55), projection="3d"), results, robot)
    _draw_position(figure.add_axes((0.665, 0.085, 0.305, 0.225)), results)
    figure.text(0.665, 0.8585, "Path of the end effector", fontsize=10.5)
    figure.text(
        0.02,
        0.95,
        "Forging robot: required efforts and end-effector path",
        fontsize=15,
        weight="bold",
    )
    figure.text(0.02, 0.913, subtitle, fontsize=9.5, color=QUIET)
    return figure


def _draw_effort(axes: Axes, time: NDArray[Any], values: NDArray[Any], colour: str) -> None:
    axes.plot(time, values, color=colour)
    axes.set_xlim(0.0, max(time[-1], 1e-3))
    axes.set_xlabel("time [s]")
    axes.yaxis.set_major_locator(MaxNLocator(6))
    if np.abs(values).max() < _NOTHING:
        axes.set_ylim(-1.0, 1.0)
        note = "zero: the gripper is symmetric about its\nroll axis and turns at a constant rate"
        box = {"facecolor": "white", "edgecolor": "none", "pad": 3.0}
        axes.text(
            0.5,
            0.64,
            note,
            transform=axes.transAxes,
            ha="center",
            va="center",
            fontsize=8.5,
            bbox=box,
        )


def _draw_position(axes: Axes, results: Results) -> None:
    time = (results.pose.stamp_ns - results.start_ns) * 1e-9
    for name, column, style in zip("xyz", results.pose.position.T, ("-", "--", "-."), strict=True):
        axes.plot(time, column, style, color=PURPLE)
        end = (float(time[-1]), float(column[-1]))
        axes.annotate(
            name, end, xytext=(5, 0), textcoords="offset points", color=PURPLE, va="center"
        )
    axes.set_xlim(0.0, max(time[-1], 1e-3))
    axes.set_title("End effector over time")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("position [m]")


def _save(figure: Figure, path: Path, **options: Any) -> None:
    """Write aside, then rename: an interrupted run leaves no half figure."""
    aside = path.with_name(f".{os.getpid()}.{path.name}")
    try:
        figure.savefig(aside, **options)
        aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)
