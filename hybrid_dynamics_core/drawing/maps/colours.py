"""Common parts of maps: colours, colour bar, title and subtitle."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ...ground.arrays import Array
from ...scene.style import QUIET
from ..paint.layout import axes_at

COLOURS: Final = mpl.colormaps["YlOrRd_r"]
LEVELS: Final = np.linspace(0.0, 1.0, 81)  # so many that no steps are visible
WORDS: Final = {
    "singularity": "distance to the nearest singularity of a loop (0 singular, 1 best)",
    "limits": "distance to the nearest limit of a joint (0 there, 1 mid-range)",
}
SIDES: Final = (0.76, 0.16)  # [in] left and right of a panel's axes
_EDGE: Final = 0.16  # [in] left of the text
_LOWEST: Final = 1e-6  # a map with a smaller largest value is zero up to rounding
_SHORT: Final = 5.2  # [in] least width of the colour bar, which is that of its text


def head(figure: Figure, title: str, line: str) -> None:
    """Write a title, and a subtitle below it."""
    width, height = figure.get_size_inches()
    left = _EDGE / width
    figure.text(
        left,
        1.0 - 0.24 / height,
        title,
        fontsize=13,
        weight="bold",
        va="center",
    )
    figure.text(
        left,
        1.0 - 0.38 / height,
        line,
        fontsize=8.5,
        color=QUIET,
        va="top",
    )


def top_of(values: Iterable[Array]) -> float:
    """Upper end of the colour scale: the largest value, rounded up, at most 1."""
    largest = 0.0
    for each in values:
        finite = each[np.isfinite(each)]
        largest = max(largest, float(finite.max(initial=0.0)))
    if largest <= _LOWEST:
        return 1.0
    step = 0.5 * 10.0 ** np.floor(np.log10(largest))
    steps = np.ceil(largest / step - 1e-9)
    return min(float(step * steps), 1.0)


def colour_bar(
    figure: Figure,
    text: str,
    top: float,
    right: float,
) -> None:
    """Draw a colour bar at the bottom of a figure.

    Args:
        figure: the figure with maps.
        text: name of the quantity.
        top: upper end of the scale; the text mentions it if it is below 1.
        right: right edge of the panels [in].
    """
    if top != 1.0:
        text = f"{text.removesuffix(')')}; colours up to {top:.3g})"
    left = SIDES[0]
    longest = float(figure.get_size_inches()[0]) - 1.0
    length = max(min(longest, _SHORT), right - left)
    axes = axes_at(figure, (left, 0.3, length, 0.12))
    colours = ScalarMappable(Normalize(0.0, top), COLOURS)
    figure.colorbar(colours, cax=axes, orientation="horizontal")
    axes.set_title(text, fontsize=8.5, pad=4)
    axes.tick_params(labelsize=8)


def shade(
    axes: Axes,
    middles: Sequence[Array],
    values: Array,
    top: float,
    order: float,
) -> None:
    """Paint values as colours.

    They are an image inside vector graphics, which keeps files small.

    Args:
        axes: to be painted on.
        middles: middles of the cells in both directions.
        values: (N, M) in [0, top].
        top: upper end of the colour scale.
        order: in which artists are painted.
    """
    areas = axes.contourf(
        *middles,
        values,
        levels=top * LEVELS,
        cmap=COLOURS,
        vmin=0.0,
        vmax=top,
        zorder=order,
    )
    areas.set_rasterized(True)
