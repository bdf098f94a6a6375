"""A workspace as a map: where the end effector can be, coloured by how near to a singularity or a limit it is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from textwrap import fill
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from scipy.ndimage import binary_closing, distance_transform_edt, gaussian_filter

from ..description.model import Array
from ..kinematics.workspace import Margins, Workspace
from ..robot import Robot
from .labels import Labeller
from .layout import axes_at
from .options import Colour
from .paint import Painter
from .planes import Plane, choose_planes
from .style import INK, QUIET, STYLE

Drawn = tuple[Array, Array, Array]  # places along both axes, values
COLOURS: Final = mpl.colormaps["YlOrRd_r"]
LEVELS: Final = np.linspace(0.0, 1.0, 21)
WORDS: Final = {
    "singularity": "distance to the nearest singularity of a loop (0 singular, 1 best)",
    "limits": "distance to the nearest limit of a joint (0 there, 1 mid-range)",
}
_BEHIND: Final = {"singularity": "least", "limits": "largest"}  # of what lies behind a point of the map
_PER_CELL: Final = 6  # samples, on average
_CELLS: Final = (40, 160)  # across the longer side of a map
_HEIGHTS: Final = {1: 4.8, 2: 4.0, 3: 3.6}  # [in] of the panels' axes, at most, by their number
_WIDTHS: Final = {1: 7.2, 2: 9.0, 3: 11.0}  # [in] of the figure, at most
_LOWEST: Final = 1e-6  # largest value of a map that is all zero but for rounding
_LEAST: Final = 6.4  # [in] of the figure
_SIDES: Final = (0.76, 0.16)  # [in] left and right of a panel's axes
_BELOW, _ABOVE, _BAR, _HEAD = 0.5, 0.3, 0.72, 0.72  # [in]


def values_of(samples: Margins, colour: Colour) -> Array:
    """(N,) what colours the samples, in [0, 1]; NaN where they are not reachable."""
    value = samples.singularity if colour == "singularity" else samples.limit
    return np.where(samples.reachable, np.clip(value, 0.0, 1.0), np.nan)


def workspace_figure(robot: Robot, workspace: Workspace, colour: Colour, title: str | None) -> Figure:
    """One panel a plane, in one scale, with the robot in its reference configuration on top."""
    with mpl.rc_context(STYLE):
        samples = workspace.samples.first(workspace.spread)
        planes = choose_planes(robot, samples)
        sizes = np.array([np.ptp(plane.box, axis=0) for plane in planes])
        room = _HEIGHTS[len(planes)], _WIDTHS[len(planes)] - len(planes) * sum(_SIDES)
        scale = min(room[0] / sizes[:, 1].max(), room[1] / sizes[:, 0].sum())
        widths, heights = sizes.T * scale
        size = float(widths.sum()) + len(planes) * sum(_SIDES), float(heights.max()) + _BELOW + _ABOVE + _BAR + _HEAD
        figure = Figure(figsize=(max(size[0], _LEAST), size[1]))
        values, single = values_of(samples, colour), len(robot.active) == 1
        drawn = [_along(plane, samples, values) if single else _binned(plane, values, colour) for plane in planes]
        top = top_of([height for *_, height in drawn])
        head(figure, title or f"{robot.name}: workspace", _told(workspace))
        left = 0.0
        for plane, place, width, height in zip(planes, drawn, widths, heights, strict=True):
            axes = axes_at(figure, (left + _SIDES[0], _BAR + _BELOW, width, height))
            _panel(axes, plane, _line if single else _paint, place, top)
            left += width + sum(_SIDES)
        colour_bar(figure, WORDS[colour] if single else f"{_BEHIND[colour]} {WORDS[colour]}", top)
    return figure


def _told(workspace: Workspace) -> str:
    if not workspace.samples.reachable.any():
        return "nothing can be reached"
    spans = (f"{name} {low:.2f} to {high:.2f}" for name, (low, high) in zip("xyz", workspace.extents, strict=True))
    chosen = f"; no limits: {', '.join(workspace.assumed)}" if workspace.assumed else ""
    return fill(f"{', '.join(spans)} m; {100 * workspace.share():.0f} % of the samples reachable{chosen}", 96)


def head(figure: Figure, title: str, line: str) -> None:
    """Title, and a line below it."""
    width, height = figure.get_size_inches()
    figure.text(0.16 / width, 1.0 - 0.24 / height, title, fontsize=13, weight="bold", va="center")
    figure.text(0.16 / width, 1.0 - 0.38 / height, line, fontsize=8.5, color=QUIET, va="top")


def top_of(values: Iterable[Array]) -> float:
    """Where the colours end: the largest value, rounded up to one digit and a half, at most 1."""
    largest = max((float(v[np.isfinite(v)].max(initial=0.0)) for v in values), default=0.0)
    if largest <= _LOWEST:
        return 1.0
    step = 0.5 * 10.0 ** np.floor(np.log10(largest))
    return min(float(step * np.ceil(largest / step - 1e-9)), 1.0)


def colour_bar(figure: Figure, text: str, top: float) -> None:
    """The key to the colours, at the bottom; it says so where they end below 1."""
    text = text if top == 1.0 else f"{text.removesuffix(')')}; colours up to {top:.3g})"
    width = float(figure.get_size_inches()[0])
    axes = axes_at(figure, (_SIDES[0], 0.3, min(width - 1.0, 5.2), 0.12))
    figure.colorbar(ScalarMappable(Normalize(0.0, top), COLOURS), cax=axes, orientation="horizontal")
    axes.set_title(text, fontsize=8.5, pad=4)
    axes.tick_params(labelsize=8)


def _panel(axes: Axes, plane: Plane, paint: Callable[..., None], drawn: Drawn, top: float) -> None:
    axes.set(xlabel=plane.names[0], ylabel=plane.names[1])
    axes.set_title(plane.title, fontsize=9)
    axes.grid(visible=False)
    if np.isfinite(drawn[-1]).any():
        paint(axes, *drawn, top)
    painter = Painter(axes, plane.scene)
    painter.paint()
    (left, bottom), (right, top) = plane.box
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    Labeller(axes, []).place(painter.letters)  # at their arrows: a map has no room for leaders


def _along(plane: Plane, samples: Margins, values: Array) -> Drawn:
    """The path of a robot with one active joint: its samples in order of that joint, with values."""
    order = np.argsort(samples.u[:, 0], kind="stable")
    return plane.points[order, 0], plane.points[order, 1], values[order]


def _line(axes: Axes, x: Array, y: Array, height: Array, top: float) -> None:
    """The path as a line in the colours of its values, with gaps where nothing is reachable."""
    points = np.stack([x, y], axis=1)
    segments, middle = np.stack([points[:-1], points[1:]], axis=1), (height[:-1] + height[1:]) / 2.0
    good = np.isfinite(middle) & np.isfinite(segments).all(axis=(1, 2))
    for width, colours in ((6.0, {"colors": INK}), (4.5, {"cmap": COLOURS, "norm": Normalize(0.0, top)})):
        line = LineCollection(list(segments[good]), linewidths=width, capstyle="round", zorder=0.6, **colours)
        if "cmap" in colours:
            line.set_array(middle[good])
        axes.add_collection(line, autolim=False)


def _binned(plane: Plane, all_values: Array, colour: Colour) -> Drawn:
    """Middles of cells, and the least (or best) value in each, NaN where no sample lies; holes of a cell are filled."""
    good = np.isfinite(all_values)
    points, values = plane.points[good], all_values[good]
    if not len(points):
        return np.zeros(0), np.zeros(0), np.zeros(0)
    low, span = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-9)
    across = np.clip(np.sqrt(len(points) / _PER_CELL * span.max() / span.min()), *_CELLS)
    cell = float(span.max() / across)
    shape = (np.ceil(span / cell).astype(int) + 5).tolist()
    index = ((points - low) / cell + 2.5).astype(int)
    sign = 1.0 if colour == "singularity" else -1.0
    grid = np.full(shape, np.inf)
    np.minimum.at(grid, (index[:, 0], index[:, 1]), sign * values)
    known = np.isfinite(grid)
    inside = binary_closing(known, iterations=2)
    weight = gaussian_filter(known.astype(float), 0.8)
    smooth = gaussian_filter(np.where(known, sign * grid, 0.0), 0.8) / np.maximum(weight, 1e-9)
    x, y = (low[k] + cell * (np.arange(shape[k]) - 2.0) for k in (0, 1))
    return x, y, np.where(inside, np.clip(smooth, 0.0, 1.0), np.nan)


def _paint(axes: Axes, x: Array, y: Array, height: Array, top: float) -> None:
    """Filled contours, cut off along a smooth outline."""
    inside = gaussian_filter(np.isfinite(height).astype(float), 0.8)
    nearest = np.where(np.isfinite(height), height, np.nan)
    axes.contourf(
        x, y, np.minimum(_spread(nearest).T, top), levels=top * LEVELS, cmap=COLOURS, vmin=0.0, vmax=top, zorder=0.6
    )
    axes.contourf(x, y, inside.T, levels=[-1.0, 0.5], colors="white", zorder=0.7)
    axes.contour(x, y, inside.T, levels=[0.5], colors=INK, linewidths=0.9, zorder=0.8)


def _spread(height: Array) -> Array:
    """Values carried beyond the edge, so that contours do not end before it."""
    _, (i, k) = distance_transform_edt(~np.isfinite(height), return_indices=True)
    return np.asarray(height[i, k])
