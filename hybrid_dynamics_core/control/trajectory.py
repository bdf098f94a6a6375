"""Motions of the active joints over time, through given points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly, CubicSpline

from ..errors import InputError
from ..ground.arrays import Array, frozen


class Reference(NamedTuple):
    """Where the active joints should be: u, u', u'', each (n,) or (N, n)."""

    u: Array
    du: Array
    ddu: Array


class JointTrajectory:
    """A motion through points (N, n) at ascending times (N,) [s], as in trajectory_msgs/JointTrajectory.

    With positions alone: the cubic spline that starts and ends at rest, of continuous acceleration;
    with `at_rest` false, as for a motion that was cut out of a longer one, the spline whose ends go
    on as the points do (not-a-knot), which is exact for cubics. With velocities: cubics between the
    points, whose acceleration jumps there. With accelerations too: quintics. Before the first and
    after the last point it stands there at rest.

    Raises InputError for points that do not fit each other.
    """

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        *,
        at_rest: bool = True,
    ) -> None:
        self.times = frozen(times)
        given = [frozen(x) for x in (positions, velocities, accelerations) if x is not None]
        if velocities is None and accelerations is not None:
            raise InputError("accelerations are given without velocities")
        if self.times.ndim != 1 or len(self.times) < 2 or not (np.diff(self.times) > 0.0).all():
            raise InputError("times has to be two or more ascending numbers")
        for name, part in zip(("positions", "velocities", "accelerations"), given, strict=False):
            if part.ndim != 2 or part.shape != (len(self.times), given[0].shape[-1]):
                raise InputError(
                    f"{name} has shape {part.shape}; expected one row for each of {len(self.times)}"
                    " times"
                )
            if not np.isfinite(part).all():
                raise InputError(f"{name} has an entry that is not finite")
        self.positions = given[0]
        times = self.times.copy()  # SciPy 1.11 wants arrays that could be written
        if len(given) == 1:
            self._curve = CubicSpline(
                times, given[0].copy(), axis=0, bc_type="clamped" if at_rest else "not-a-knot"
            )
        else:
            self._curve = BPoly.from_derivatives(times, np.stack(given, axis=1))

    @classmethod
    def between(
        cls, start: ArrayLike, end: ArrayLike, duration: float, begin: float = 0.0
    ) -> JointTrajectory:
        """From rest to rest in `duration` [s] on a quintic: rates and accelerations start and end at zero."""
        positions = np.stack([np.asarray(start, dtype=float), np.asarray(end, dtype=float)])
        rest = np.zeros_like(positions)
        return cls([begin, begin + duration], positions, rest, rest)

    @property
    def duration(self) -> float:
        """From the first to the last point [s]."""
        return float(self.times[-1] - self.times[0])

    def __call__(self, t: ArrayLike) -> Reference:
        """The reference at a time [s], (n,) each, or at times (N,), (N, n) each."""
        t = np.asarray(t, dtype=float)
        within = np.clip(t, self.times[0], self.times[-1])
        moving = ((t >= self.times[0]) & (t <= self.times[-1]))[..., None]
        rate, push = (np.where(moving, self._curve(within, order), 0.0) for order in (1, 2))
        return Reference(np.asarray(self._curve(within)), rate, push)
