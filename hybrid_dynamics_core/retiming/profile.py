"""The fastest profile of s' under linear constraints: time-optimal by reachability (TOPP-RA).

Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE Transactions on Robotics 34 (2018). With x = s'^2 and u = s'' between two stations,
x grows by 2 u times their distance. Each of the linear programs in x and u is solved exactly, by
elimination of u.
"""

from __future__ import annotations

import numpy as np

from ..ground.arrays import Array
from .constraints import Rows

_ZERO = 1e-14  # coefficients below this do not count
_SLACK = 1e-12  # by which rounding may exceed a row


class BlockedError(ArithmeticError):
    """No profile passes a station."""

    def __init__(self, station: int) -> None:
        """Keep the station."""
        super().__init__(f"no profile passes station {station}")
        self.station = station


def fastest_profile(s: Array, rows: Rows, fastest: Array) -> Array:
    """The fastest squares of s' from rest to rest.

    Each constraint holds at both ends of the stretch between two stations.

    Args:
        s: (N,) parameters of the stations.
        rows: constraints (N, k) there.
        fastest: largest squares (N,) of s'.

    Returns:
        Squares (N,) of s'.

    Raises:
        BlockedError: from some station the end cannot be reached at rest.
    """
    count = len(s)
    steps = np.diff(s)
    # from the end backward: the squares from which the end can be reached at rest
    low, high = np.zeros(count), np.zeros(count)
    stretches: list[Array] = []
    for k in range(count - 2, -1, -1):
        stretch = _stretch(rows, k, steps[k])
        stretches.append(stretch)
        # x + 2 u step, the square at the next station, within its range
        next_in_range = [
            [2.0 * steps[k], 1.0, -high[k + 1]],
            [-2.0 * steps[k], -1.0, low[k + 1]],
        ]
        all_rows = np.vstack([stretch, next_in_range])
        low[k], high[k] = _range_of_x(all_rows, fastest[k])
        if not low[k] <= high[k]:
            raise BlockedError(k)
    if low[0] > 0.0:
        raise BlockedError(0)
    return _forward(steps, stretches[::-1], low, high)


def _forward(steps: Array, stretches: list[Array], low: Array, high: Array) -> Array:
    """The fastest profile (N,) from the start forward.

    Args:
        steps: (N - 1,) distances of the stations.
        stretches: rows of each stretch, as of `_stretch`.
        low: (N,) least square of s' from which the end can be reached.
        high: (N,) largest such square.
    """
    x = np.zeros(len(steps) + 1)
    for k, step in enumerate(steps):
        a, b, c = stretches[k].T
        bounds_u = a > _ZERO
        bounds = -(b * x[k] + c)[bounds_u] / a[bounds_u]
        largest_u = bounds.min(initial=np.inf)
        reached = x[k] + 2.0 * step * largest_u
        x[k + 1] = np.clip(reached, low[k + 1], high[k + 1])
    return x


def _stretch(rows: Rows, k: int, step: float) -> Array:
    """Rows (r, 3) [a, b, c] of u and x at station k that hold at both ends of the stretch after it.

    Those of its end are a u + b (x + 2 u step) + c <= 0.
    """
    here = np.stack([rows.a[k], rows.b[k], rows.c[k]], axis=1)
    ahead = np.stack([rows.a[k + 1], rows.b[k + 1], rows.c[k + 1]], axis=1)
    ahead[:, 0] += 2.0 * step * ahead[:, 1]
    return np.vstack([here, ahead])


def _range_of_x(rows: Array, fastest: float) -> tuple[float, float]:
    """Least and greatest x with some u; the least is above the greatest where there is none.

    Args:
        rows: (k, 3) with a u + b x + c <= 0.
        fastest: largest x.
    """
    a, b, c = rows.T
    above, below = a > _ZERO, a < -_ZERO
    # u <= -(b x + c) / a of one row, and u >= that of another one
    slope_above, offset_above = b[above] / a[above], c[above] / a[above]
    slope_below, offset_below = b[below] / a[below], c[below] / a[below]
    slopes = np.subtract.outer(slope_above, slope_below).ravel()
    offsets = np.subtract.outer(offset_above, offset_below).ravel()
    flat = ~(above | below)
    slopes = np.concatenate([slopes, b[flat]])
    offsets = np.concatenate([offsets, c[flat]])
    rising, falling = slopes > _ZERO, slopes < -_ZERO
    high = np.min(-offsets[rising] / slopes[rising], initial=fastest)
    low = np.max(-offsets[falling] / slopes[falling], initial=0.0)
    level = ~(rising | falling)
    if (offsets[level] > _SLACK * (1.0 + np.abs(offsets[level]))).any():
        return 1.0, 0.0
    if low > high and low - high <= _SLACK * max(fastest, low):
        high = low
    return float(low), float(high)
