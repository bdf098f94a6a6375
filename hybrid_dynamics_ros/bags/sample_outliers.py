"""Samples that do not fit the motion around them: a stamp that is late or early, a reading that jumps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.ndimage import median_filter

from hybrid_dynamics_core.identification import noise_limit, robust_deviation

from ..messages.joint_samples import FloatArray

_DEGREE: Final = 3
_WINDOW: Final = 240  # samples that are looked at together
_LEAST: Final = 24  # samples that tell what noise is
# of the joint between two samples, that a sample is off at least: a spline misses corners by less
_STEPS: Final = 2.0
_NEWTON: Final = 5  # steps along a parabola: more than what is left needs after the third
_LASTS: Final = (
    9  # steps, of which a fast motion makes most: two bad samples side by side make three
)


@dataclass(frozen=True)
class SampleOutlier:
    """A sample off the curve through those around it.

    Attributes:
        stamp_ns: its stamp [ns].
        joint: number of the measured joint that is furthest off.
        rate: whether its velocity is, rather than its position.
        off: by how much [rad or m, or per second].
        late: by how much later than the motion says its stamp is [s]; NaN where the positions give
        no such time.
    """

    stamp_ns: int
    joint: int
    rate: bool
    off: float
    late: float

    def at(self, start_ns: int) -> float:
        """Seconds since some stamp [ns]."""
        return (self.stamp_ns - start_ns) * 1e-9

    def describe(self, joints: Sequence[str], start_ns: int) -> str:
        """A sentence, with the time since some stamp [ns]."""
        unit = "(rad or m)/s" if self.rate else "rad or m"
        late = (
            ""
            if np.isnan(self.late)
            else f", as if its stamp were {1e3 * abs(self.late):.1f} ms {self.word}"
        )
        off = f"{joints[self.joint]} is {abs(self.off):.3g} {unit} off the motion around it"
        return f"{self.at(start_ns):.3f} s: {off}{late}"

    @property
    def word(self) -> str:
        """Which way the stamp is wrong."""
        return "late" if self.late > 0.0 else "early"


def find_outliers(
    stamps: NDArray[np.int64], position: FloatArray, velocity: FloatArray | None
) -> dict[int, SampleOutlier]:
    """The rows of a run that do not fit those around them.

    Such a sample is off the least-squares spline through the others both by more than the largest
    of as much noise as the others have, and by more than two steps of the joint's fast motion from
    one sample to the next.

    Args:
        stamps: (N,) [ns], rising.
        position: (N, n) [rad or m].
        velocity: (N, n) where it was measured.
    """
    found: dict[int, SampleOutlier] = {}
    if len(stamps) < _LEAST:
        return found
    time, n = (stamps - stamps[0]) * 1e-9, position.shape[1]
    parts = [position] if velocity is None else [position, velocity]
    least = _STEPS * np.array([_fast_step(column) for part in parts for column in part.T])
    for window in _windows(len(time)):
        values = np.concatenate([part[window] for part in parts], axis=1)
        for row, column, off in _off(time[window], values, least, len(time) * len(least)):
            whole = row + window.start
            late = _late(time, position, whole, least[:n])
            found[whole] = SampleOutlier(int(stamps[whole]), column % n, column >= n, off, late)
    return found


def _windows(count: int) -> Iterator[slice]:
    """All samples, some at a time; the last ones together with as many before them as make a whole window."""
    starts = range(0, max(count - _LEAST, 1), _WINDOW)
    yield from (slice(start, start + _WINDOW) for start in starts[:-1])
    yield slice(max(min(starts[-1], count - _WINDOW), 0), count)


def _fast_step(values: FloatArray) -> float:
    """The largest step (N,) that lasts: jumps of a few samples do not; infinite where there is none."""
    lasting = float(median_filter(np.abs(np.diff(values)), size=_LASTS).max())
    return lasting if lasting > 0.0 else np.inf


def _off(
    time: FloatArray, values: FloatArray, least: FloatArray, count: int
) -> list[tuple[int, int, float]]:
    """Row, column and by how much; the worst is left out first, as it makes its neighbours look worse."""
    rows, found = np.arange(len(time)), dict[int, tuple[int, float]]()
    while len(rows) >= _LEAST:
        size, without = _sizes(time[rows], values[rows], least, count)
        worst, column = divmod(int(np.argmax(size)), size.shape[1])
        if size[worst, column] <= 1.0:
            break
        found[int(rows[worst])] = column, float(without[worst, column])
        rows = np.delete(rows, worst)
    for row in (
        [*found] if len(found) > 1 else []
    ):  # what only looked bad beside a worse one comes back
        more = np.sort(np.append(rows, row))
        size, _ = _sizes(time[more], values[more], least, count)
        if size[np.searchsorted(more, row)].max() <= 1.0:
            rows = more
            del found[row]
    return [(row, *told) for row, told in found.items()]


def _sizes(
    time: FloatArray, values: FloatArray, least: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """How far off samples are in parts of the `least` that counts, 0 within noise; and off the curve without them."""
    residual, free = _left(time, values)
    without = residual / free[:, None]
    studentised = residual / np.sqrt(free)[:, None]
    limit = noise_limit(count) * robust_deviation(studentised)
    return np.where(np.abs(studentised) > limit, np.abs(without) / least, 0.0), without


def _left(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals (N, k) of a least-squares spline with a knot every four samples, and 1 - leverage of each (N,)."""
    inner = time[4:-4:4]
    knots = np.concatenate([np.full(_DEGREE + 1, time[0]), inner, np.full(_DEGREE + 1, time[-1])])
    basis, _ = np.linalg.qr(BSpline.design_matrix(time, knots, _DEGREE).toarray())
    left = values - basis @ (basis.T @ values)
    return left, np.maximum(1.0 - np.square(basis).sum(axis=1), 1e-9)


def _late(time: FloatArray, positions: FloatArray, row: int, scale: FloatArray) -> float:
    """The time by which the stamp is later than when the joints were where the sample has them."""
    first = min(max(row - 3, 0), len(time) - 7)
    near = [k for k in range(first, first + 7) if k != row]
    weights = 1.0 / np.where(np.isfinite(scale), scale, 1.0)
    curve = np.polyfit(time[near] - time[row], positions[near] * weights, 2)
    late, miss, rate = 0.0, curve[2] - positions[row] * weights, curve[1]
    whole = float(np.linalg.norm(miss))
    for _ in range(_NEWTON):
        speed = float(rate @ rate)
        if not speed > 0.0:
            return float("nan")
        late += float(rate @ miss) / speed
        miss = (curve[0] * -late + curve[1]) * -late + curve[2] - positions[row] * weights
        rate = curve[1] - 2.0 * curve[0] * late
    return late if np.linalg.norm(miss) < 0.3 * whole else float("nan")
