"""A map of a workspace: reachable places of the end effector, coloured by distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from scipy.ndimage import distance_transform_edt, gaussian_filter

from ...ground.arrays import Array
from ...kinematics.workspace import Margins, Workspace
from ...robot.robot import Robot
from ...scene.style import INK, STYLE
from ..options import Colour
from ..paint.labels import Labeller
from ..paint.layout import axes_at
from ..paint.paint import Painter
from .colours import COLOURS, SIDES, WORDS, colour_bar, head, shade, top_of
from .interpolate import CellMap, filled_maps
from .planes import Plane, choose_planes

# Text for the value at a point of the map, of all samples projected onto it.
_BEHIND: Final = {"singularity": "least", "limits": "largest"}
_LETTER_GROUND: Final = {
    "boxstyle": "round,pad=0.1",
    "facecolor": "white",
    "alpha": 0.7,
    "edgecolor": "none",
}
_SOFT: Final = 0.8  # [cells] width of smoothing of values and outline
# [cells] margin that is coloured too, and then clipped by the outline
_BEYOND: Final = 4.0
_HEIGHTS: Final = {1: 4.8, 2: 4.0, 3: 3.6}  # [in] largest height of axes, by the number of panels
_WIDTHS: Final = {1: 7.2, 2: 9.0, 3: 11.0}  # [in] largest width, by the number of panels
_FLAT: Final = 1e-9  # [m] extent normal to the plane that is rounding
_THIN: Final = 1e-6  # ratio of width to length below which a region is a line
_LEAST: Final = 6.4  # [in] least width of the figure
_LETTERS: Final = 108  # characters per line of the subtitle
# [in] heights: below the axes, above them, of the colour bar, of the title, of a further line
_BELOW, _ABOVE, _BAR, _HEAD, _LINE = 0.5, 0.3, 0.72, 0.56, 0.15


@dataclass(frozen=True, eq=False)
class SampledPath:
    """A path as places (N, 2) [m] with values (N,)."""

    places: Array
    values: Array


def values_of(samples: Margins, colour: Colour) -> Array:
    """(N,) values of samples for their colours, in [0, 1]; NaN if not reachable."""
    values = samples.singularity if colour == "singularity" else samples.limit
    return np.where(samples.reachable, np.clip(values, 0.0, 1.0), np.nan)


def workspace_figure(
    robot: Robot,
    workspace: Workspace,
    colour: Colour,
    title: str | None,
) -> Figure:
    """One panel for each plane, in one scale, with the robot at its reference on top.

    Args:
        robot: robot of the workspace.
        workspace: the workspace to show.
        colour: quantity shown by colours.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.
    """
    with mpl.rc_context(STYLE):
        planes = choose_planes(robot)
        contents = _contents(robot, workspace, planes, colour)
        pairs = zip(planes, contents, strict=True)
        boxes = [plane.box(content.places) for plane, content in pairs]
        sizes = np.ptp(np.array(boxes), axis=1)
        scale = _scale(sizes)
        widths = sizes[:, 0] * scale
        tallest = float(sizes[:, 1].max())
        line = _line(workspace)
        width = float(widths.sum()) + len(planes) * sum(SIDES)
        above = _ABOVE + _HEAD + _LINE * line.count("\n")
        height = tallest * scale + _BELOW + _BAR + above
        figure = Figure(figsize=(max(width, _LEAST), height))
        top = top_of([content.values for content in contents])
        head(figure, title or f"{robot.name}: workspace", line)
        left = 0.0
        for k, plane in enumerate(planes):
            place = (left + SIDES[0], _BAR + _BELOW, widths[k], tallest * scale)
            box = boxes[k]
            box[1, 1] = box[0, 1] + tallest
            _panel(axes_at(figure, place), plane, box, contents[k], top)
            left += widths[k] + sum(SIDES)
        colour_bar(figure, _colour_words(robot, colour), top, left - SIDES[1])
    return figure


def _scale(sizes: Array) -> float:
    """The scale [in/m] at which boxes of sizes (k, 2) [m] fit into their panels."""
    count = len(sizes)
    width = _WIDTHS[count] - count * sum(SIDES)
    tallest, total = float(sizes[:, 1].max()), float(sizes[:, 0].sum())
    return min(_HEIGHTS[count] / tallest, width / total)


def _line(workspace: Workspace) -> str:
    """The subtitle: the reach, and the share of reachable samples."""
    if not workspace.samples.reachable.any():
        return "nothing can be reached"
    spans = []
    for axis, (low, high) in zip("xyz", workspace.extents, strict=True):
        if high - low > _FLAT:
            spans.append(f"{axis} {low:.2f} to {high:.2f}")
    chosen = ""
    if workspace.assumed:
        chosen = f"; no limits: {', '.join(workspace.assumed)}"
    share = 100 * workspace.share()
    line = f"{', '.join(spans)} m; {share:.0f} % of the samples reachable{chosen}"
    return fill(line, _LETTERS)


def _colour_words(robot: Robot, colour: Colour) -> str:
    if len(robot.active) == 1:
        return WORDS[colour]
    return f"{_BEHIND[colour]} {WORDS[colour]}"


# -- what a plane shows


def _contents(
    robot: Robot,
    workspace: Workspace,
    planes: Sequence[Plane],
    colour: Colour,
) -> Sequence[SampledPath | CellMap]:
    """The content of each plane: a map, or a path for one active joint or a view edge-on."""
    if len(robot.active) == 1 or not workspace.samples.reachable.any():
        samples = workspace.samples.first(workspace.spread)
        return [_path(plane, samples, colour) for plane in planes]
    sign = 1.0 if colour == "singularity" else -1.0

    def score(samples: Margins) -> Array:
        return sign * values_of(samples, colour)

    flat = [_is_edge_on(plane, workspace.samples) for plane in planes]
    broad = [plane for plane, is_flat in zip(planes, flat, strict=True) if not is_flat]
    maps: list[CellMap] = []
    if broad:
        maps += filled_maps(robot, workspace, [plane.points for plane in broad], score)
    contents: list[SampledPath | CellMap] = []
    for plane, is_flat in zip(planes, flat, strict=True):
        if is_flat:
            contents.append(_edge(plane, workspace.samples, colour))
        else:
            each = maps.pop(0)
            contents.append(replace(each, values=sign * each.values))
    return contents


def _is_edge_on(plane: Plane, samples: Margins) -> bool:
    """Whether all reachable samples project onto a line."""
    points = plane.points(samples)[samples.reachable]
    extent = np.ptp(points, axis=0)
    return bool(extent.min() <= _THIN * extent.max())


def _edge(plane: Plane, samples: Margins, colour: Colour) -> SampledPath:
    """The reachable places on a line, in order."""
    reachable = np.flatnonzero(samples.reachable)
    points = plane.points(samples)[reachable]
    along = int(np.argmax(np.ptp(points, axis=0)))
    order = np.argsort(points[:, along], kind="stable")
    return SampledPath(points[order], values_of(samples, colour)[reachable][order])


def _path(plane: Plane, samples: Margins, colour: Colour) -> SampledPath:
    """The path of a robot with one active joint: its samples in order of that joint."""
    order = np.argsort(samples.u[:, 0], kind="stable")
    return SampledPath(plane.points(samples)[order], values_of(samples, colour)[order])


# -- painting


def _panel(
    axes: Axes,
    plane: Plane,
    box: Array,
    content: SampledPath | CellMap,
    top: float,
) -> None:
    axes.set(xlabel=plane.names[0], ylabel=plane.names[1])
    axes.set_title(plane.title, fontsize=9)
    axes.grid(visible=False)
    if isinstance(content, SampledPath):
        _paint_path(axes, content, top)
    elif content.inside.any():
        _paint_map(axes, content, top)
    painter = Painter(axes, plane.scene, sheer=True)
    painter.paint()
    axes.set(
        xlim=box[:, 0],
        ylim=box[:, 1],
        aspect="equal",
    )
    letters = []
    for letter in painter.letters:
        style = {**letter.style, "bbox": _LETTER_GROUND}
        letters.append(replace(letter, style=style))
    Labeller(axes, painter.covered).place(letters)


def _paint_path(axes: Axes, path: SampledPath, top: float) -> None:
    """Paint a path as a line coloured by its values, with gaps where it is not reachable."""
    segments = np.stack([path.places[:-1], path.places[1:]], axis=1)
    values = (path.values[:-1] + path.values[1:]) / 2.0
    drawn = np.isfinite(values) & np.isfinite(segments).all(axis=(1, 2))
    shared: Any = {"capstyle": "round", "zorder": 0.6}
    border = LineCollection(
        list(segments[drawn]),
        linewidths=6.0,
        colors=INK,
        **shared,
    )
    axes.add_collection(border, autolim=False)
    norm = Normalize(0.0, top)
    line = LineCollection(
        list(segments[drawn]),
        linewidths=4.5,
        cmap=COLOURS,
        norm=norm,
        **shared,
    )
    line.set_array(values[drawn])
    axes.add_collection(line, autolim=False)


def _paint_map(axes: Axes, content: CellMap, top: float) -> None:
    """Paint filled contours, clipped by the outline."""
    values = np.clip(_extended(_smoothed(content.values)), 0.0, top)
    shade(axes, content.grid.middles, values.T, top, 0.6)
    inside = gaussian_filter(content.inside.astype(float), _SOFT).T
    x, y = content.outline.middles
    axes.contourf(
        x,
        y,
        inside,
        levels=[-1.0, 0.5],
        colors="white",
        zorder=0.7,
    )
    axes.contour(
        x,
        y,
        inside,
        levels=[0.5],
        colors=INK,
        linewidths=0.9,
        zorder=0.8,
    )


def _smoothed(values: Array) -> Array:
    """Values smoothed over neighbouring cells; NaN where there are none."""
    filled = np.isfinite(values)
    weight = np.maximum(gaussian_filter(filled.astype(float), _SOFT), 1e-9)
    total = gaussian_filter(np.where(filled, values, 0.0), _SOFT)
    return np.where(filled, total / weight, np.nan)


def _extended(values: Array) -> Array:
    """Values extended a few cells beyond the edge, so that contours reach the outline."""
    distance, (i, k) = distance_transform_edt(~np.isfinite(values), return_indices=True)
    return np.where(distance <= _BEYOND, values[i, k], np.nan)
