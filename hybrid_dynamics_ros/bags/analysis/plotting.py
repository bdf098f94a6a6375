"""Panels and lines of a report's figures, and conversion to SVG."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hybrid_dynamics_core.drawing.plots.legend_text import legend_text
from hybrid_dynamics_core.drawing.plots.rounding import Sizes, sizes_of
from hybrid_dynamics_core.scene.style import LOOPS, STYLE

from ...messages.joint_samples import FloatArray
from .recording import EvaluatedRecording

LEGEND_ABOVE: Final[dict[str, Any]] = {
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 0.97),
    "fontsize": 8,
    "frameon": False,
}
_WIDTH: Final = 10.5  # [inch]
_TITLE_HEIGHT: Final = 0.5  # [inch]
_GRID: Final = "#e6e6e6"
_THOUSANDS: Final = "{x:,.10g}"
_MAX_POINTS: Final = 2500  # per line: more are not visible, and would enlarge the page
_SVG_OPTIONS: Final[dict[Any, Any]] = {"svg.fonttype": "path", "path.simplify_threshold": 0.3}
_BEYOND: Final[dict[str, Any]] = {
    "color": "black",
    "markersize": 5,
    "clip_on": False,
    "zorder": 5,
}
_NOTE_PLACE: Final = (0.995, 0.97)
_BOX: Final = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.0}
_NOTE: Final[dict[str, Any]] = {
    "ha": "right",
    "va": "top",
    "fontsize": 8,
    "bbox": _BOX,
    "zorder": 6,
}
_MIDDLE: Final = (1.0, 99.0)  # [%] quantiles; an axis reaches beyond them by the range between them
_BELOW: Final = 6  # Matplotlib's marker at the lower edge
_ABOVE: Final = 7

Draw = Callable[[EvaluatedRecording], Figure]


def colour_of(number: int) -> str:
    """The colour of a joint or a loop, as in the drawings."""
    return LOOPS[number % len(LOOPS)]


def natural_sizes(recording: EvaluatedRecording) -> Sizes:
    """Natural sizes of the quantities of the motion."""
    return sizes_of(recording.robot, float(np.ptp(recording.time)))


def make_panels(rows: int, columns: int, height: float) -> tuple[Figure, list[list[Axes]]]:
    """A figure of panels over time.

    Args:
        rows: rows of panels.
        columns: columns of panels.
        height: height of a row [inch].
    """
    size = (_WIDTH, _TITLE_HEIGHT + height * rows)
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=False)
    for ax in axes.flat:
        ax.grid(visible=True, color=_GRID, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        ax.yaxis.set_major_formatter(_THOUSANDS)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    for ax in axes[:-1].flat:
        ax.tick_params(labelbottom=False)
    return figure, [list(row) for row in axes]


def draw_line(
    ax: Axes,
    recording: EvaluatedRecording,
    values: FloatArray,
    colour: str,
    label: str = "",
    linewidth: float = 0.9,
) -> None:
    """Draw values (N,) over time, broken at gaps."""
    time, values = _thin_out(recording.time, values)
    gap_ends = [end for _, end in recording.gaps]
    breaks = np.searchsorted(time, gap_ends)
    time = np.insert(time, breaks, np.nan)
    values = np.insert(values.astype(np.float64), breaks, np.nan)
    ax.plot(time, values, color=colour, linewidth=linewidth, label=legend_text(label))
    ax.margins(x=0.01)


def clip_outliers(ax: Axes, recording: EvaluatedRecording, *parts: FloatArray) -> None:
    """Limit the axis so that a few outliers do not flatten the curve; mark and count them.

    The axis covers the middle 98 % of values, and its range again on both sides. That includes
    seven standard deviations of Gaussian noise.

    Args:
        ax: the axes.
        recording: the recording.
        parts: lines on the axes (N,).
    """
    values = np.concatenate([part[np.isfinite(part)] for part in parts])
    if not len(values):
        return
    low, high = np.percentile(values, _MIDDLE)
    low, high = low - (high - low), high + (high - low)
    lowest, highest = float(values.min()), float(values.max())
    if not low < high or (low <= lowest and highest <= high):
        return
    bottom, top = widen(max(low, lowest), min(high, highest))
    ax.set_ylim(bottom, top)
    beyond: list[float] = []
    for part in parts:
        is_below = part < low
        is_above = part > high
        _mark(ax, recording.time[is_below], bottom, _BELOW)
        _mark(ax, recording.time[is_above], top, _ABOVE)
        beyond += part[is_below].tolist()
        beyond += part[is_above].tolist()
    text = f"{len(beyond)} beyond, to {max(beyond, key=abs):.4g}"
    note = ax.annotate(text, _NOTE_PLACE, xycoords="axes fraction", **_NOTE)
    note.set_in_layout(False)


def _mark(ax: Axes, times: FloatArray, height: float, marker: int) -> None:
    """Mark times (k,) at an edge of the axes."""
    heights = np.full(len(times), height)
    (marks,) = ax.plot(times, heights, linestyle="", marker=marker, **_BEYOND)
    marks.set_in_layout(False)


def widen(low: float, high: float) -> tuple[float, float]:
    """A range with a margin, so that marks at its ends are visible."""
    room = max(0.02 * (high - low), 1e-3)
    return low - room, high + room


def _thin_out(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The least and the largest value of each stretch, which keeps peaks."""
    size = -(-len(time) // (_MAX_POINTS // 2))
    if size <= 2:
        return time, values
    count = len(time) // size * size
    table = values[:count].reshape(-1, size)
    filled = np.where(np.isfinite(table), table, table[:, :1])
    lowest = filled.argmin(axis=1)
    highest = filled.argmax(axis=1)
    ends = np.stack([np.minimum(lowest, highest), np.maximum(lowest, highest)], axis=1)
    starts = size * np.arange(len(ends))
    rows = (ends + starts[:, None]).ravel()
    return time[rows], values[rows]


def svg_of(draw: Draw, recording: EvaluatedRecording, name: str) -> str:
    """A figure as SVG text for a page.

    Args:
        draw: draws the figure.
        recording: the recording.
        name: prefix of ids, unique on the page.
    """
    with mpl.rc_context({**STYLE, **_SVG_OPTIONS, "svg.hashsalt": name}):
        text = rendered(draw(recording))
    text = text[text.index("<svg") :]
    text = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{name}_", text)
    text = re.sub(r' height="[^"]*pt"', "", text, count=1)
    return re.sub(r'<svg ([^>]*?)width="[^"]*" ', r"<svg \1", text, count=1)


def rendered(figure: Figure) -> str:
    """A figure as an SVG document."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()
