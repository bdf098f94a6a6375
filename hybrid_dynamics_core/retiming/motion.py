"""A path with the times at which it is passed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from ..limits import LimitMargins
from .curve import Curve


class MotionPoint(NamedTuple):
    """Motion of the active joints at a time, (n,) each, or at times, (N, n) each.

    Attributes:
        u: coordinates [rad or m].
        du: rates [rad/s or m/s].
        ddu: accelerations [rad/s^2 or m/s^2].
    """

    u: Array
    du: Array
    ddu: Array


@dataclass(frozen=True, eq=False)
class TimedMotion:
    """A motion along a path; between two stations s'' is constant.

    Attributes:
        curve: the path.
        s: (N,) parameters of the stations.
        x: (N,) squares of s' there [1/s^2].
        times: (N,) [s], from zero.
        margins: margins on a fine grid between all stations.
        limited_by: (name, kind) of the quantities that are at a limit somewhere.
    """

    curve: Curve
    s: Array
    x: Array
    times: Array
    margins: LimitMargins
    limited_by: tuple[tuple[str, str], ...]

    @property
    def duration(self) -> float:
        """How long it takes [s]."""
        return float(self.times[-1])

    def __call__(self, t: ArrayLike) -> MotionPoint:
        """The motion at a time [s] or at times (N,); at rest before its start and after its end."""
        t = real_array("t", t)
        within = np.clip(t, 0.0, self.duration)
        following = np.searchsorted(self.times, within, side="right")
        last = len(self.s) - 2
        k = np.clip(following - 1, 0, last)
        rate = np.sqrt(self.x)
        tau = within - self.times[k]
        acceleration = accelerations(self.s, self.x)[k]
        s = self.s[k] + rate[k] * tau + 0.5 * acceleration * tau**2
        ds = rate[k] + acceleration * tau
        moving = (t >= 0.0) & (t <= self.duration)
        ds = np.where(moving, np.maximum(ds, 0.0), 0.0)
        dds = np.where(moving, acceleration, 0.0)
        return along(self.curve, s, ds, dds)


def along(curve: Curve, s: Array, ds: Array, dds: Array) -> MotionPoint:
    """The motion along a path at parameters s (N,), with s' and s'' there; or at one of them."""
    slope, curvature = curve.at(s, 1), curve.at(s, 2)
    du = slope * ds[..., None]
    ddu = slope * dds[..., None] + curvature * ds[..., None] ** 2
    return MotionPoint(curve.at(s), du, ddu)


def accelerations(s: Array, x: Array) -> Array:
    """s'' (N - 1,) between stations with squares x (N,) of s'."""
    return np.asarray(np.diff(x) / (2.0 * np.diff(s)))


def times_of(s: Array, x: Array) -> Array:
    """Times (N,) of the stations [s]."""
    rate = np.sqrt(x)
    sums = np.maximum(rate[:-1] + rate[1:], 1e-300)
    durations = 2.0 * np.diff(s) / sums
    return np.append(0.0, np.cumsum(durations))
