"""The figure: four efforts and the path of the end effector, as Figures 10 and 8 of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.atomic_files import atomic_file
from hybrid_dynamics_core.scene.style import BLUE, GREEN, ORANGE, PANES, PURPLE, QUIET, RED, STYLE

from .path_plot import draw_path
from .results import Results


class _Effort(NamedTuple):
    """A panel: joint, symbol in the paper, unit, driven link, colour."""

    joint: str
    symbol: str
    unit: str
    part: str
    colour: str


_EFFORTS: Final = (
    _Effort("q1", r"$\tau_1$", "N m", "column", BLUE),
    _Effort("q12", r"$F_{12}$", "N", "cylinder 1", RED),
    _Effort("q22", r"$F_{22}$", "N", "cylinder 2", GREEN),
    _Effort("q4", r"$\tau_4$", "N m", "gripper roll", ORANGE),
)
_SIZE: Final = (13.0, 7.0)  # [inch]
_DPI: Final = 110  # of the .png
_GRID: Final = {
    "left": 0.07,
    "right": 0.59,
    "bottom": 0.085,
    "top": 0.845,
    "wspace": 0.36,
    "hspace": 0.38,
}
_PATH_PLACE: Final = (0.615, 0.355, 0.39, 0.55)
_POSITION_PLACE: Final = (0.665, 0.085, 0.305, 0.225)
_TITLE: Final = "Forging robot: required efforts and end-effector path"
_ROUNDING: Final = 1e-9  # [N m or N], smaller efforts are rounding
_ZERO_NOTE: Final = (
    "zero: the gripper is symmetric about its\nroll axis and turns at a constant rate"
)
_ZERO_STYLE: Final[dict[str, Any]] = {
    "ha": "center",
    "va": "center",
    "fontsize": 8.5,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 3.0},
}
_END_STYLE: Final[dict[str, Any]] = {
    "xytext": (5, 0),
    "textcoords": "offset points",
    "va": "center",
}
_MIN_DURATION: Final = 1e-3  # [s] of a time axis


def save_figure(results: Results, robot: Robot, stem: Path, subtitle: str) -> tuple[Path, Path]:
    """Draw the figure and write it as .png and .svg.

    Args:
        results: the received messages.
        robot: the robot, for its configuration.
        stem: path without suffix.
        subtitle: sources of the motion and the numbers.

    Returns:
        The paths of both files.
    """
    png, svg = stem.with_suffix(".png"), stem.with_suffix(".svg")
    with mpl.rc_context({**STYLE, **PANES}):
        figure = draw(results, robot, subtitle)
        _save(figure, png, dpi=_DPI, pil_kwargs={"optimize": True})
        _save(figure, svg, metadata={"Date": None})
    return png, svg


def draw(results: Results, robot: Robot, subtitle: str) -> Figure:
    """Make the figure without writing it; arguments are those of `save_figure`."""
    figure = Figure(figsize=_SIZE)
    grid = figure.add_gridspec(2, 2, **_GRID)
    for k, effort in enumerate(_EFFORTS):
        axes = figure.add_subplot(grid[k // 2, k % 2])
        _draw_effort(axes, results, effort)
    draw_path(figure.add_axes(_PATH_PLACE, projection="3d"), results, robot)
    _draw_position(figure.add_axes(_POSITION_PLACE), results)
    figure.text(0.665, 0.8585, "Path of the end effector", fontsize=10.5)
    figure.text(0.02, 0.95, _TITLE, fontsize=15, weight="bold")
    figure.text(0.02, 0.913, subtitle, fontsize=9.5, color=QUIET)
    return figure


def _draw_effort(axes: Axes, results: Results, effort: _Effort) -> None:
    """An effort over time."""
    series = results.efforts
    time = (series.stamp_ns - results.start_ns) * 1e-9
    values = series.effort[:, series.names.index(effort.joint)]
    axes.plot(time, values, color=effort.colour)
    _label_time(axes, time)
    axes.yaxis.set_major_locator(MaxNLocator(6))
    if np.abs(values).max() < _ROUNDING:
        axes.set_ylim(-1.0, 1.0)
        axes.text(0.5, 0.64, _ZERO_NOTE, transform=axes.transAxes, **_ZERO_STYLE)
    axes.set_title(f"{effort.symbol}   {effort.part}")
    axes.set_ylabel(f"{effort.symbol} [{effort.unit}]")


def _draw_position(axes: Axes, results: Results) -> None:
    """The position of the end effector over time."""
    time = (results.pose.stamp_ns - results.start_ns) * 1e-9
    for name, column, style in zip("xyz", results.pose.position.T, ("-", "--", "-."), strict=True):
        axes.plot(time, column, style, color=PURPLE)
        end = (float(time[-1]), float(column[-1]))
        axes.annotate(name, end, color=PURPLE, **_END_STYLE)
    _label_time(axes, time)
    axes.set_title("End effector over time")
    axes.set_ylabel("position [m]")


def _label_time(axes: Axes, time: NDArray[Any]) -> None:
    """Set a time axis from 0 to the last of some times (N,) [s]."""
    axes.set_xlim(0.0, max(time[-1], _MIN_DURATION))
    axes.set_xlabel("time [s]")


def _save(figure: Figure, path: Path, **options: Any) -> None:
    with atomic_file(path) as new:
        figure.savefig(new, **options)
