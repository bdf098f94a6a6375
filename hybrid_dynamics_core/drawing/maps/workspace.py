"""A workspace as a map: where the end effector can be, coloured by how near to a singularity or a limit it is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from textwrap import fill
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from scipy.ndimage import distance_transform_edt, gaussian_filter

from ...ground.arrays import Array
from ...kinematics.workspace import Margins, Workspace
from ...robot.robot import Robot
from ...scene.style import INK, QUIET, STYLE
from ..options import Colour
from ..paint.labels import Labeller
from ..paint.layout import axes_at
from ..paint.paint import Painter
from .interpolate import Map, filled
from .planes import Plane, choose_planes

COLOURS: Final = mpl.colormaps["YlOrRd_r"]
LEVELS: Final = np.linspace(0.0, 1.0, 81)  # so fine that no step is seen where values change slowly
WORDS: Final = {
    "singularity": "distance to the nearest singularity of a loop (0 singular, 1 best)",
    "limits": "distance to the nearest limit of a joint (0 there, 1 mid-range)",
}
_BEHIND: Final = {
    "singularity": "least",
    "limits": "largest",
}  # of what lies behind a point of the map
_GROUND: Final = {
    "boxstyle": "round,pad=0.1",
    "facecolor": "white",
    "alpha": 0.7,
    "edgecolor": "none",
}  # of letters
_SOFT: Final = 0.8  # [cells] over which values and outline are smoothed
_BEYOND: Final = (
    4.0  # [cells] outside of the known ones that get colours, which the outline cuts off
)
_HEIGHTS: Final = {1: 4.8, 2: 4.0, 3: 3.6}  # [in] of the panels' axes, at most, by their number
_WIDTHS: Final = {1: 7.2, 2: 9.0, 3: 11.0}  # [in] of the figure, at most
_LOWEST: Final = 1e-6  # largest value of a map that is all zero but for rounding
_FLAT: Final = 1e-9  # [m] extent across the plane of a planar mechanism, but for rounding
_LEAST: Final = 6.4  # [in] of the figure
_SHORT: Final = 5.2  # [in] of the key, at least: its words have that length
_SIDES: Final = (0.76, 0.16)  # [in] left and right of a panel's axes
_BELOW, _ABOVE, _BAR, _HEAD, _LINE = 0.5, 0.3, 0.72, 0.56, 0.15  # [in]


@dataclass(frozen=True, eq=False)
class Path:
    """A path as places (N, 2) [m] with values (N,)."""

    places: Array
    values: Array


def values_of(samples: Margins, colour: Colour) -> Array:
    """(N,) what colours the samples, in [0, 1]; NaN where they are not reachable."""
    value = samples.singularity if colour == "singularity" else samples.limit
    return np.where(samples.reachable, np.clip(value, 0.0, 1.0), np.nan)


def workspace_figure(
    robot: Robot, workspace: Workspace, colour: Colour, title: str | None
) -> Figure:
    """One panel a plane, in one scale, with the robot in its reference configuration on top."""
    with mpl.rc_context(STYLE):
        planes = choose_planes(robot)
        panels = _drawn(robot, workspace, planes, colour)
        boxes = [plane.box(drawn.places) for plane, drawn in zip(planes, panels, strict=True)]
        sizes = np.ptp(np.array(boxes), axis=1)
        room = _HEIGHTS[len(planes)], _WIDTHS[len(planes)] - len(planes) * sum(_SIDES)
        scale = min(room[0] / sizes[:, 1].max(), room[1] / sizes[:, 0].sum())
        widths, tallest = sizes[:, 0] * scale, float(sizes[:, 1].max())
        told = _told(workspace)
        above = _ABOVE + _HEAD + _LINE * told.count("\n")
        size = (
            float(widths.sum()) + len(planes) * sum(_SIDES),
            tallest * scale + _BELOW + _BAR + above,
        )
        figure = Figure(figsize=(max(size[0], _LEAST), size[1]))
        top = top_of([drawn.values for drawn in panels])
        head(figure, title or f"{robot.name}: workspace", told)
        left = 0.0
        for plane, box, drawn, width in zip(planes, boxes, panels, widths, strict=True):
            axes = axes_at(figure, (left + _SIDES[0], _BAR + _BELOW, width, tallest * scale))
            box[1, 1] = box[0, 1] + tallest
            _panel(axes, plane, box, drawn, top)
            left += width + sum(_SIDES)
        one = len(robot.active) == 1
        words = WORDS[colour] if one else f"{_BEHIND[colour]} {WORDS[colour]}"
        colour_bar(figure, words, top, left - _SIDES[1])
    return figure


def _told(workspace: Workspace) -> str:
    if not workspace.samples.reachable.any():
        return "nothing can be reached"
    spans = (
        f"{name} {low:.2f} to {high:.2f}"
        for name, (low, high) in zip("xyz", workspace.extents, strict=True)
        if high - low > _FLAT
    )
    chosen = f"; no limits: {', '.join(workspace.assumed)}" if workspace.assumed else ""
    return fill(
        f"{', '.join(spans)} m; {100 * workspace.share():.0f} % of the samples reachable{chosen}",
        108,
    )


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


def colour_bar(figure: Figure, text: str, top: float, right: float) -> None:
    """The key to the colours, at the bottom, up to where the panels end [in]; it says so where they end below 1."""
    text = text if top == 1.0 else f"{text.removesuffix(')')}; colours up to {top:.3g})"
    width = float(figure.get_size_inches()[0])
    axes = axes_at(figure, (_SIDES[0], 0.3, max(min(width - 1.0, _SHORT), right - _SIDES[0]), 0.12))
    figure.colorbar(
        ScalarMappable(Normalize(0.0, top), COLOURS), cax=axes, orientation="horizontal"
    )
    axes.set_title(text, fontsize=8.5, pad=4)
    axes.tick_params(labelsize=8)


def _panel(axes: Axes, plane: Plane, box: Array, drawn: Path | Map, top: float) -> None:
    axes.set(xlabel=plane.names[0], ylabel=plane.names[1])
    axes.set_title(plane.title, fontsize=9)
    axes.grid(visible=False)
    if isinstance(drawn, Path):
        _line(axes, drawn, top)
    elif drawn.inside.any():
        _paint(axes, drawn, top)
    painter = Painter(axes, plane.scene, sheer=True)
    painter.paint()
    axes.set(xlim=box[:, 0], ylim=box[:, 1], aspect="equal")
    letters = [
        replace(letter, style={**letter.style, "bbox": _GROUND}) for letter in painter.letters
    ]
    Labeller(axes, painter.covered).place(letters)


def _drawn(
    robot: Robot, workspace: Workspace, planes: Sequence[Plane], colour: Colour
) -> Sequence[Path | Map]:
    """What each plane shows: a path where one joint is active, else a map."""
    if len(robot.active) == 1 or not workspace.samples.reachable.any():
        return [
            _along(plane, workspace.samples.first(workspace.spread), colour) for plane in planes
        ]
    sign = 1.0 if colour == "singularity" else -1.0
    maps = filled(
        robot, workspace, [plane.points for plane in planes], lambda s: sign * values_of(s, colour)
    )
    return [replace(each, values=sign * each.values) for each in maps]


def _along(plane: Plane, samples: Margins, colour: Colour) -> Path:
    """The path of a robot with one active joint: its samples in order of that joint, with values."""
    order = np.argsort(samples.u[:, 0], kind="stable")
    return Path(plane.points(samples)[order], values_of(samples, colour)[order])


def _line(axes: Axes, path: Path, top: float) -> None:
    """The path as a line in the colours of its values, with gaps where nothing is reachable."""
    segments = np.stack([path.places[:-1], path.places[1:]], axis=1)
    middle = (path.values[:-1] + path.values[1:]) / 2.0
    good = np.isfinite(middle) & np.isfinite(segments).all(axis=(1, 2))
    for width, colours in (
        (6.0, {"colors": INK}),
        (4.5, {"cmap": COLOURS, "norm": Normalize(0.0, top)}),
    ):
        line = LineCollection(
            list(segments[good]), linewidths=width, capstyle="round", zorder=0.6, **colours
        )
        if "cmap" in colours:
            line.set_array(middle[good])
        axes.add_collection(line, autolim=False)


def _paint(axes: Axes, drawn: Map, top: float) -> None:
    """Filled contours, cut off along the outline."""
    known = np.isfinite(drawn.values)
    weight = np.maximum(gaussian_filter(known.astype(float), _SOFT), 1e-9)
    values = np.where(
        known, gaussian_filter(np.where(known, drawn.values, 0.0), _SOFT) / weight, np.nan
    )
    shade(axes, drawn.grid.middles, np.clip(_spread(values), 0.0, top).T, top, 0.6)
    inside = gaussian_filter(drawn.inside.astype(float), _SOFT).T
    axes.contourf(*drawn.outline.middles, inside, levels=[-1.0, 0.5], colors="white", zorder=0.7)
    axes.contour(
        *drawn.outline.middles, inside, levels=[0.5], colors=INK, linewidths=0.9, zorder=0.8
    )


def shade(axes: Axes, middles: Sequence[Array], values: Array, top: float, order: float) -> None:
    """Values (N, M) in [0, top] in their colours; as an image within drawings of lines, which else grow heavy."""
    areas = axes.contourf(
        *middles, values, levels=top * LEVELS, cmap=COLOURS, vmin=0.0, vmax=top, zorder=order
    )
    areas.set_rasterized(True)


def _spread(height: Array) -> Array:
    """Values carried a few cells beyond the edge, so that contours do not end before it."""
    far, (i, k) = distance_transform_edt(~np.isfinite(height), return_indices=True)
    return np.where(far <= _BEYOND, height[i, k], np.nan)
