"""Pages for plots in the style of all figures: title, subtitle, axes, and a caption."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler
from matplotlib.ticker import ScalarFormatter

from ..scene.style import LOOPS, QUIET, STYLE
from .figure import save

CURVES: Final = LOOPS  # without RED, which marks driven joints and exceeded limits
PLOTS: Final[dict[Any, Any]] = {
    **STYLE,
    "axes.prop_cycle": cycler(color=CURVES),
    "legend.frameon": False,
}
_LINE: Final = 0.16  # [in] height of a line of the caption
_LETTERS: Final = 16.5  # characters of a caption per inch
_LEFT: Final = 0.015  # left edge of texts, as a share of the figure's width
_ROW: Final = 13.0  # [pt] height of a row of a legend
_GAP: Final = 6.0  # [pt] between axes, legend and title
_THOUSANDS: Final = re.compile(r"(?<=\d)(?=(\d{3})+$)")


class InFull(ScalarFormatter):
    """Tick labels without a common power of ten, which would overlap a legend above the axes."""

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(False)

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The label of a tick, with commas between thousands."""
        digits, point, decimals = super().__call__(x, pos).partition(".")
        return _THOUSANDS.sub(",", digits) + point + decimals


def page(
    title: str,
    caption: str = "",
    *,
    line: str = "",
    width: float = 7.2,
    height: float = 4.0,
) -> Figure:
    """A figure with a title above its axes and a caption below them.

    Create, fill and save it within `mpl.rc_context(PLOTS)`.

    Args:
        title: title of the figure.
        caption: text below the axes.
        line: subtitle.
        width: width of the axes with their names [in].
        height: height of the axes with their names [in].

    Returns:
        The figure, without axes.
    """
    text = fill(" ".join(caption.split()), round(width * _LETTERS))
    foot = _LINE * (1 + text.count("\n")) + 0.14 if text else 0.0
    head = 0.6 if line else 0.4
    total = height + foot + head
    figure = Figure(figsize=(width, total), layout="constrained")
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.008, foot / total, 0.98, (height - 0.04) / total))
    figure.text(
        _LEFT,
        1.0 - 0.22 / total,
        title,
        fontsize=12,
        weight="bold",
        va="center",
    )
    if line:
        figure.text(
            _LEFT,
            1.0 - 0.44 / total,
            line,
            fontsize=9,
            color=QUIET,
            va="center",
        )
    if text:
        top = foot / total - 0.03 / total
        figure.text(
            _LEFT,
            top,
            text,
            fontsize=8,
            color=QUIET,
            va="top",
            linespacing=1.35,
        )
    return figure


@contextmanager
def written_page(
    path: str | Path,
    title: str,
    line: str,
    height: float,
) -> Iterator[Figure]:
    """A context manager for a page that is written to a file at the end.

    Args:
        path: path of the file, .svg, .png or .pdf.
        title: title of the figure.
        line: subtitle.
        height: height of the axes with their names [in].

    Yields:
        The figure.

    Raises:
        InputError: for other suffixes.
    """
    with mpl.rc_context(PLOTS):
        figure = page(title, line=line, height=height)
        yield figure
        save(figure, Path(path))


def entitled(axes: Axes, title: str, columns: int = 0) -> None:
    """Write a title above axes, and a legend between title and axes.

    Tick labels next to a legend have no common power of ten.

    Args:
        axes: axes with labelled curves.
        title: title of the axes.
        columns: number of columns of the legend; 0: no legend.
    """
    if not columns:
        axes.set_title(title)
        return
    if isinstance(axes.yaxis.get_major_formatter(), ScalarFormatter):  # plain numbers
        axes.yaxis.set_major_formatter(InFull())
    handles, labels = axes.get_legend_handles_labels()
    rows = -(-len(labels) // columns)
    axes.legend(
        handles,
        labels,
        ncols=columns,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        fontsize=8,
        borderaxespad=0.3,
        borderpad=0.0,
        handlelength=1.6,
        columnspacing=1.4,
    )
    axes.set_title(title, pad=rows * _ROW + _GAP)
