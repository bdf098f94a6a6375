"""Outlier detection in samples: wrong stamps, and readings that jump."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.identification import noise_limit, robust_deviation

from ..messages.joint_samples import FloatArray

_DEGREE: Final = 3  # degree of the spline
_KNOT_SPACING: Final = 4  # [samples]
_WINDOW: Final = 240  # [samples] fitted by one spline
_MIN_SAMPLES: Final = 24  # least number for an estimate of noise
# Least deviation of an outlier, in steps of the joint between two samples. Corners of a motion
# deviate less from a spline.
_MIN_STEPS: Final = 2.0
# Number of consecutive steps of a fast motion. Two adjacent outliers make three.
_LASTING: Final = 9
_NEIGHBOURS: Final = 7  # samples around an outlier, including itself, for a parabola
_NEWTON_STEPS: Final = 5  # along the parabola; three are enough
_MAX_MISS: Final = 0.3  # largest share of the deviation that a wrong stamp leaves unexplained
_MIN_FREEDOM: Final = 1e-9  # least 1 - leverage
_NAN: Final = float("nan")

Deviations = dict[int, tuple[int, float]]  # (column, deviation) by row


@dataclass(frozen=True)
class SampleOutlier:
    """A sample that deviates from the curve through its neighbours.

    Attributes:
        stamp_ns: its stamp [ns].
        joint: index of the measured joint with the largest deviation.
        rate: whether its velocity deviates, not its position.
        off: deviation [rad or m, or per second].
        late: delay of its stamp relative to the motion [s]; NaN if no delay explains the positions.
    """

    stamp_ns: int
    joint: int
    rate: bool
    off: float
    late: float

    def at(self, start_ns: int) -> float:
        """Time since a stamp [s]; `start_ns` is the stamp [ns]."""
        return (self.stamp_ns - start_ns) * 1e-9

    def describe(self, joints: Sequence[str], start_ns: int) -> str:
        """A sentence with the time since a stamp `start_ns` [ns]."""
        unit = "(rad or m)/s" if self.rate else "rad or m"
        joint = joints[self.joint]
        text = f"{self.at(start_ns):.3f} s: {joint} is {abs(self.off):.3g} {unit} off the motion"
        text += " around it"
        if not np.isnan(self.late):
            text += f", as if its stamp were {1e3 * abs(self.late):.1f} ms {self.word}"
        return text

    @property
    def word(self) -> str:
        """Direction of the stamp's error: `late` or `early`."""
        return "late" if self.late > 0.0 else "early"


def find_outliers(
    stamps: NDArray[np.int64], position: FloatArray, velocity: FloatArray | None
) -> dict[int, SampleOutlier]:
    """Find the outliers of a run.

    An outlier deviates from the least-squares spline through the other samples. Its deviation is
    larger than the expected maximum of the noise, and than two steps of the joint's fast motion
    between samples.

    Args:
        stamps: (N,) [ns], ascending.
        position: (N, n) [rad or m].
        velocity: (N, n) [rad/s or m/s], NaN where it was not measured.
    """
    outliers: dict[int, SampleOutlier] = {}
    if len(stamps) < _MIN_SAMPLES:
        return outliers
    time = (stamps - stamps[0]) * 1e-9
    n = position.shape[1]
    parts = [position]
    if velocity is not None:
        parts.append(velocity)
    scale = _MIN_STEPS * np.concatenate([_fast_steps(part) for part in parts])
    for window in _windows(len(time)):
        values = np.concatenate([part[window] for part in parts], axis=1)
        search = _WindowSearch(time[window], values, scale, len(time) * len(scale))
        for row, column, off in search.outliers():
            place = row + window.start
            late = _lateness(time, position, place, scale[:n])
            stamp = int(stamps[place])
            outliers[place] = SampleOutlier(stamp, column % n, column >= n, off, late)
    return outliers


def _windows(count: int) -> Iterator[slice]:
    """Windows over all samples.

    The last window overlaps the previous one, so that all are full.
    """
    starts = range(0, max(count - _MIN_SAMPLES, 1), _WINDOW)
    for start in starts[:-1]:
        yield slice(start, start + _WINDOW)
    last = min(starts[-1], count - _WINDOW)
    yield slice(max(last, 0), count)


def _fast_steps(values: FloatArray) -> FloatArray:
    """The largest sustained step of each column (n,) of (N, n); infinite if there is none.

    Jumps of a few samples are ignored.
    """
    from scipy.ndimage import median_filter  # noqa: PLC0415  slow to import

    steps = np.empty(values.shape[1])
    for k, column in enumerate(values.T):
        sizes = np.abs(np.diff(column))
        steps[k] = median_filter(sizes, size=_LASTING).max()
    return np.where(steps > 0.0, steps, np.inf)


class _WindowSearch:
    """Search for outliers in one window."""

    def __init__(
        self, time: FloatArray, values: FloatArray, scale: FloatArray, value_count: int
    ) -> None:
        """Store the samples.

        Args:
            time: (N,) [s].
            values: (N, k).
            scale: (k,) least deviation of an outlier.
            value_count: number of values of the recording, for the expected maximum of noise.
        """
        self._time = time
        self._values = values
        self._scale = scale
        self._limit = noise_limit(value_count)

    def outliers(self) -> list[tuple[int, int, float]]:
        """Row, column and deviation of each outlier.

        The largest is removed first, since it distorts the residuals of its neighbours.
        """
        rows = np.arange(len(self._time))
        outliers: Deviations = {}
        while len(rows) >= _MIN_SAMPLES:
            size, off = self._sizes(rows)
            worst, column = divmod(int(np.argmax(size)), size.shape[1])
            if size[worst, column] <= 1.0:
                break
            outliers[int(rows[worst])] = (column, float(off[worst, column]))
            rows = np.delete(rows, worst)
        if len(outliers) > 1:
            self._restore(rows, outliers)
        return [(row, column, off) for row, (column, off) in outliers.items()]

    def _restore(self, rows: NDArray[np.intp], outliers: Deviations) -> None:
        """Restore samples that were only distorted by a larger outlier."""
        for row in list(outliers):
            extended = np.sort(np.append(rows, row))
            size, _ = self._sizes(extended)
            if size[np.searchsorted(extended, row)].max() <= 1.0:
                rows = extended
                del outliers[row]

    def _sizes(self, rows: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        """Deviations of samples over the scale, and deviations, (N, k) each.

        The first are 0 within noise. Each sample is compared with the curve through the others.
        """
        residual, freedom = _fit_spline(self._time[rows], self._values[rows])
        off = residual / freedom[:, None]
        studentised = residual / np.sqrt(freedom)[:, None]
        limit = self._limit * robust_deviation(studentised)
        is_beyond = np.abs(studentised) > limit
        return np.where(is_beyond, np.abs(off) / self._scale, 0.0), off


def _fit_spline(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals (N, k) of a least-squares spline, and 1 - leverage of each sample (N,)."""
    from scipy.interpolate import BSpline  # noqa: PLC0415  slow to import

    inner = time[_KNOT_SPACING:-_KNOT_SPACING:_KNOT_SPACING]
    begin = np.full(_DEGREE + 1, time[0])
    end = np.full(_DEGREE + 1, time[-1])
    knots = np.concatenate([begin, inner, end])
    basis, _ = np.linalg.qr(BSpline.design_matrix(time, knots, _DEGREE).toarray())
    residual = values - basis @ (basis.T @ values)
    freedom = 1.0 - np.square(basis).sum(axis=1)
    return residual, np.maximum(freedom, _MIN_FREEDOM)


def _lateness(time: FloatArray, positions: FloatArray, row: int, scale: FloatArray) -> float:
    """Delay of a stamp relative to the time at which the joints had the sample's positions [s].

    NaN if no time explains the positions. Newton's method finds the nearest point on a parabola
    through the neighbours.
    """
    first = min(max(row - _NEIGHBOURS // 2, 0), len(time) - _NEIGHBOURS)
    neighbours = [k for k in range(first, first + _NEIGHBOURS) if k != row]
    weights = 1.0 / np.where(np.isfinite(scale), scale, 1.0)
    target = positions[row] * weights
    curve = np.polyfit(time[neighbours] - time[row], positions[neighbours] * weights, 2)
    late = 0.0
    miss = curve[2] - target
    rate = curve[1]
    distance = float(np.linalg.norm(miss))
    for _ in range(_NEWTON_STEPS):
        speed_squared = float(rate @ rate)
        if not speed_squared > 0.0:
            return _NAN
        late += float(rate @ miss) / speed_squared
        miss = (curve[0] * -late + curve[1]) * -late + curve[2] - target
        rate = curve[1] - 2.0 * curve[0] * late
    if np.linalg.norm(miss) < _MAX_MISS * distance:
        return late
    return _NAN
