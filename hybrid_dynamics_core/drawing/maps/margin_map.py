"""A map over two active coordinates: how near to a singularity the robot is, and where strokes and limits end."""

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
from .workspace import WORDS, colour_bar, head, shade, top_of

_CELLS: Final = 240  # in each direction
_BEYOND: Final = 0.08  # of the range: what is shown outside of it
_LINES: Final = (0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8)
_NAMED: Final = 0.2  # lower lines crowd at the edge
_CLEAR: Final = 0.03  # of what is shown: a line nearer to an end has no room for its level
_SIZE: Final = (6.9, 6.0)  # [in] of the figure
_STYLES: Final[dict[str, Any]] = {"stroke end or limit": "-", "toggle point of a loop": (0, (4, 2))}
_DOT: Final[dict[str, Any]] = {
    "marker": "o", "linestyle": "", "color": "white", "markeredgecolor": INK, "mew": 1.6, "markersize": 7
}  # fmt: skip
_BOX: Final = (0.8, 1.52, 5.9, 3.75)  # [in] of the axes


def over_figure(
    robot: Robot, over: tuple[str, str], u: ArrayLike | None, colour: Colour, title: str | None
) -> Figure:
    """The map over two active coordinates; the others stay at u (n,), the reference if None."""
    base = robot.reference if u is None else finite_vectors("u", u, robot.active, -1)
    ranges, axes_of = _ranges(robot, over)
    lines = [np.linspace(low, high, _CELLS) for low, high in axes_of]
    x, y = np.meshgrid(*lines)
    k = [robot.active.index(name) for name in over]
    points = np.tile(base, (x.size, 1))
    points[:, k[0]], points[:, k[1]] = x.ravel(), y.ravel()
    samples = margins_at(robot, points)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=_SIZE)
        head(figure, title or f"{robot.name}: {over[0]} and {over[1]}", _held(robot, over, base))
        axes = axes_at(figure, _BOX)
        axes.grid(visible=False)
        axes.set_facecolor(STEEL)
        top = _margin(axes, lines, samples, colour)
        kinds = _ends(axes, robot, over, ranges)
        axes.plot(*base[k], **_DOT, zorder=3.0)
        axes.set(
            xlim=axes_of[0],
            ylim=axes_of[1],
            xlabel=_label(robot, over[0]),
            ylabel=_label(robot, over[1]),
        )
        colour_bar(figure, WORDS[colour], top, _BOX[0] + _BOX[2])
        taken = (
            "reference configuration"
            if np.array_equal(base, robot.reference)
            else "configuration given"
        )
        _key(figure, samples, kinds, taken)
    return figure


def _ranges(robot: Robot, over: tuple[str, str]) -> tuple[Array, Array]:
    """(2, 2) the ranges of both coordinates, and what of them is shown: a little more."""
    for name in over:
        if name not in robot.active:
            hint = suggestion(name, robot.active)
            raise InputError(
                f"over: '{name}' is not an active joint{hint}; they are {', '.join(robot.active)}"
            )
    if over[0] == over[1]:
        raise InputError(f"over: expected two different active joints, got {over[0]} twice")
    box = sampled_ranges(robot, None)[0][[robot.active.index(name) for name in over]]
    return box, box + _BEYOND * np.ptp(box, axis=1, keepdims=True) * np.array([-1.0, 1.0])


def _margin(axes: Axes, lines: list[Array], samples: Margins, colour: Colour) -> float:
    """The map; where its colours end."""
    shape = (_CELLS, _CELLS)
    closed = np.isin(samples.status, (SampleStatus.OK, SampleStatus.BEYOND)).reshape(shape)
    values = samples.singularity if colour == "singularity" else samples.limit
    height = np.where(closed, np.clip(values.reshape(shape), 0.0, 1.0), np.nan)
    top = top_of([height])
    shade(axes, lines, np.minimum(height, top), top, 1.0)
    inside = (
        [level for level in _LINES if np.nanmin(height) < level < np.nanmax(height)]
        if closed.any()
        else []
    )
    if inside:
        drawn = axes.contour(*lines, height, levels=inside, colors=INK, linewidths=0.7, zorder=1.4)
        _name_lines(axes, drawn, lines)
    beyond = (samples.status == SampleStatus.BEYOND).reshape(shape)
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


def _name_lines(axes: Axes, drawn: ContourSet, lines: list[Array]) -> None:
    """The level of each line, where it is farthest from the ends of the ranges."""
    low, span = np.array([line[0] for line in lines]), np.array([np.ptp(line) for line in lines])
    least = _CLEAR + _BEYOND / (
        1.0 + 2.0 * _BEYOND
    )  # of what is shown, with what lies outside of the ranges
    for level, path in zip(drawn.levels, drawn.get_paths(), strict=True):
        places = np.asarray(path.vertices, dtype=float)
        share = (places - low) / span
        inward = np.minimum(share, 1.0 - share)
        places, inward = places[(inward > least).all(axis=1)], inward[(inward > least).all(axis=1)]
        if level >= _NAMED and len(places):
            x, y = places[int(np.argmax(inward.prod(axis=1)))].tolist()
            axes.clabel(drawn, [level], fmt="%g", fontsize=7.5, manual=[(x, y)])


def _ends(axes: Axes, robot: Robot, over: tuple[str, str], ranges: Array) -> set[str]:
    """LineMark ends and limits of the file as solid lines, ends at toggle points of loops as dashed ones; which occur."""
    told, kinds = limited_joints(robot), set()
    for k, name in enumerate(over):
        draw = axes.axvline if k == 0 else axes.axhline
        for value, limit in zip(ranges[k], robot.limits[robot.active.index(name)], strict=True):
            if np.isfinite(limit):
                own = name in told and bool(np.isclose(told[name], value).any())
                kind = "stroke end or limit" if own else "toggle point of a loop"
                draw(value, color=BLUE, linewidth=1.8, linestyle=_STYLES[kind], zorder=2.0)
                kinds.add(kind)
    return kinds


def _held(robot: Robot, over: tuple[str, str], base: Array) -> str:
    held = [
        f"{name} = {value:.3g}"
        for name, value in zip(robot.active, base, strict=True)
        if name not in over
    ]
    return f"held: {', '.join(held)}" if held else "all active joints"


def _label(robot: Robot, name: str) -> str:
    return f"{name} [{coordinate_unit(robot.joint_types[name])}]"


def _key(figure: Figure, samples: Margins, kinds: set[str], taken: str) -> None:
    """What lines and areas mean, of those that occur; `taken`: what the dot is."""
    entries: list[tuple[Any, str]] = [
        (Line2D([], [], color=BLUE, linewidth=1.8, linestyle=style), kind)
        for kind, style in _STYLES.items()
        if kind in kinds
    ]
    entries.append((Line2D([], [], **_DOT), taken))
    if np.isin(samples.status, (SampleStatus.OPEN, SampleStatus.SINGULAR)).any():
        entries.append((Patch(facecolor=STEEL, edgecolor=QUIET), "loops do not close here"))
    if (samples.status == SampleStatus.BEYOND).any():
        entries.append((Patch(facecolor="white", edgecolor=QUIET, hatch="////"), "beyond a limit"))
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
