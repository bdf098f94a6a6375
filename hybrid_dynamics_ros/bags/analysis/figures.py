"""The figures of a report."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hybrid_dynamics_core.drawing.plots.rounding import suppress_rounding
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.scene.style import BLUE, GREEN, INK, ORANGE, PURPLE, QUIET, RED

from ...messages.joint_samples import FloatArray
from .plotting import (
    LEGEND_ABOVE,
    clip_outliers,
    colour_of,
    draw_line,
    make_panels,
    natural_sizes,
    widen,
)
from .recording import EvaluatedRecording
from .stamp_intervals import StampIntervals

_MIN_RESIDUAL: Final = 1e-17  # replaces a residual of zero on the logarithmic axis
_MIN_RESIDUAL_RANGE: Final = 1e-11  # least upper end of that axis
_NEAR_SINGULARITY: Final = 0.1
_RECORDED: Final = "#b4bac2"
_BINS: Final = 61  # odd, so that one bin is centred on the nominal interval
_DASHED: Final[dict[str, Any]] = {"color": QUIET, "linewidth": 0.8, "linestyle": "--"}
_MARK: Final[dict[str, Any]] = {"markersize": 16, "markeredgewidth": 1.6}


def trajectories(recording: EvaluatedRecording) -> Figure:
    """Position and velocity of each active joint, one row each."""
    robot, state = recording.robot, recording.state
    figure, axes = make_panels(len(robot.active), 2, 1.7)
    sizes = natural_sizes(recording)
    for k, name in enumerate(robot.active):
        kind = robot.joint_types[name]
        position_ax, velocity_ax = axes[k]
        draw_line(position_ax, recording, state.u[:, k], colour_of(k))
        suppress_rounding(position_ax, sizes.position(kind))
        position_ax.set_ylabel(f"{name} [{coordinate_unit(kind)}]")
        draw_line(velocity_ax, recording, state.du[:, k], colour_of(k))
        suppress_rounding(velocity_ax, sizes.rate(kind))
        velocity_ax.set_ylabel(f"{name} [{coordinate_unit(kind, '/s')}]")
    axes[0][0].set_title("position")
    axes[0][1].set_title("velocity")
    return figure


def efforts(recording: EvaluatedRecording) -> Figure:
    """Recorded and computed efforts, and their difference."""
    names = recording.robot.active
    has_recorded = bool(np.isfinite(recording.recorded).any())
    columns = 2 if has_recorded else 1
    figure, axes = make_panels(len(names), columns, 1.9)
    sizes = natural_sizes(recording)
    for k, name in enumerate(names):
        kind = recording.robot.joint_types[name]
        label = f"{name} [{effort_unit(kind)}]"
        size = sizes.effort(kind)
        recorded, computed = recording.recorded[:, k], recording.efforts[:, k]
        ax = axes[k][0]
        if has_recorded:
            draw_line(ax, recording, recorded, _RECORDED, label="recorded", linewidth=1.8)
        draw_line(ax, recording, computed, colour_of(k), label="computed")
        if not suppress_rounding(ax, size):
            clip_outliers(ax, recording, computed, recorded)
        ax.set_ylabel(label)
        if has_recorded:
            _draw_difference(axes[k][1], recording, k, size)
            axes[k][1].set_ylabel(label)
    axes[0][0].legend(**LEGEND_ABOVE, ncols=2)
    axes[0][0].set_title("efforts")
    if has_recorded:
        axes[0][1].set_title("recorded less computed")
    return figure


def _draw_difference(ax: Axes, recording: EvaluatedRecording, k: int, size: float) -> None:
    """Draw recorded minus computed efforts of a joint; `size` is the natural size of efforts."""
    difference = recording.recorded[:, k] - recording.efforts[:, k]
    draw_line(ax, recording, difference, colour_of(k))
    if not suppress_rounding(ax, size):
        clip_outliers(ax, recording, difference)
    ax.axhline(0.0, color=QUIET, linewidth=0.6)


def energy(recording: EvaluatedRecording) -> Figure:
    """Energy and power of the actuators."""
    figure, axes = make_panels(2, 1, 2.2)
    energy_ax, power_ax = axes[0][0], axes[1][0]
    sizes = natural_sizes(recording)
    kinetic, potential = recording.energy
    raised = potential - potential[0]
    total = kinetic + potential - kinetic[0] - potential[0]
    label = "of gravity and springs, since the start"
    draw_line(energy_ax, recording, kinetic, BLUE, label="of motion")
    draw_line(energy_ax, recording, raised, GREEN, label=label)
    draw_line(energy_ax, recording, total, QUIET, label="both, since the start")
    energy_ax.set_ylabel("energy [J]")
    energy_ax.legend(**LEGEND_ABOVE, ncols=3)
    suppress_rounding(energy_ax, sizes.energy)
    for k, name in enumerate(recording.robot.active):
        power = recording.efforts[:, k] * recording.state.du[:, k]
        draw_line(power_ax, recording, power, colour_of(k), label=name)
    draw_line(power_ax, recording, recording.power, INK, label="sum")
    power_ax.set_ylabel("power [W]")
    power_ax.legend(**LEGEND_ABOVE, ncols=8)
    suppress_rounding(power_ax, sizes.energy / sizes.time)
    return figure


def closure(recording: EvaluatedRecording) -> Figure:
    """Residual of the loops, and distance of each loop to a singularity."""
    figure, axes = make_panels(2, 1, 2.2)
    residual_ax, distance_ax = axes[0][0], axes[1][0]
    state = recording.state
    residual = np.maximum(np.asarray(state.residual), _MIN_RESIDUAL)
    draw_line(residual_ax, recording, residual, BLUE)
    residual_ax.set_yscale("log")
    top = max(_MIN_RESIDUAL_RANGE, 10.0 * float(np.max(state.residual)))
    residual_ax.set_ylim(_MIN_RESIDUAL, top)
    residual_ax.set_ylabel("largest residual [1]")
    for k, loop in enumerate(recording.robot.loops):
        draw_line(distance_ax, recording, state.distances[:, k], colour_of(k), label=loop)
    distance_ax.set_ylim(0.0, 1.05)
    distance_ax.axhline(_NEAR_SINGULARITY, label=f"near: {_NEAR_SINGULARITY:g}", **_DASHED)
    distance_ax.set_ylabel("distance to a\nsingularity [1]")
    distance_ax.legend(**LEGEND_ABOVE, ncols=6)
    return figure


def margins(recording: EvaluatedRecording) -> Figure:
    """Margins of each joint to the nearer end of its range."""
    names, values = recording.margins
    sizes = natural_sizes(recording)
    figure, axes = make_panels(max(len(names), 1), 1, 1.5)
    for k, name in enumerate(names):
        kind = recording.robot.joint_types[name]
        margin = values[:, k]
        ax = axes[k][0]
        draw_line(ax, recording, margin, colour_of(k))
        ax.axhline(0.0, color=RED, linewidth=0.8)
        low = min(0.0, float(margin.min()))
        high = max(0.0, float(margin.max()))
        room = 0.08 * (high - low) + 1e-9
        ax.set_ylim(low - room, high + room)  # keeps the line at 0 away from the axis
        suppress_rounding(ax, sizes.position(kind))
        ax.set_ylabel(f"{name} [{coordinate_unit(kind)}]")
    return figure


class _Row(NamedTuple):
    """A row of marks: times [s], and the number of samples that they stand for."""

    label: str
    colour: str
    times: list[float]
    sample_count: int


def sampling(recording: EvaluatedRecording) -> Figure:
    """Intervals between stamps, and times of missing, outlying or refused samples."""
    stamps = recording.stamps
    faults = (stamps.missing, recording.gaps, recording.outliers, recording.refused)
    if not any(faults):
        figure, axes = make_panels(1, 1, 2.4)
        summary = _draw_intervals(axes[0][0], stamps)
        axes[0][0].set_title(f"{summary}; no gaps, none missing or bad")
        return figure
    figure, axes = make_panels(1, 2, 2.4)
    axes[0][0].set_title(_draw_intervals(axes[0][0], stamps))
    _draw_faults(axes[0][1], recording)
    return figure


def _draw_faults(ax: Axes, recording: EvaluatedRecording) -> None:
    """Draw gaps, and missing, outlying or refused samples, over time."""
    for start, end in recording.gaps:
        first, last = sorted((start, end))
        ax.axvspan(first, last, color=ORANGE, alpha=0.5, linewidth=1.0)
    rows = _fault_rows(recording)
    heights = [2.0 - k for k in range(len(rows))]
    for row, height in zip(rows, heights, strict=True):
        heights_of_row = [height] * len(row.times)
        ax.plot(row.times, heights_of_row, "|", color=row.colour, **_MARK)
    begin, end = float(recording.time.min()), float(recording.time.max())
    ax.set_xlim(*widen(begin, end))
    ax.set_ylim(2.4 - len(rows), 2.6)
    ax.set_yticks(heights, [f"{row.label}: {row.sample_count}" for row in rows])
    ax.set_title(f"samples; gaps, shaded: {len(recording.gaps)}")
    ax.set_xlabel("time [s]")


def _fault_rows(recording: EvaluatedRecording) -> list[_Row]:
    stamps = recording.stamps
    begins = [interval.begin for interval in stamps.missing]
    rows = [_Row("missing", ORANGE, begins, stamps.missing_count)]
    if not recording.is_causal:
        times = [outlier.at(recording.start_ns) for outlier in recording.outliers]
        rows.append(_Row("off the motion", PURPLE, times, len(times)))
    times = [time for time, _ in recording.refused]
    rows.append(_Row("refused", RED, times, len(times)))
    return rows


def _draw_intervals(ax: Axes, stamps: StampIntervals) -> str:
    """Draw a histogram of intervals; returns a text on those out of its range."""
    intervals = stamps.intervals * 1e3
    ax.set_xlabel("between stamps [ms]")
    ax.set_ylabel("intervals")
    if not len(intervals):
        return "no intervals"
    low, high = _usual_range(intervals, stamps.nominal * 1e3)
    inside = intervals[(intervals >= low) & (intervals <= high)]
    ax.hist(inside, bins=_BINS, range=(low, high), color=BLUE)
    ax.set_xlim(low, high)
    counts = f"{len(intervals)} intervals"
    if len(inside) < len(intervals):
        counts = f"{len(inside)} of {counts}"
    words = [counts]
    shorter, longer = intervals < low, intervals > high
    if shorter.any():
        words.append(f"{shorter.sum()} shorter, from {intervals.min():.4g} ms")
    if longer.any():
        words.append(f"{longer.sum()} longer, to {intervals.max():.4g} ms")
    return "; ".join(words)


def _usual_range(intervals: FloatArray, nominal: float) -> tuple[float, float]:
    """A range that contains 99 % of the intervals, with a margin [ms]."""
    low, high = np.percentile(intervals, [0.5, 99.5])
    span = max(high - low, 0.1 * nominal, 1e-6)
    return low - 0.2 * span, high + 0.2 * span
