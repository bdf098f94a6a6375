"""A map over two active coordinates: distances to singularities, ends of strokes and limits."""

from __future__ import annotations

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import ArrayLike

from ...errors import InputError
from ...ground.arrays import Array
from ...ground.check_arrays import finite_vectors
from ...ground.suggestions import suggestion
from ...ground.units import coordinate_unit
from ...kinematics.sampling import sampled_ranges
from ...kinematics.workspace import Margins, SampleStatus, limited_joints, margins_at
from ...robot.robot import Robot
from ...scene.style import BLUE, INK, QUIET, STEEL, STYLE
from ..options import Colour
from ..paint.layout import axes_at
from .cells import Mask
from .colours import WORDS, colour_bar, head, shade, top_of

_CELLS: Final = 240  # in each direction
_BEYOND: Final = 0.08  # share of the range that is shown beyond each end
_LINES: Final = (0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8)
_NAMED: Final = 0.2  # least level with a label; lower lines are crowded at the edge
_CLEAR: Final = 0.03  # share of the map: a line nearer to an end has no room for its label
_SIZE: Final = (6.9, 6.0)  # [in] of the figure
_BOX: Final = (0.8, 1.52, 5.9, 3.75)  # [in] of the axes
_LIMIT: Final = "stroke end or limit"
_TOGGLE: Final = "toggle point of a loop"
_STYLES: Final[dict[str, Any]] = {_LIMIT: "-", _TOGGLE: (0, (4, 2))}
_DOT: Final[dict[str, Any]] = {
    "marker": "o",
    "linestyle": "",
    "color": "white",
    "markeredgecolor": INK,
    "mew": 1.6,
    "markersize": 7,
}
Pair = tuple[str, str]  # names of the two coordinates


def margin_figure(
    robot: Robot,
    pair: Pair,
    u: ArrayLike | None,
    colour: Colour,
    title: str | None,
) -> Figure:
    """The map over two active coordinates.

    Args:
        robot: to be mapped.
        pair: names of the two coordinates.
        u: (n,) active coordinates at which the others stay [rad or m]; None: the reference.
        colour: quantity shown by colours.
        title: title of the figure; None: the names of robot and coordinates.

    Returns:
        The figure.

    Raises:
        InputError: for names that are not active coordinates.
    """
    base = robot.reference if u is None else finite_vectors("u", u, robot.active, -1)
    ranges, limits = _ranges(robot, pair)
    lines = [np.linspace(low, high, _CELLS) for low, high in limits]
    samples = margins_at(robot, _grid_points(robot, pair, base, lines))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=_SIZE)
        head(figure, title or f"{robot.name}: {pair[0]} and {pair[1]}", _held(robot, pair, base))
        axes = axes_at(figure, _BOX)
        axes.grid(visible=False)
        axes.set_facecolor(STEEL)
        top = _paint_map(axes, lines, samples, colour)
        kinds = _draw_ends(axes, robot, pair, ranges)
        axes.plot(*base[_columns(robot, pair)], **_DOT, zorder=3.0)
        axes.set(xlim=limits[0], ylim=limits[1])
        axes.set(xlabel=_label(robot, pair[0]), ylabel=_label(robot, pair[1]))
        colour_bar(figure, WORDS[colour], top, _BOX[0] + _BOX[2])
        is_reference = np.array_equal(base, robot.reference)
        dot = "reference configuration" if is_reference else "configuration given"
        _key(figure, samples, kinds, dot)
    return figure


def _columns(robot: Robot, pair: Pair) -> list[int]:
    return [robot.active.index(name) for name in pair]


def _grid_points(
    robot: Robot,
    pair: Pair,
    base: Array,
    lines: list[Array],
) -> Array:
    """(N, n) active coordinates of all points of the map."""
    x, y = np.meshgrid(*lines)
    first, second = _columns(robot, pair)
    points = np.tile(base, (x.size, 1))
    points[:, first] = x.ravel()
    points[:, second] = y.ravel()
    return points


def _ranges(robot: Robot, pair: Pair) -> tuple[Array, Array]:
    """(2, 2) ranges of both coordinates, and the slightly wider ranges that are shown."""
    for name in pair:
        if name not in robot.active:
            hint = suggestion(name, robot.active)
            raise InputError(
                f"over: '{name}' is not an active joint{hint}; they are {', '.join(robot.active)}"
            )
    if pair[0] == pair[1]:
        raise InputError(f"over: expected two different active joints, got {pair[0]} twice")
    ranges = sampled_ranges(robot, None)[0][_columns(robot, pair)]
    beyond = _BEYOND * np.ptp(ranges, axis=1, keepdims=True)
    return ranges, ranges + beyond * np.array([-1.0, 1.0])


# -- the map


def _paint_map(
    axes: Axes,
    lines: list[Array],
    samples: Margins,
    colour: Colour,
) -> float:
    """Paint the map; returns the upper end of its colour scale."""
    closed = _has_status(samples, SampleStatus.OK, SampleStatus.BEYOND)
    values = samples.singularity if colour == "singularity" else samples.limit
    clipped = np.clip(values.reshape(closed.shape), 0.0, 1.0)
    height = np.where(closed, clipped, np.nan)
    top = top_of([height])
    shade(axes, lines, np.minimum(height, top), top, 1.0)
    if closed.any():
        _draw_levels(axes, lines, height)
    beyond = _has_status(samples, SampleStatus.BEYOND)
    if beyond.any():
        area = axes.contourf(
            *lines,
            beyond.astype(float),
            levels=[0.5, 2.0],
            colors="none",
            hatches=["////"],
            zorder=1.6,
        )
        area.set(edgecolor=QUIET, linewidth=0.0)
    return top


def _has_status(samples: Margins, *statuses: SampleStatus) -> Mask:
    """Mask of the points of the map that have one of some statuses."""
    return np.isin(samples.status, statuses).reshape(_CELLS, _CELLS)


def _draw_levels(axes: Axes, lines: list[Array], height: Array) -> None:
    """Draw contour lines with labels."""
    lowest, highest = np.nanmin(height), np.nanmax(height)
    levels = [level for level in _LINES if lowest < level < highest]
    if not levels:
        return
    drawn = axes.contour(
        *lines,
        height,
        levels=levels,
        colors=INK,
        linewidths=0.7,
        zorder=1.4,
    )
    _name_levels(axes, drawn, lines)


def _name_levels(axes: Axes, drawn: ContourSet, lines: list[Array]) -> None:
    """Label each line at its point farthest from the ends of the ranges."""
    low = np.array([line[0] for line in lines])
    span = np.array([np.ptp(line) for line in lines])
    # As a share of the map, which reaches beyond the ranges.
    least = _CLEAR + _BEYOND / (1.0 + 2.0 * _BEYOND)
    for level, path in zip(drawn.levels, drawn.get_paths(), strict=True):
        places = np.asarray(path.vertices, dtype=float)
        share = (places - low) / span
        inward = np.minimum(share, 1.0 - share)
        inside = (inward > least).all(axis=1)
        if level < _NAMED or not inside.any():
            continue
        best = int(np.argmax(inward[inside].prod(axis=1)))
        x, y = places[inside][best].tolist()
        axes.clabel(
            drawn,
            [level],
            fmt="%g",
            fontsize=7.5,
            manual=[(x, y)],
        )


# -- lines and words


def _draw_ends(
    axes: Axes,
    robot: Robot,
    pair: Pair,
    ranges: Array,
) -> set[str]:
    """Draw lines at the ends of ranges; returns the kinds that occur.

    Stroke ends and limits of the file are solid lines, toggle points of loops dashed ones.
    """
    kinds = set()
    for k, name in enumerate(pair):
        draw_line = axes.axvline if k == 0 else axes.axhline
        for value in _finite_ends(robot, name, ranges[k]):
            kind = _end_kind(robot, name, value)
            draw_line(
                value,
                color=BLUE,
                linewidth=1.8,
                linestyle=_STYLES[kind],
                zorder=2.0,
            )
            kinds.add(kind)
    return kinds


def _finite_ends(robot: Robot, name: str, ends: Array) -> list[float]:
    """Ends of a range at which the robot has a limit."""
    limits = robot.limits[robot.active.index(name)]
    return [end for end, limit in zip(ends, limits, strict=True) if np.isfinite(limit)]


def _end_kind(robot: Robot, name: str, value: float) -> str:
    limits = limited_joints(robot)
    if name in limits and np.isclose(limits[name], value).any():
        return _LIMIT
    return _TOGGLE


def _held(robot: Robot, pair: Pair, base: Array) -> str:
    """The constant coordinates with their values, as text."""
    held = []
    for name, value in zip(robot.active, base, strict=True):
        if name not in pair:
            held.append(f"{name} = {value:.3g}")
    return f"held: {', '.join(held)}" if held else "all active joints"


def _label(robot: Robot, name: str) -> str:
    return f"{name} [{coordinate_unit(robot.joint_types[name])}]"


def _key(
    figure: Figure,
    samples: Margins,
    kinds: set[str],
    dot: str,
) -> None:
    """Draw a legend of the lines and areas that occur; `dot` is the text for the dot."""
    entries: list[tuple[Any, str]] = []
    for kind, style in _STYLES.items():
        if kind in kinds:
            entries.append(
                (
                    Line2D(
                        [],
                        [],
                        color=BLUE,
                        linewidth=1.8,
                        linestyle=style,
                    ),
                    kind,
                )
            )
    entries.append((Line2D([], [], **_DOT), dot))
    if _has_status(samples, SampleStatus.OPEN, SampleStatus.SINGULAR).any():
        entries.append((Patch(facecolor=STEEL, edgecolor=QUIET), "loops do not close here"))
    if _has_status(samples, SampleStatus.BEYOND).any():
        hatched = Patch(facecolor="white", edgecolor=QUIET, hatch="////")
        entries.append((hatched, "beyond a limit"))
    handles, texts = zip(*entries, strict=True)
    figure.legend(
        handles,
        texts,
        loc="lower left",
        bbox_to_anchor=(0.11, 0.11),
        ncols=3,
        fontsize=8,
        frameon=False,
        borderpad=0.0,
    )
