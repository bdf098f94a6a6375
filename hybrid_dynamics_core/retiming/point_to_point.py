"""Motions between two points with limited jerk, within all limits of a robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from ..limits import LimitMargins
from ..limits.margins import margins_of
from .constraints import Constraints
from .curve import Curve, curve_of
from .motion import MotionPoint
from .ramps import Ramp, ramp
from .retime import at_limit, checked_share, search_of
from .robot_interface import RetimedRobot

_PLACES = 40  # of each segment at which limits are checked
_WEAKER = 6  # times that the acceleration is halved in search of the shortest duration
_CLOSER = 8  # times that the best of them is then changed by less: to 0.3 %
_HALVINGS = 12  # of a range of rates
_RESERVE = 1e-4  # share of limits that is kept free between places
_LEAST = 1e-6  # share of the highest rate below which a search ends


@dataclass(frozen=True, eq=False)
class JerkLimitedMotion:
    """A straight motion of the active joints with limited jerk.

    Attributes:
        curve: the path.
        profile: motion along it.
        margins: margins on a fine grid.
        limited_by: (name, kind) of the quantities that come to a limit.
    """

    curve: Curve
    profile: Ramp
    margins: LimitMargins
    limited_by: tuple[tuple[str, str], ...]

    @property
    def duration(self) -> float:
        """[s]."""
        return self.profile.duration

    def __call__(self, t: ArrayLike) -> MotionPoint:
        """The motion at a time [s] or at times (N,); at rest before its start and after its end."""
        within = np.clip(real_array("t", t), 0.0, self.duration)
        s, ds, dds = self.profile.at(within)
        slope = self.curve.at(s, 1)
        return MotionPoint(
            self.curve.at(s),
            slope * ds[..., None],
            slope * dds[..., None],
        )


def point_to_point(
    robot: RetimedRobot,
    start: ArrayLike,
    end: ArrayLike,
    jerk: ArrayLike,
    loads: Loads | None = None,
    *,
    share: float = 1.0,
) -> JerkLimitedMotion:
    """A straight motion of the active joints between two points, with limited jerk.

    It rises and falls in ramps of constant jerk, with one largest rate and acceleration. They are
    the ones of the shortest duration within all limits, which hold at every instant.

    Args:
        robot: the robot.
        start: active coordinates (n,) [rad or m].
        end: active coordinates (n,) [rad or m].
        jerk: largest jerk of all active joints, or of each (n,) [rad/s^3 or m/s^3].
        loads: loads besides the actuators; those of the description if None.
        share: share of each limit that is used, above 0 and up to 1.

    Returns:
        The motion.

    Raises:
        InputError: as in `retime`, or a jerk is not above zero.
    """
    points = np.stack(
        [
            real_array(
                "start",
                start,
            ),
            real_array(
                "end",
                end,
            ),
        ]
    )
    curve = curve_of(points, robot.active)
    largest = np.broadcast_to(
        real_array("jerk", jerk),
        points[0].shape,
    )
    if not (largest > 0.0).all():
        raise InputError(f"jerk is {largest.tolist()}; expected numbers above zero")
    constraints = Constraints(robot, curve, loads, None, checked_share(share))
    search = search_of(constraints)
    search.check_path()
    at_start = curve.at(np.zeros(1), 1)
    slope = np.abs(at_start[0])
    moving = slope > 0.0
    strongest = float((largest[moving] / slope[moving]).min())
    profile = _Ramps(constraints, search.fastest(), strongest).shortest()
    s, ds, dds = profile.at(_grid(profile))
    state = constraints.state(s, ds**2)
    ddu = curve.at(s, 1) * dds[:, None]
    tau = robot.inverse_dynamics(state, ddu, loads)
    constraints.check_idle(tau)
    margins = margins_of(constraints.limits, state, tau, ddu)
    return JerkLimitedMotion(curve, profile, margins, at_limit(margins, share))


class _Ramps:
    """The search for the shortest ramps within constraints."""

    def __init__(self, constraints: Constraints, fastest: Array, jerk: float) -> None:
        self._constraints = constraints
        self._way = constraints.curve.end
        self._rate = float(np.sqrt(fastest.max()))
        self._jerk = jerk
        self._best: Ramp | None = None
        self._acceleration = 0.0

    def shortest(self) -> Ramp:
        """The shortest of ramps with several accelerations, each as fast as possible.

        Raises:
            InputError: none keeps all limits.
        """
        strongest = self._rate**2 / self._way * 4.0
        for k in range(2 * _WEAKER):
            self._try(strongest / 2.0**k)
        factor = 2.0**0.5
        for _ in range(_CLOSER):
            middle = self._acceleration
            self._try(middle * factor)
            self._try(middle / factor)
            factor **= 0.5
        if self._best is None:
            raise InputError("no motion between the points keeps all limits, however slow")
        return self._best

    def _try(self, acceleration: float) -> None:
        """Keep the fastest ramp with an acceleration, if it is shorter than the best so far."""
        candidate = self._fastest(acceleration)
        if candidate is None:
            return
        if self._best is None or candidate.duration < self._best.duration:
            self._best, self._acceleration = candidate, acceleration

    def _fastest(self, acceleration: float) -> Ramp | None:
        """The fastest ramp with an acceleration; None if none keeps all limits."""
        low, high = _LEAST * self._rate, self._rate
        best = self._allowed(low, acceleration)
        if best is None:
            return None
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            faster = self._allowed(middle, acceleration)
            if faster is None:
                high = middle
            else:
                low, best = middle, faster
        return best

    def _allowed(self, rate: float, acceleration: float) -> Ramp | None:
        """The ramp, if it keeps all limits on a fine grid."""
        profile = ramp(self._way, rate, acceleration, self._jerk)
        s, ds, dds = profile.at(_grid(profile))
        squares = ds**2
        ratio = self._constraints.speed_ratio(s, squares)
        if ratio.max() > self._constraints.share * (1.0 - _RESERVE):
            return None
        residuals = self._constraints.residuals(s, squares, dds)
        if residuals.max() > -_RESERVE:
            return None
        return profile


def _grid(profile: Ramp) -> Array:
    """Times (N,) within all segments [s]."""
    fractions = np.linspace(0.0, 1.0, _PLACES, endpoint=False)
    spans = np.diff(profile.times)
    times = profile.times[:-1, None] + spans[:, None] * fractions
    return np.unique(
        np.append(
            times.ravel(),
            profile.duration,
        )
    )
