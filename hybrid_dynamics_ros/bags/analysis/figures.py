"""The figures of a report."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hybrid_dynamics_core.drawing.plots.rounding import Sizes, sizes_of, suppress_rounding
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.scene.style import (
    BLUE,
    GREEN,
    INK,
    LOOPS,
    ORANGE,
    PURPLE,
    QUIET,
    RED,
    STYLE,
)

from ...messages.joint_samples import FloatArray
from .collect import Track
from .stamp_intervals import Stamps

_COLOURS: Final = LOOPS  # as in the drawings; RED is kept for what is beyond an end
_WIDTH: Final = 10.5  # [inch]
_LEAST: Final = 1e-17  # residuals of zero on a logarithmic axis
_ABOVE: Final[dict[str, Any]] = {
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 0.97),
    "fontsize": 8,
    "frameon": False,
}
_NEAR: Final = 0.1  # of a singularity
_THOUSANDS: Final = "{x:,.10g}"
_RECORDED: Final = "#b4bac2"
_BEYOND: Final[dict[str, Any]] = {"color": "black", "markersize": 5, "clip_on": False, "zorder": 5}
_BOX: Final = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.0}
_NOTE: Final[dict[str, Any]] = {
    "ha": "right",
    "va": "top",
    "fontsize": 8,
    "bbox": _BOX,
    "zorder": 6,
}
_MOST: Final = 2500  # points of a line: more cannot be seen, and make the page heavy
Draw = Callable[[Track], Figure]


def trajectories(track: Track) -> Figure:
    """Active joints: position and velocity, a row each."""
    names = track.robot.active
    figure, axes = _panels(len(names), 2, 1.7)
    sizes = _sizes(track)
    for k, name in enumerate(names):
        kind = track.robot.joint_types[name]
        units = coordinate_unit(kind), coordinate_unit(kind, "/s")
        natural = sizes.position(kind), sizes.rate(kind)
        parts = zip(axes[k], (track.state.u, track.state.du), units, natural, strict=True)
        for ax, values, unit, size in parts:
            _line(ax, track, values[:, k], _COLOURS[k % len(_COLOURS)])
            suppress_rounding(ax, size)
            ax.set_ylabel(f"{name} [{unit}]")
    axes[0][0].set_title("position")
    axes[0][1].set_title("velocity")
    return figure


def efforts(track: Track) -> Figure:
    """Efforts recorded and computed, and their difference."""
    names, told = track.robot.active, np.isfinite(track.recorded).any()
    figure, axes = _panels(len(names), 2 if told else 1, 1.9)
    sizes = _sizes(track)
    for k, name in enumerate(names):
        ax, kind = axes[k][0], track.robot.joint_types[name]
        unit, size = effort_unit(kind), sizes.effort(kind)
        if told:
            _line(ax, track, track.recorded[:, k], _RECORDED, label="recorded", linewidth=1.8)
        _line(ax, track, track.efforts[:, k], _COLOURS[k % len(_COLOURS)], label="computed")
        if not suppress_rounding(ax, size):
            _clip(ax, track, track.efforts[:, k], track.recorded[:, k])
        ax.set_ylabel(f"{name} [{unit}]")
        if told:
            left = track.recorded[:, k] - track.efforts[:, k]
            _line(axes[k][1], track, left, _COLOURS[k % len(_COLOURS)])
            if not suppress_rounding(axes[k][1], size):
                _clip(axes[k][1], track, left)
            axes[k][1].axhline(0.0, color=QUIET, linewidth=0.6)
            axes[k][1].set_ylabel(f"{name} [{unit}]")
    axes[0][0].legend(**_ABOVE, ncols=2)
    axes[0][0].set_title("efforts")
    if told:
        axes[0][1].set_title("recorded less computed")
    return figure


def energy(track: Track) -> Figure:
    """Energy, and the power of the actuators."""
    figure, axes = _panels(2, 1, 2.2)
    kinetic, potential = track.energy
    _line(axes[0][0], track, kinetic, BLUE, label="of motion")
    _line(
        axes[0][0],
        track,
        potential - potential[0],
        GREEN,
        label="of gravity and springs, since the start",
    )
    _line(
        axes[0][0],
        track,
        kinetic + potential - kinetic[0] - potential[0],
        QUIET,
        label="both, since the start",
    )
    axes[0][0].set_ylabel("energy [J]")
    axes[0][0].legend(**_ABOVE, ncols=3)
    sizes = _sizes(track)
    suppress_rounding(axes[0][0], sizes.energy)
    for k, name in enumerate(track.robot.active):
        part = track.efforts[:, k] * track.state.du[:, k]
        _line(axes[1][0], track, part, _COLOURS[k % len(_COLOURS)], label=name)
    _line(axes[1][0], track, track.power, INK, label="sum")
    axes[1][0].set_ylabel("power [W]")
    axes[1][0].legend(**_ABOVE, ncols=8)
    suppress_rounding(axes[1][0], sizes.energy / sizes.time)
    return figure


def closure(track: Track) -> Figure:
    """Residual of the loops, and the distance of each to a singularity."""
    figure, axes = _panels(2, 1, 2.2)
    _line(axes[0][0], track, np.maximum(np.asarray(track.state.residual), _LEAST), BLUE)
    axes[0][0].set_yscale("log")
    axes[0][0].set_ylim(1e-17, max(1e-11, 10.0 * float(np.max(track.state.residual))))
    axes[0][0].set_ylabel("largest residual [1]")
    for k, loop in enumerate(track.robot.loops):
        _line(
            axes[1][0], track, track.state.distances[:, k], _COLOURS[k % len(_COLOURS)], label=loop
        )
    axes[1][0].set_ylim(0.0, 1.05)
    axes[1][0].axhline(_NEAR, color=QUIET, linewidth=0.8, linestyle="--", label=f"near: {_NEAR:g}")
    axes[1][0].set_ylabel("distance to a\nsingularity [1]")
    axes[1][0].legend(**_ABOVE, ncols=6)
    return figure


def margins(track: Track) -> Figure:
    """What is left to the nearer end of each joint's range."""
    names, left = track.margins
    sizes = _sizes(track)
    figure, axes = _panels(max(len(names), 1), 1, 1.5)
    for k, name in enumerate(names):
        ax = axes[k][0]
        _line(ax, track, left[:, k], _COLOURS[k % len(_COLOURS)])
        ax.axhline(0.0, color=RED, linewidth=0.8)
        low, high = min(0.0, float(left[:, k].min())), max(0.0, float(left[:, k].max()))
        room = 0.08 * (high - low) + 1e-9
        ax.set_ylim(low - room, high + room)  # the line at 0 stands clear of the axis
        kind = track.robot.joint_types[name]
        suppress_rounding(ax, sizes.position(kind))
        ax.set_ylabel(f"{name} [{coordinate_unit(kind)}]")
    return figure


def sampling(track: Track) -> Figure:
    """Intervals between stamps, and where samples are missing, off or refused."""
    missing = track.stamps.missing
    regular = not (missing or track.gaps or track.outliers or track.bad)
    figure, axes = _panels(1, 1 if regular else 2, 2.4)
    steps = _intervals(axes[0][0], track.stamps)
    if regular:
        axes[0][0].set_title(f"{steps}; no gaps, none missing or bad")
        return figure
    axes[0][0].set_title(steps)
    ax = axes[0][1]
    for start, end in track.gaps:
        ax.axvspan(min(start, end), max(start, end), color=ORANGE, alpha=0.5, linewidth=1.0)
    first = track.start_ns
    looked = track.smooth != "causal"
    rows = [
        ("missing", ORANGE, [at for at, _, _ in missing]),
        *(
            [("off the motion", PURPLE, [outlier.at(first) for outlier in track.outliers])]
            if looked
            else []
        ),
        ("refused", RED, [at for at, _ in track.bad]),
    ]
    for k, (_, colour, times) in enumerate(rows):
        ax.plot(
            times,
            np.full(len(times), 2.0 - k),
            "|",
            color=colour,
            markersize=16,
            markeredgewidth=1.6,
        )
    ax.set_xlim(*_wider(float(track.time.min()), float(track.time.max())))
    ax.set_ylim(2.4 - len(rows), 2.6)
    counts = [sum(count for _, _, count in missing), *(len(times) for _, _, times in rows[1:])]
    told = [f"{name}: {count}" for (name, _, _), count in zip(rows, counts, strict=True)]
    ax.set_yticks([2.0 - k for k in range(len(rows))], told)
    ax.set_title(f"samples; gaps, shaded: {len(track.gaps)}")
    ax.set_xlabel("time [s]")
    return figure


def _intervals(ax: Axes, stamps: Stamps) -> str:
    """How many intervals are how long, and in words how many of the few that are far from the others."""
    steps = stamps.intervals * 1e3
    ax.set_xlabel("between stamps [ms]")
    ax.set_ylabel("intervals")
    if not len(steps):
        return "no intervals"
    low, high = np.percentile(steps, [0.5, 99.5])
    span = max(high - low, 0.1 * stamps.nominal * 1e3, 1e-6)
    low, high = low - 0.2 * span, high + 0.2 * span
    inside = steps[(steps >= low) & (steps <= high)]
    ax.hist(inside, bins=61, range=(low, high), color=BLUE)  # odd: one stands on the usual interval
    ax.set_xlim(low, high)
    words = [
        (
            f"{len(inside)} of {len(steps)} intervals"
            if len(inside) < len(steps)
            else f"{len(steps)} intervals"
        )
    ]
    if (steps < low).any():
        words.append(f"{(steps < low).sum()} shorter, from {steps.min():.4g} ms")
    if (steps > high).any():
        words.append(f"{(steps > high).sum()} longer, to {steps.max():.4g} ms")
    return "; ".join(words)


def _wider(low: float, high: float) -> tuple[float, float]:
    """A range with some room, so that marks at its ends are seen."""
    room = max(0.02 * (high - low), 1e-3)
    return low - room, high + room


def svg(draw: Draw, track: Track, name: str) -> str:
    """A figure as SVG text to stand in a page; `name` keeps its ids apart from those of others."""
    with mpl.rc_context(
        {**STYLE, "svg.fonttype": "path", "svg.hashsalt": name, "path.simplify_threshold": 0.3}
    ):
        figure = draw(track)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    text = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{name}_", text[text.index("<svg") :])
    return re.sub(
        r'<svg ([^>]*?)width="[^"]*" ',
        r"<svg \1",
        re.sub(r' height="[^"]*pt"', "", text, count=1),
        count=1,
    )


def _panels(rows: int, columns: int, height: float) -> tuple[Figure, list[list[Axes]]]:
    figure = Figure(figsize=(_WIDTH, 0.5 + height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=False)
    for ax in axes.flat:
        ax.grid(visible=True, color="#e6e6e6", linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        ax.yaxis.set_major_formatter(_THOUSANDS)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    for ax in axes[:-1].flat:
        ax.tick_params(labelbottom=False)
    return figure, [list(row) for row in axes]


def _sizes(track: Track) -> Sizes:
    return sizes_of(track.robot, float(np.ptp(track.time)))


def _line(
    ax: Axes, track: Track, values: FloatArray, colour: str, label: str = "", linewidth: float = 0.9
) -> None:
    """A line, broken at gaps."""
    time, values = _thinned(track.time, values)
    breaks = [end for _, end in track.gaps]
    where = np.searchsorted(time, breaks)
    time, values = (
        np.insert(time, where, np.nan),
        np.insert(values.astype(np.float64), where, np.nan),
    )
    ax.plot(time, values, color=colour, linewidth=linewidth, label=label)
    ax.margins(x=0.01)


def _clip(ax: Axes, track: Track, *parts: FloatArray) -> None:
    """Keep a few wild values from flattening all others: they are marked at the edge, and counted.

    The axis reaches once the range of the middle 98 % beyond it: seven deviations of Gaussian
    noise, and every wave.
    """
    values = np.concatenate([part[np.isfinite(part)] for part in parts])
    if not len(values):
        return
    low, high = np.percentile(values, [1.0, 99.0])
    low, high = low - (high - low), high + (high - low)
    lowest, highest = float(values.min()), float(values.max())
    if not low < high or (low <= lowest and highest <= high):
        return
    ends = _wider(max(low, lowest), min(high, highest))
    ax.set_ylim(*ends)
    beyond = []
    for part in parts:
        for sign, mark, edge in ((-1.0, 6, ends[0]), (1.0, 7, ends[1])):
            rows = np.flatnonzero(sign * part > sign * (low if sign < 0.0 else high))
            (marks,) = ax.plot(
                track.time[rows], np.full(len(rows), edge), linestyle="", marker=mark, **_BEYOND
            )
            marks.set_in_layout(False)
            beyond += part[rows].tolist()
    told = f"{len(beyond)} beyond, to {max(beyond, key=abs):.4g}"
    ax.annotate(told, (0.995, 0.97), xycoords="axes fraction", **_NOTE).set_in_layout(False)


def _thinned(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The least and the largest value of each stretch: peaks stay."""
    size = -(-len(time) // (_MOST // 2))
    if size <= 2:
        return time, values
    count = len(time) // size * size
    table = values[:count].reshape(-1, size)
    filled = np.where(np.isfinite(table), table, table[:, :1])
    ends = np.sort(np.stack([filled.argmin(axis=1), filled.argmax(axis=1)], axis=1), axis=1)
    rows = (ends + size * np.arange(len(ends))[:, None]).ravel()
    return time[rows], values[rows]
