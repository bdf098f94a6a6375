"""Rates that may look ahead: zero-phase smoothing of whole recordings, which takes 150 bytes of memory a sample."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_lsq_spline
from scipy.signal import savgol_filter

from ..messages.joint_samples import FloatArray
from ..stream.evaluator import MotionEvaluator
from ..stream.filter.rate_estimator import RateRows
from .decode import Samples
from .sample_outliers import SampleOutlier, find_outliers

_DEGREE = 5  # of the spline: accelerations are cubic
_ORDER = 4  # of Savitzky-Golay polynomials
_LEAST = 12  # samples between two gaps
_AT_ONCE = 2048  # samples that are closed together


@dataclass(eq=False)
class SmoothRates(RateRows):
    """Rates of the samples of a recording.

    Attributes:
        outliers: samples that rates were not made of, as they do not fit the motion around them.
    """

    outliers: list[SampleOutlier] = field(default_factory=list)


def joined(parts: Sequence[Samples]) -> Samples:
    """One table of many."""
    starts = np.cumsum([0, *(len(part) for part in parts[:-1])]).tolist()
    placed = list(zip(starts, parts, strict=True))
    return Samples(
        log_ns=np.concatenate([part.log_ns for part in parts]),
        stamp_ns=np.concatenate([part.stamp_ns for part in parts]),
        position=np.concatenate([part.position for part in parts]),
        velocity=np.concatenate([part.velocity for part in parts]),
        measured=np.concatenate([part.measured for part in parts]),
        effort=np.concatenate([part.effort for part in parts]),
        rejected={start + row: why for start, part in placed for row, why in part.rejected.items()},
        broken={start + row: why for start, part in placed for row, why in part.broken.items()},
    )


def split(count: int, size: int) -> Iterator[slice]:
    """Slices of at most `size`."""
    return (slice(start, min(start + size, count)) for start in range(0, count, size))


def estimates_of(samples: Samples, method: str, evaluator: MotionEvaluator) -> SmoothRates:
    """Velocities and accelerations of all samples from those before and after.

    Velocities that were measured are smoothed as they are; where there are none, positions are.
    Samples that do not fit the motion around them are left out, have no acceleration, and are told
    in `SmoothRates.outliers`.

    Args:
        samples: of a whole recording.
        method: "savgol" or "spline".
        evaluator: its bandwidth and largest gap count here too.
    """
    count, n = samples.position.shape
    samples = samples.calibrated(evaluator.calibration)
    position, velocity = samples.position, samples.velocity
    rates = SmoothRates(
        velocity=np.zeros((count, n)),
        has_velocity=samples.measured.copy(),
        acceleration=np.full((count, n), np.nan),
        has_acceleration=np.zeros(count, bool),
        events=Counter(),
        state=None,
    )
    usable = samples.usable
    rates.velocity[usable] = np.where(samples.measured[usable, None], velocity[usable], 0.0)
    usable &= _sound(samples, evaluator)
    estimator = evaluator.estimator
    for run in _runs(np.flatnonzero(usable), samples, estimator.max_gap):
        measured = bool(samples.measured[run[0]])
        measured_rates = velocity[run] if measured else None
        outliers = find_outliers(samples.stamp_ns[run], position[run], measured_rates)
        rates.outliers += [outliers[row] for row in sorted(outliers)]
        rows = np.delete(run, list(outliers))
        if len(rows) < _LEAST:
            continue
        time = (samples.stamp_ns[rows] - samples.stamp_ns[rows[0]]) * 1e-9
        first, second = (1, 2) if not measured else (0, 1)
        values = (velocity if measured else position)[rows]
        fit = _spline if method == "spline" else _savgol
        velocities, accelerations = fit(time, values, estimator.bandwidth, (first, second))
        rates.velocity[rows], rates.acceleration[rows] = velocities, accelerations
        rates.has_velocity[rows] = rates.has_acceleration[rows] = True
    return rates


def _sound(samples: Samples, evaluator: MotionEvaluator) -> NDArray[np.bool_]:
    """Which samples the model can take: others, such as one beyond all numbers, spoil the rates of their neighbours."""
    sound = np.isfinite(samples.position).all(axis=1) & (
        np.isfinite(samples.velocity).all(axis=1) | ~samples.measured
    )
    if not evaluator.is_plain:
        return sound
    rows = np.flatnonzero(sound)
    for part in split(len(rows), _AT_ONCE):
        some = rows[part]
        rates = np.where(samples.measured[some, None], samples.velocity[some], 0.0)
        with np.errstate(all="ignore"):
            state = evaluator.robot.close(samples.position[some], rates, check=False)
        sound[some] = np.asarray(state.status) == 0
    return sound


def _runs(rows: NDArray[np.intp], samples: Samples, gap: float) -> Iterator[NDArray[np.intp]]:
    """Samples that follow each other with rising stamps, without a gap, of one kind; one of each stamp."""
    if not len(rows):
        return
    dt = np.diff(samples.stamp_ns[rows]) * 1e-9
    same = np.diff(samples.measured[rows].astype(np.int8)) == 0
    edges = np.flatnonzero(~((dt > 0.0) & (dt <= gap) & same)) + 1
    for run in np.split(rows, edges):
        if len(run) >= _LEAST:
            yield run


def _spline(
    time: FloatArray, values: FloatArray, bandwidth: float, orders: tuple[int, int]
) -> tuple[FloatArray, ...]:
    """Least-squares spline with knots as dense as the bandwidth asks for."""
    spacing = max(1.0 / (4.0 * bandwidth), 3.0 * float(np.median(np.diff(time))))
    inner = np.linspace(time[0], time[-1], max(int((time[-1] - time[0]) / spacing), 1) + 1)[1:-1]
    held = np.histogram(time, np.concatenate([[time[0]], inner, [time[-1]]]))[0]
    inner = inner[
        (held[:-1] > 1) & (held[1:] > 1)
    ]  # an interval without samples determines nothing
    knots = np.concatenate([np.full(_DEGREE + 1, time[0]), inner, np.full(_DEGREE + 1, time[-1])])
    spline = make_lsq_spline(time, values, knots, k=_DEGREE)
    return tuple(
        np.asarray(spline.derivative(order)(time) if order else spline(time)) for order in orders
    )


def _savgol(
    time: FloatArray, values: FloatArray, bandwidth: float, orders: tuple[int, int]
) -> tuple[FloatArray, ...]:
    """Savitzky-Golay on an even grid; stamps that jitter are brought onto it and back by interpolation."""
    step = float(np.median(np.diff(time)))
    count = max(round((time[-1] - time[0]) / step) + 1, _LEAST)
    grid = np.linspace(time[0], time[-1], count)
    step = float(grid[1] - grid[0])
    even = len(time) == count and bool(np.abs(time - grid).max() < 1e-3 * step)
    window = min(2 * round(1.0 / (2.0 * bandwidth * step)) + 1, 2 * ((count - 1) // 2) + 1)
    window = max(window, _ORDER + 1 + _ORDER % 2)
    on_grid = values if even else _interpolated(grid, time, values)
    found = [
        savgol_filter(on_grid, window, _ORDER, deriv=order, delta=step, axis=0) for order in orders
    ]
    return tuple(np.asarray(part if even else _interpolated(time, grid, part)) for part in found)


def _interpolated(at: FloatArray, time: FloatArray, values: FloatArray) -> FloatArray:
    return np.stack([np.interp(at, time, column) for column in values.T], axis=-1)
