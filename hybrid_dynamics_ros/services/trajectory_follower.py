"""Following of a motion from sample to sample, up to the first problem."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages.cdr import NS
from ..messages.joint_samples import FloatArray, OrderedMotion, Rejection, rejection_of
from .trajectory_limits import MotionLimits
from .trajectory_motion import SmoothMotion

_MOST_HALVINGS: Final = 10  # of an interval between points
_LEAST_HALVED: Final = 1e-5  # [s] a piece of a controller's cycle, many times the unit of stamps
_SHARE_OF_TIME: Final = 1e-6  # precision of the first bad time, as a share of an interval
_MOST_SURVEYED: Final = 33  # points for an estimate of the largest efforts
_DOUBLINGS: Final = 2  # of samples that meet a power: it turns up to eight times between points
_MOST_REFINEMENTS: Final = 5  # refinements at the minimum of a margin
_LEAST_SHARE_OF_SPAN: Final = 1e-3  # least distance of such samples, as a share of an interval
_PARABOLA_ERROR: Final = 0.5  # of a parabola, as a share of the range of its margins
_MOST_LOOKED_AHEAD: Final = 9  # moments at which is looked how far a motion goes beyond a bound
_QUARTERS: Final = np.array([0.25, 0.5, 0.75])
# Factor for the deviation of smooth efforts between the quarter points.
_CAUTION: Final = 0.9


@dataclass(frozen=True, eq=False)
class ConversionSettings:
    """Settings of a conversion.

    Attributes:
        loads: loads on the robot; None: those of its description.
        least: least allowed distance to a singularity, 0 singular, 1 best.
        tolerance: largest deviation of efforts from linear between two points, as a share of each
            drive's largest effort; 0: keep the points of the motion.
    """

    loads: Loads | None = None
    least: float = 0.0
    tolerance: float = 0.0


class Sample(NamedTuple):
    """One moment of the motion.

    `values` are position, velocity, acceleration and effort of the active joints (4, n). If the
    loops do not close, only time and problem are set.
    """

    time: float
    problem: Rejection | None
    state: ClosedState | None = None
    values: FloatArray = np.zeros(0)
    margins: FloatArray = np.zeros(0)


class Follower:
    """Follows one motion of a robot."""

    def __init__(self, robot: Robot, motion: SmoothMotion, settings: ConversionSettings) -> None:
        self._robot = robot
        self._motion = motion
        self._settings = settings
        self._limits = MotionLimits(robot, settings.least)

    def allowed(self, largest: FloatArray) -> FloatArray:
        """Largest allowed deviation (n,) of efforts from linear between samples [N m or N]."""
        tolerance = self._settings.tolerance
        if tolerance > 0.0:
            return tolerance * largest
        return np.full_like(largest, np.inf)

    def survey(self, near: ClosedState | None) -> FloatArray:
        """Largest effort of each active joint at some of the points (n,) [N m or N]."""
        largest = np.zeros(len(self._robot.active))
        if not self._settings.tolerance:
            return largest
        count = self._motion.time.size
        surveyed = min(count, _MOST_SURVEYED)
        evenly = np.linspace(0, count - 1, surveyed).round()
        chosen = np.unique(evenly)
        for number in chosen.astype(int).tolist():
            moment = float(self._motion.time[number])
            sample = self.sample(moment, near)
            if sample.state is None:
                break
            near = sample.state
            largest = np.maximum(largest, np.abs(sample.values[3]))
        return largest

    def sample(self, moment: float, near: ClosedState | None) -> Sample:
        """The sample at a time [s], followed from a nearby state."""
        robot = self._robot
        point = self._motion.at(moment)
        try:
            state, acceleration = _close(robot, self._motion.names, point, near)
            efforts = robot.inverse_dynamics(state, acceleration, self._settings.loads)
            margins = self._limits.margins(state, efforts, acceleration)
        except HybridDynamicsError as error:
            return Sample(moment, rejection_of(error))
        problem = None
        if (margins < 0.0).any():
            problem = self._limits.problem(state, efforts, acceleration)
        values = np.array([state.u, state.du, acceleration, efforts])
        return Sample(moment, problem, state, values, margins)

    def pieces(self, first: Sample, end: float, allowed: FloatArray) -> Iterator[Sequence[Sample]]:
        """Samples up to a time, in pieces within which efforts are linear.

        A piece whose last sample has a problem is the last one.

        Args:
            first: sample at the start of the interval.
            end: end of the interval [s].
            allowed: allowed deviations of efforts from linear (n,) [N m or N].
        """
        span = end - first.time
        times = first.time + _QUARTERS * span
        if span >= _LEAST_HALVED:
            times = np.round(times * NS) / NS
        following = self._following(first, [*times.tolist(), end])
        todo = [(self._checked(following, span), 0)]
        while todo:
            piece, halvings = todo.pop()
            is_bad = piece[-1].problem is not None
            is_short = piece[-1].time - piece[0].time < _LEAST_HALVED
            is_short = is_short or halvings == _MOST_HALVINGS
            if is_bad or is_short or _is_linear(piece, allowed):
                yield piece
                if is_bad:
                    return
                continue
            halves = [self._denser(half) for half in (piece[:3], piece[2:])]
            todo += [(self._checked(half, span), halvings + 1) for half in reversed(halves)]

    def _following(self, first: Sample, times: Sequence[float]) -> list[Sample]:
        """The samples at some times, up to the first problem."""
        samples = [first]
        for moment in times:
            samples.append(self.sample(moment, samples[-1].state))
            if samples[-1].problem is not None:
                break
        return samples

    def _denser(self, samples: Sequence[Sample]) -> list[Sample]:
        """The samples, with one more between each two."""
        denser = [samples[0]]
        for before, after in pairwise(samples):
            moment = _as_stamped(0.5 * (before.time + after.time))
            denser += [self.sample(moment, before.state), after]
        return denser

    def _checked(self, samples: list[Sample], span: float) -> list[Sample]:
        """The samples up to the first problem at or between them."""
        dense = samples
        if self._limits.has_powers:
            for _ in range(_DOUBLINGS):
                dense = self._with(dense, _middles(dense))
        for _ in range(_MOST_REFINEMENTS):
            moments = _dips(dense, _LEAST_SHARE_OF_SPAN * span)
            if not moments:
                break
            dense = self._with(dense, moments)
        if dense[-1].problem is None:
            return samples
        bad = self._first_bad(dense[-2], dense[-1], span)
        return [*dense[:-1], self._with_excess(bad, dense[-1].time)]

    def _with_excess(self, bad: Sample, moment: float) -> Sample:
        """A bad sample, with the largest excess of the motion over the bound.

        Args:
            bad: the first bad sample.
            moment: when the motion is beyond the bound as well [s].
        """
        if bad.problem is None or not bad.margins.size:
            return bad
        bound = int(np.flatnonzero(bad.margins < 0.0)[0])
        end = self._motion.end_after(bad.time)
        evenly = np.linspace(bad.time, end, _MOST_LOOKED_AHEAD)
        times = np.union1d(evenly, [moment])
        ahead = [bad]
        for time in times[times > bad.time].tolist():
            sample = self.sample(time, ahead[-1].state)
            if not sample.margins.size:
                break
            ahead.append(sample)
        worst = self._worst(ahead, bound)
        excess = self._limits.excess(bound, float(worst.margins[bound]))
        text = f"{bad.problem.text}; up to {excess} beyond, at {worst.time:.9g} s"
        return bad._replace(problem=replace(bad.problem, text=text))

    def _worst(self, samples: Sequence[Sample], bound: int) -> Sample:
        """The sample farthest beyond a bound, or one near by that is farther."""
        margins = [sample.margins[bound] for sample in samples]
        k = int(np.argmin(margins))
        worst = samples[k]
        if not 0 < k < len(samples) - 1:
            return worst
        triple = samples[k - 1 : k + 2]
        of_bound = [one._replace(margins=one.margins[[bound]]) for one in triple]
        for moment in _lowest(of_bound):
            sample = self.sample(moment, triple[0].state)
            if sample.margins.size and sample.margins[bound] < worst.margins[bound]:
                worst = sample
        return worst

    def _with(self, samples: Sequence[Sample], moments: Sequence[float]) -> list[Sample]:
        """The samples, with further ones at some times, up to the first problem."""
        merged: list[Sample] = []
        by_time = {sample.time: sample for sample in samples}
        for moment in sorted({*by_time, *moments}):
            sample = by_time.get(moment)
            if sample is None:
                sample = self.sample(moment, merged[-1].state)
            merged.append(sample)
            if sample.problem is not None:
                break
        return merged

    def _first_bad(self, good: Sample, bad: Sample, span: float) -> Sample:
        """The first bad sample between a good one and a bad one."""
        while bad.time - good.time > _SHARE_OF_TIME * span:
            middle = 0.5 * (good.time + bad.time)
            if not good.time < middle < bad.time:
                break
            sample = self.sample(middle, good.state)
            if sample.problem is None:
                good = sample
            else:
                bad = sample
        return bad


def _as_stamped(time: float) -> float:
    """A time [s] as messages have it, in nanoseconds.

    A value that belongs to another time is a jolt where points are close together.
    """
    return round(time * NS) / NS


def _close(
    robot: Robot,
    names: tuple[str, ...],
    point: Sequence[FloatArray],
    near: ClosedState | None,
) -> tuple[ClosedState, FloatArray]:
    position, velocity, acceleration = point
    if names == robot.active:
        return robot.close(position, velocity, near=near), acceleration
    motion = OrderedMotion(position, velocity, acceleration)
    values, rates, accelerations = motion.by_name(names)
    state = robot.close_given(
        values,
        rates,
        accelerations,
        near=near,
    )
    if state.dds is None:
        return state, np.full(state.n, np.nan)
    return state, state.dds[: state.n]


def _is_linear(samples: Sequence[Sample], allowed: FloatArray) -> bool:
    """Whether the efforts of five equidistant samples are almost linear."""
    efforts = np.array([sample.values[3] for sample in samples])
    share = _QUARTERS[:, None]
    line = (1.0 - share) * efforts[0] + share * efforts[-1]
    deviation = np.abs(efforts[1:-1] - line)
    return bool((deviation <= _CAUTION * allowed).all())


def _middles(samples: Sequence[Sample]) -> list[float]:
    """The times [s] in the middle of each two samples."""
    return [0.5 * (before.time + after.time) for before, after in pairwise(samples)]


def _dips(samples: Sequence[Sample], least_step: float) -> list[float]:
    """Times between samples at which a margin may be negative.

    They are minima of parabolas through three samples. The assumed error of a parabola is a share
    of the range of its margins.

    Args:
        samples: samples in the order of time; all except the last are good.
        least_step: least distance to the next sample [s].
    """
    moments: list[float] = []
    times = np.array([sample.time for sample in samples])
    if not samples[-1].margins.size:
        samples = samples[:-1]
    for start in range(len(samples) - 2):
        moments += _lowest(samples[start : start + 3])
    return [moment for moment in moments if np.abs(times - moment).min() > least_step]


def _lowest(triple: Sequence[Sample]) -> list[float]:
    """Times of minima, near or below zero, of parabolas through margins."""
    t0, t1, t2 = [sample.time for sample in triple]
    g0, g1, g2 = [sample.margins for sample in triple]
    slope = (g1 - g0) / (t1 - t0)
    next_slope = (g2 - g1) / (t2 - t1)
    curvature = (next_slope - slope) / (t2 - t0)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = 0.5 * (t0 + t1 - slope / curvature)
        least = g0 + (at - t0) * (slope + curvature * (at - t1))
    margins = np.array([g0, g1, g2])
    error = _PARABOLA_ERROR * np.ptp(margins, axis=0)
    is_inside = (at > t0) & (at < t2)
    dips = (curvature > 0.0) & (least < error) & is_inside
    return [float(moment) for moment in at[dips]]
