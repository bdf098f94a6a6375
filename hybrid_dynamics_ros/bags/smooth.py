"""Zero-phase smoothing of recordings, for rates without lag.

It needs 150 bytes of memory per sample.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.estimation.splines import spline_derivatives

from ..messages.joint_samples import FloatArray
from ..stream.evaluator import MotionEvaluator
from ..stream.filter.rate_estimator import RateRows
from .sample_outliers import SampleOutlier, find_outliers
from .samples import Samples, slices

_SAVGOL_DEGREE: Final = 4
_LEAST: Final = 12  # least number of samples of a run with rates
_JITTER: Final = 1e-3  # largest deviation of stamps from an even grid, as a share of its step
_BATCH: Final = 2048  # samples closed at once

Rows = NDArray[np.intp]


@dataclass(eq=False)
class SmoothRates(RateRows):
    """Rates of the samples of a recording.

    Attributes:
        outliers: samples that were left out, since they do not fit the motion around them.
    """

    outliers: list[SampleOutlier] = field(default_factory=list)


def estimates_of(samples: Samples, method: str, evaluator: MotionEvaluator) -> SmoothRates:
    """Estimate velocities and accelerations from earlier and later samples.

    Measured velocities are smoothed if there are any, otherwise positions. Outliers are left out
    and have no acceleration.

    Args:
        samples: samples of a whole recording.
        method: "savgol" or "spline".
        evaluator: gives bandwidth and largest gap.
    """
    samples = _continued(samples.calibrated(evaluator.calibration), evaluator)
    count, n = samples.position.shape
    rates = SmoothRates(
        velocity=np.zeros((count, n)),
        has_velocity=np.zeros(count, bool),
        acceleration=np.full((count, n), np.nan),
        has_acceleration=np.zeros(count, bool),
        events=Counter(),
        state=None,
    )
    usable = samples.usable
    rates.has_velocity |= usable & ~np.isnan(samples.velocity).any(axis=1)
    rates.velocity[rates.has_velocity] = samples.velocity[rates.has_velocity]
    usable &= _is_regular(samples, evaluator)
    estimator = evaluator.estimator
    for run in _runs(np.flatnonzero(usable), samples, estimator.max_gap):
        rows = _without_outliers(rates, samples, run)
        if len(rows) >= _LEAST:
            _smooth(rates, samples, rows, method, estimator.bandwidth)
    return rates


def _continued(samples: Samples, evaluator: MotionEvaluator) -> Samples:
    """The samples without jumps of whole turns; values that are not finite are not changed."""
    rows = np.flatnonzero(samples.usable & np.isfinite(samples.position).all(axis=1))
    position = samples.position.copy()
    turned = evaluator.continued(samples.stamp_ns[rows], position[rows], samples.velocity[rows])
    position[rows] = turned.position
    return replace(samples, position=position)


def _without_outliers(rates: SmoothRates, samples: Samples, run: Rows) -> Rows:
    """The rows of a run without outliers, which are added to `rates.outliers`."""
    is_measured = _measured(samples, run)
    velocity = None
    if is_measured.any():  # measured columns are not smoothed, and have no outliers
        velocity = np.where(is_measured, samples.velocity[run], 0.0)
    outliers = find_outliers(samples.stamp_ns[run], samples.position[run], velocity)
    rates.outliers += [outliers[row] for row in sorted(outliers)]
    return np.delete(run, list(outliers))


def _smooth(
    rates: SmoothRates, samples: Samples, rows: Rows, method: str, bandwidth: float
) -> None:
    """Set velocities and accelerations of the rows of a run."""
    stamps = samples.stamp_ns[rows]
    time = (stamps - stamps[0]) * 1e-9
    derivatives = spline_derivatives if method == "spline" else _savgol
    is_measured = _measured(samples, rows)
    for joints, of_samples, orders in (
        (np.flatnonzero(is_measured), samples.velocity, (0, 1)),
        (np.flatnonzero(~is_measured), samples.position, (1, 2)),
    ):
        if len(joints):
            places = np.ix_(rows, joints)
            smoothed = derivatives(time, of_samples[places], bandwidth, orders)
            rates.velocity[places], rates.acceleration[places] = smoothed
    rates.has_velocity[rows] = True
    rates.has_acceleration[rows] = True


def _measured(samples: Samples, rows: Rows) -> NDArray[np.bool_]:
    """Mask (n,) of joints whose velocity is in all of the rows."""
    return np.asarray(np.isfinite(samples.velocity[rows]).all(axis=0))


def _is_regular(samples: Samples, evaluator: MotionEvaluator) -> NDArray[np.bool_]:
    """Mask of samples that are finite, and that close if the active joints are measured.

    Others are left out, since an outlier would distort the rates of its neighbours.
    """
    has_position = np.isfinite(samples.position).all(axis=1)
    regular = np.array(has_position & ~np.isinf(samples.velocity).any(axis=1))
    if not evaluator.is_plain:
        return regular
    rows = np.flatnonzero(regular)
    for part in slices(len(rows), _BATCH):
        batch = rows[part]
        rates = np.nan_to_num(samples.velocity[batch], nan=0.0)
        with np.errstate(all="ignore"):
            state = evaluator.robot.close(samples.position[batch], rates, check=False)
        regular[batch] = np.asarray(state.status) == 0
    return regular


def _runs(rows: Rows, samples: Samples, gap: float) -> Iterator[Rows]:
    """Runs of samples with ascending stamps and without gaps; short runs are left out.

    A run ends if the set of joints with velocities changes for a longer time. Frequent changes, as
    in messages with velocities of alternating joints, do not end it.

    Args:
        rows: rows of usable samples.
        samples: all samples.
        gap: largest time between two stamps of a run [s].
    """
    if not len(rows):
        return
    intervals = np.diff(samples.stamp_ns[rows]) * 1e-9
    is_same_kind = _is_same_kind(np.isfinite(samples.velocity[rows]))
    goes_on = (intervals > 0.0) & (intervals <= gap) & is_same_kind
    for run in np.split(rows, np.flatnonzero(~goes_on) + 1):
        if len(run) >= _LEAST:
            yield run


def _is_same_kind(is_measured: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether each row and the next are smoothed in the same way (N - 1,).

    They have velocities of the same joints, or both are in groups too small for a separate fit.

    Args:
        is_measured: mask (N, n) of joints with velocities in each row.
    """
    is_change = (is_measured[1:] != is_measured[:-1]).any(axis=1)
    edges = np.concatenate([[0], np.flatnonzero(is_change) + 1, [len(is_measured)]])
    lengths = np.diff(edges)
    is_brief = np.repeat(lengths < _LEAST, lengths)
    return np.asarray(~is_change | (is_brief[1:] & is_brief[:-1]))


def _savgol(
    time: FloatArray, values: FloatArray, bandwidth: float, orders: tuple[int, int]
) -> tuple[FloatArray, ...]:
    """Derivatives by a Savitzky-Golay filter on an even grid of times.

    If stamps jitter, values are interpolated to the grid, and derivatives back to the stamps.
    Arguments are those of `spline_derivatives`.
    """
    from scipy.signal import savgol_filter  # noqa: PLC0415  slow to import

    median = float(np.median(np.diff(time)))
    count = max(round((time[-1] - time[0]) / median) + 1, _LEAST)
    grid = np.linspace(time[0], time[-1], count)
    step = float(grid[1] - grid[0])
    is_even = len(time) == count and bool(np.abs(time - grid).max() < _JITTER * step)
    if not is_even:
        values = _interpolated(grid, time, values)
    # odd numbers of samples: one period of the bandwidth, all, and the least for the degree
    period = 2 * round(1.0 / (2.0 * bandwidth * step)) + 1
    longest = 2 * ((count - 1) // 2) + 1
    shortest = _SAVGOL_DEGREE + 1 + _SAVGOL_DEGREE % 2
    window = max(min(period, longest), shortest)
    derivatives = []
    for order in orders:
        part = savgol_filter(values, window, _SAVGOL_DEGREE, deriv=order, delta=step, axis=0)
        derivatives.append(part if is_even else _interpolated(time, grid, part))
    return tuple(derivatives)


def _interpolated(at: FloatArray, time: FloatArray, values: FloatArray) -> FloatArray:
    """Linear interpolation of values (N, n) at times (N,) to other times (K,)."""
    columns = [np.interp(at, time, column) for column in values.T]
    return np.stack(columns, axis=-1)
