"""Time-optimal motions along paths under all limits of a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number
from ..limits import LimitMargins
from ..limits.margins import margins_of
from .constraints import Constraints, Rows
from .curve import Curve, Trajectory, curve_of
from .motion import TimedMotion, accelerations, times_of
from .profile import BlockedError, fastest_profile
from .robot_interface import RetimedRobot

STATIONS = 200
_INSIDE = 12  # pieces of a stretch at whose ends constraints are checked
_FINEST = 40  # the same of the check at the end
_BESIDE = 1e-6  # share of a stretch between a station and the places next to it
_JUMP = 1e-4  # share of a mean stretch; shorter ones contain a turn
_ASIDE = 0.01  # share of the least distance between stations, on either side of a turn
_CLOSE = 0.05  # share of a stretch within which a turn takes the place of a station
_PASSES = 25  # tangents at most
_SETTLED = 1e-4  # share of the duration below which a further tangent gains nothing
_TIGHTENED = 12  # times at most that constraints are narrowed between stations
_RESERVE = 1e-6  # share of a range that is kept free, against rounding
_SLOWER = 0.98  # factor of s'^2 of a motion that is still too fast
_HALF = 0.5  # the same where only a start is wanted
_SLOWDOWNS = 100
_AT_LIMIT = 2e-3  # share of a limit within which a quantity is at it
_FLOOR = 1e-4  # least s'^2 at which tangents are taken, over the largest


def retime(
    robot: RetimedRobot,
    path: ArrayLike | Trajectory,
    loads: Loads | None = None,
    *,
    near: ClosedState | None = None,
    stations: int = STATIONS,
    share: float = 1.0,
) -> TimedMotion:
    """The fastest motion along a path, from rest to rest, within all limits.

    The limits are efforts, accelerations, rates and powers of joints and drives, pressures and
    flows of cylinders, flows and powers of pumps. They hold between stations too: all are checked
    on a fine grid, `margins`. Accelerations may jump.

    Args:
        robot: the robot.
        path: positions (N, n) of the active joints [rad or m], through which a smooth curve goes;
            or a trajectory, whose times do not matter.
        loads: loads besides the actuators; those of the description if None.
        near: closed state whose assembly modes are kept; the robot's own if None.
        stations: number of stretches of constant s''.
        share: share of each limit that is used, above 0 and up to 1.

    Returns:
        The motion.

    Raises:
        InputError: the path leaves limits, opens a loop or is ill-formed; the drives cannot hold
            the robot somewhere; nothing limits the motion.
    """
    used = checked_share(share)
    if not int(stations) == stations >= 2:
        raise InputError(f"stations is {stations}; expected a whole number of 2 or more")
    curve = curve_of(path, robot.active)
    constraints = Constraints(robot, curve, loads, near, used)
    search = search_of(constraints, int(stations))
    search.check_path()
    return search.motion(loads)


def checked_share(share: float) -> float:
    """A share of limits, above 0 and up to 1; otherwise raises InputError."""
    if not 0.0 < real_number("share", share) <= 1.0:
        raise InputError(f"share is {share}; expected a number above 0, up to 1")
    return float(share)


def search_of(constraints: Constraints, stations: int = STATIONS) -> Search:
    """The search with a number of stretches."""
    return Search(constraints, _stations(constraints, stations))


def _stations(constraints: Constraints, count: int) -> Array:
    """Parameters (N,) of stations: dense close to rest, and where drives turn back.

    Raises:
        InputError: a loop does not close along the path.
    """
    end = constraints.curve.end
    angles = np.linspace(0.0, np.pi, count + 1)
    s = 0.5 * end * (1.0 - np.cos(angles))
    dense = np.linspace(0.0, end, _INSIDE * count + 1)
    turns = constraints.turns(dense)
    gaps = np.abs(np.subtract.outer(s, turns))
    # the turns take the places of stations that are close to them
    nearest = gaps.min(axis=1, initial=end)
    is_free = nearest > _CLOSE * end / count
    is_free[0] = True
    is_free[-1] = True
    margin = _CLOSE * end / count**2
    inside = turns[(turns > margin) & (turns < end - margin)]
    # pressures jump there: a station on either side
    aside = _ASIDE * margin
    stations = np.concatenate([s[is_free], inside - aside, inside + aside])
    return np.unique(stations)


class Search:
    """The search for the fastest profile along one path."""

    def __init__(self, constraints: Constraints, s: Array) -> None:
        self.constraints = constraints
        self.curve: Curve = constraints.curve
        self.s = s
        self._divide(_INSIDE)

    def _divide(self, count: int) -> None:
        """Set the fine grid: `count` pieces of each stretch."""
        s = self.s
        fractions = np.linspace(0.0, 1.0, count + 1)
        fractions = np.clip(fractions, _BESIDE, 1.0 - _BESIDE)
        inside = s[:-1, None] + np.diff(s)[:, None] * fractions
        stretches = np.arange(len(s) - 1)
        self.stretch = np.repeat(stretches, len(fractions))
        self.fraction = np.tile(fractions, len(stretches))
        self.fine = inside.ravel()

    # -- checks before

    def check_path(self) -> None:
        """Raise InputError where the path opens a loop, leaves limits or cannot be held."""
        dense = np.sort(np.concatenate([self.s, self.fine]))
        still = np.zeros(len(dense))
        state = self.constraints.state(dense, still)
        limits = self.constraints.limits
        margins = margins_of(limits, state, still[:, None] * state.u)
        for margin in margins.beyond:
            if margin.kind == "position":
                place = self.curve.between(float(dense[margin.index]))
                raise InputError(f"{place}, {margin.text}")
        residuals = self.constraints.residuals(dense, still, still)
        worst = int(np.argmax(residuals.max(axis=1)))
        if residuals[worst].max() <= 0.0:
            return
        raise self._not_held(state, worst, float(dense[worst]))

    def _not_held(self, state: ClosedState, worst: int, s: float) -> InputError:
        """The error for a place at which the drives cannot hold the robot."""
        robot = self.constraints.robot
        one = robot.close(
            state.u[worst],
            near=self.constraints.near,
        )
        tau = robot.inverse_dynamics(
            one,
            np.zeros_like(one.u),
            self.constraints.loads,
        )
        margins = margins_of(self.constraints.limits, one, tau)
        texts = [margin.text for margin in margins.beyond]
        what = "; ".join(texts) or "less than the given share of a limit is needed"
        problem = f"{self.curve.between(s)}, the drives cannot hold {robot.name} at rest: {what}"
        warnings = [text for text in robot.description.warnings if "are these bar?" in text]
        return InputError(". ".join([problem, *warnings]))

    # -- search

    def motion(self, loads: Loads | None) -> TimedMotion:
        """The fastest motion."""
        fastest = self.fastest()
        narrowed = np.zeros((len(self.s), 1))
        x = self._start(fastest)
        for pieces in (_INSIDE, _FINEST):
            self._divide(pieces)
            for _ in range(_TIGHTENED):
                x = self._settled(x, fastest, narrowed)
                excess, ratio = self._excess(x)
                if excess.max() <= 0.0 and ratio.max() <= 1.0:
                    break
                further = np.where(excess > 0.0, 1.1 * excess + _RESERVE, 0.0)
                narrowed = narrowed + further
                fastest = fastest / np.maximum(ratio, 1.0) ** 3
        return self._finished(self._within(x), loads)

    def fastest(self) -> Array:
        """Largest squares (N,) of s'; by rates and flows, or else by what efforts can reach."""
        fastest = self.constraints.fastest(self.s) * (1.0 - _RESERVE)
        still = np.zeros(len(self.s))
        here = self.constraints.residuals(self.s, still, still)
        with np.errstate(divide="ignore", invalid="ignore"):
            pushed = self.constraints.residuals(self.s, still, still + 1.0)
            a = pushed - here
            each = np.where(a > 0.0, -here / a, np.inf)
        strongest = each.min(axis=1)
        # from rest no more is reached than by the strongest push all along the path
        pushes = np.where(np.isfinite(strongest), strongest, 0.0)
        reached = 8.0 * pushes.max() * self.curve.end
        bounded = fastest
        if reached > 0.0:
            bounded = np.minimum(fastest, reached)
        if not np.isfinite(bounded).all():
            raise InputError(
                "nothing limits the motion: the description has no effort, pressure, rate,"
                " acceleration or flow limit that holds along the path"
            )
        return np.asarray(bounded)

    def _start(self, fastest: Array) -> Array:
        """A slow profile (N,) that keeps all limits."""
        share = self.s / self.curve.end
        x = 4.0 * fastest.min() * share * (1.0 - share)
        for _ in range(_SLOWDOWNS):
            excess, ratio = self._excess(x)
            if excess.max() <= 0.0 and ratio.max() <= 1.0:
                break
            x = _HALF * x
        return np.asarray(_HALF * x)

    def _settled(self, x: Array, fastest: Array, narrowed: Array) -> Array:
        """The fastest profile (N,), from tangents at one profile after the other."""
        duration = np.inf
        touched = x
        passed: Array | None = None
        for _ in range(_PASSES):
            try:
                x = self._from_tangents(touched, fastest, narrowed)
            except BlockedError as error:
                if passed is None:
                    place = self.curve.between(float(self.s[error.station]))
                    raise InputError(f"{place}, no motion within the limits goes on") from error
                # the tangents were taken too far beyond a limit
                touched = 0.5 * (touched + passed)
                continue
            passed, touched = touched, x
            now = float(times_of(self.s, x)[-1])
            if abs(duration - now) < _SETTLED * now:
                break
            duration = now
        return x

    def _from_tangents(self, touched: Array, fastest: Array, narrowed: Array) -> Array:
        """The fastest profile (N,) under tangents at a profile."""
        at = np.maximum(touched, _FLOOR * touched.max())
        rows = self.constraints.rows(self.s, at)
        closer = Rows(
            rows.a,
            rows.b,
            rows.c + narrowed + _RESERVE,
        )
        return fastest_profile(self.s, closer, fastest)

    def _fine_profile(self, x: Array) -> tuple[Array, Array]:
        """Squares of s' and s'' on the fine grid."""
        dds = accelerations(self.s, x)[self.stretch]
        widths = np.diff(self.s)[self.stretch]
        squares = x[self.stretch] + 2.0 * dds * self.fraction * widths
        return np.maximum(squares, 0.0), dds

    def _excess(self, x: Array) -> tuple[Array, Array]:
        """What a profile exceeds about each station, on the fine grid.

        Returns:
            By how much rows are exceeded (N, k); rates and flows as shares of their limits (N,).
        """
        squares, dds = self._fine_profile(x)
        count = len(self.s) - 1
        residuals = self.constraints.residuals(self.fine, squares, dds)
        # about a turn values jump; either side of it has a station
        widths = np.diff(self.s)
        is_smooth = widths > _JUMP * self.curve.end / count
        pieces = residuals.reshape(count, -1, residuals.shape[1])
        exceeded = _about_stations(_peaks(pieces, is_smooth))
        speed_ratio = self.constraints.speed_ratio(self.fine, squares)
        ratio = speed_ratio / self.constraints.share
        peaks = _peaks(ratio.reshape(count, -1, 1), is_smooth)
        return exceeded, _about_stations(peaks[:, 0])

    def _within(self, x: Array) -> Array:
        """The profile (N,), or a slower one that keeps all limits on the fine grid."""
        for _ in range(_SLOWDOWNS):
            excess, ratio = self._excess(x)
            if excess.max() <= 0.0 and ratio.max() <= 1.0:
                return x
            by_rows = _slowed(excess.max())
            by_rates = 1.0 / max(ratio.max(), 1.0) ** 2
            x = x * min(by_rows, by_rates)
        raise InputError("no motion along the path keeps all limits, however slow")

    # -- result

    def _finished(self, x: Array, loads: Loads | None) -> TimedMotion:
        squares, dds = self._fine_profile(x)
        state = self.constraints.state(self.fine, squares)
        slope = self.curve.at(self.fine, 1)
        curvature = self.curve.at(self.fine, 2)
        ddu = slope * dds[:, None] + curvature * squares[:, None]
        tau = self.constraints.robot.inverse_dynamics(state, ddu, loads)
        self.constraints.check_idle(tau)
        margins = margins_of(self.constraints.limits, state, tau, ddu)
        times = times_of(self.s, x)
        reached = at_limit(margins, self.constraints.share)
        return TimedMotion(
            self.curve,
            self.s,
            x,
            times,
            margins,
            reached,
        )


def _slowed(excess: float) -> float:
    """Factor of s'^2 for an excess of forces."""
    if excess <= 0.0:
        return 1.0 - _RESERVE
    return max(_SLOWER, 1.0 - max(4.0 * excess, _RESERVE))


def _peaks(values: Array, is_smooth: np.ndarray) -> Array:
    """Largest values (N, k) of stretches, between places (N, p, k) too where they are smooth.

    Between two places a smooth curve is above its chord by an eighth of the second difference.
    """
    with np.errstate(invalid="ignore"):
        second_differences = np.diff(values, n=2, axis=1)
        bends = np.abs(second_differences).max(axis=1)
    counts = np.isfinite(bends) & is_smooth[:, None]
    bends = np.where(counts, bends, 0.0)
    return np.asarray(values.max(axis=1) + bends / 8.0)


def _about_stations(by_stretch: Array) -> Array:
    """The larger one of the stretches before and after each station."""
    before = np.concatenate([by_stretch[:1], by_stretch])
    after = np.concatenate([by_stretch, by_stretch[-1:]])
    return np.asarray(np.maximum(before, after))


def at_limit(margins: LimitMargins, share: float) -> tuple[tuple[str, str], ...]:
    """Names and kinds of quantities that come to the used share of their limit."""
    shares = margins.shares.min(axis=0)
    names: list[tuple[str, str]] = []
    for row, least in zip(margins.rows, shares, strict=True):
        if row.kind != "position" and least <= 1.0 - share + _AT_LIMIT:
            names.append((row.name, row.kind))
    return tuple(names)
