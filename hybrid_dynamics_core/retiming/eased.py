"""A timed motion with ramps in place of the jumps of its acceleration.

Controllers join points of a trajectory by quintic polynomials. These swing beyond both sides of a
jump, so that limits would be exceeded. A ramp is such a polynomial itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from .constraints import Constraints
from .curve import Curve
from .motion import MotionPoint, TimedMotion, along

_SHORTEST = 2.0  # ramps, between stations that are kept
_PIECES = 8  # of a ramp or a stretch, at whose ends limits are checked
_RESERVE = 1e-6  # share of a limit that is kept free, against rounding
_MOST_BULGE = 1e-3  # share of a limit that is kept free about a jump of pressures
_MOST_SLOWED = 0.02  # of s'^2 at once
_SLOWDOWNS = 100


@dataclass(frozen=True, eq=False)
class EasedMotion:
    """A motion along a path; between two of its times s'' is linear, and it has no jumps.

    Attributes:
        curve: the path.
        times: (M,) starts of ramps and of stretches of constant s'', and the end [s].
        s: (M,) parameters there.
        ds: (M,) s' there [1/s].
        dds: (M,) s'' there [1/s^2].
    """

    curve: Curve
    times: Array
    s: Array
    ds: Array
    dds: Array

    @property
    def duration(self) -> float:
        """[s]."""
        return float(self.times[-1])

    def __call__(self, t: ArrayLike) -> MotionPoint:
        """The motion at a time [s] or at times (N,), between its start and its end."""
        return along(self.curve, *self.profile(real_array("t", t)))

    def profile(self, t: Array) -> tuple[Array, Array, Array]:
        """Values of s, s' [1/s] and s'' [1/s^2] at times (N,) [s], or at one."""
        within = np.clip(t, 0.0, self.duration)
        last = len(self.times) - 2
        following = np.searchsorted(self.times, within, side="right")
        k = np.clip(following - 1, 0, last)
        jerks = np.diff(self.dds) / np.diff(self.times)
        jerk = jerks[k]
        tau = within - self.times[k]
        start = self.dds[k]
        dds = start + jerk * tau
        gained = start * tau + jerk * tau**2 / 2.0
        ds = self.ds[k] + gained
        way = start * tau**2 / 2.0 + jerk * tau**3 / 6.0
        s = self.s[k] + self.ds[k] * tau + way
        return s, np.maximum(ds, 0.0), dds

    def slower(self, factor: float) -> EasedMotion:
        """The same path, with every s'^2 times a factor."""
        rate = np.sqrt(factor)
        return replace(
            self,
            times=self.times / rate,
            ds=rate * self.ds,
            dds=factor * self.dds,
        )


def eased(motion: TimedMotion, constraints: Constraints, ramp: float) -> EasedMotion:
    """The motion with ramps of s'' about its stations, slowed until it keeps all limits.

    About a station s' is the moving average over a ramp. So rates stay within those of the motion,
    and s'' between those on both sides.

    Args:
        motion: the motion.
        constraints: the limits along its path.
        ramp: time of a ramp [s]. Stations that are closer than two ramps are joined.

    Raises:
        InputError: the motion cannot be slowed enough.
    """
    gentle = _with_ramps(motion, ramp)
    for _ in range(_SLOWDOWNS):
        excess = _excess(gentle, constraints)
        if excess <= 0.0:
            return gentle
        gentle = gentle.slower(1.0 - min(4.0 * excess + _RESERVE, _MOST_SLOWED))
    raise InputError("no motion along the path keeps all limits, however slow")


def _with_ramps(motion: TimedMotion, ramp: float) -> EasedMotion:
    stations = _apart(motion.times, _SHORTEST * ramp)
    stops = motion.times[stations]
    rates = np.sqrt(motion.x[stations])
    accelerations = np.diff(rates) / np.diff(stops)
    dds = np.repeat(accelerations, 2)
    times = _knots(stops, ramp)
    steps = np.diff(times)
    means = 0.5 * (dds[:-1] + dds[1:])
    ds = _sums(steps * means)
    leans = (2.0 * dds[:-1] + dds[1:]) / 6.0
    s = _sums(steps * ds[:-1] + steps**2 * leans)
    ds[-1] = 0.0
    # ramps and joined stations miss the end by a millionth or so
    scale = motion.curve.end / s[-1]
    return EasedMotion(
        motion.curve,
        times,
        scale * s,
        scale * ds,
        scale * dds,
    )


def _knots(stops: Array, ramp: float) -> Array:
    """Starts and ends of ramps about all stops but the first and the last, and these two."""
    inner = stops[1:-1]
    starts = inner - 0.5 * ramp
    ends = inner + 0.5 * ramp
    ramps = np.stack([starts, ends], axis=1)
    return np.concatenate([stops[:1], ramps.ravel(), stops[-1:]])


def _sums(parts: Array) -> Array:
    """Sums (M + 1,) of the parts (M,) before each place."""
    return np.append(0.0, np.cumsum(parts))


def _apart(times: Array, least: float) -> list[int]:
    """Indices of times (N,) that are at least so far apart, with the first and the last."""
    kept = [0]
    last = len(times) - 1
    latest = times[last] - least
    for k in range(1, last):
        earliest = times[kept[-1]] + least
        if earliest <= times[k] <= latest:
            kept.append(k)
    kept.append(last)
    return kept


def _excess(motion: EasedMotion, constraints: Constraints) -> float:
    """The largest excess over a limit, as a share of it; negative within limits."""
    s, ds, dds = motion.profile(_dense(motion.times))
    squares = ds**2
    forces = constraints.residuals(s, squares, dds)
    # minus infinity where nothing limits
    forces = np.maximum(forces, -1.0)
    speeds = constraints.speed_ratio(s, squares) - constraints.share
    values = np.column_stack([forces, speeds])
    # between two places a curve is above its chord by an eighth of the second difference
    second_differences = np.abs(np.diff(values, n=2, axis=0))
    bulges = np.minimum(second_differences / 8.0, _MOST_BULGE)
    ends = values[[0, -1]].max()
    inside = (values[1:-1] + bulges).max()
    return float(max(ends, inside)) + _RESERVE


def _dense(times: Array) -> Array:
    """The times (M,), with others between each two."""
    last = len(times) - 1
    numbers = np.linspace(0, last, _PIECES * last + 1)
    return np.interp(numbers, np.arange(len(times)), times)
