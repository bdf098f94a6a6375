"""Search for the first event within a step of an integrator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from .events import Watch

HALVINGS = 60  # bisections until a time is exact to rounding

StateAt = Callable[[float], ClosedState]  # the state at a time [s] within a step


@dataclass(frozen=True, eq=False)
class Step:
    """One step of an integrator, sampled densely enough to find all events.

    Attributes:
        times: (N,) from start to end [s].
        states: states at these times, a batch of N; rows that do not close have a status.
        at: function from a time in the step to the state.
        dense: function from a time in the step to (u, u', work).
    """

    times: Array
    states: ClosedState
    at: StateAt
    dense: Callable[[float], Array]


def first_event(watch: Watch, step: Step, ignored: Sequence[int]) -> tuple[int, float] | None:
    """The first event in a step.

    Args:
        watch: event functions of the robot.
        step: the step.
        ignored: indices of events to ignore.

    Returns:
        The index of the event and the time just before it [s]; None if there is no event.
    """
    return _Search(watch, step).first(ignored)


class _Search:
    """The search for events in one step."""

    def __init__(self, watch: Watch, step: Step) -> None:
        self._watch = watch
        self._step = step
        self._margins = watch.margins(step.states)
        self._speeds = watch.speeds(step.states)

    def first(self, ignored: Sequence[int]) -> tuple[int, float] | None:
        met: list[tuple[float, int, float]] = []
        for index in range(self._margins.shape[1]):
            # Zero is included: a state on a limit may leave it in either direction.
            if index in ignored or self._margins[0, index] < 0.0:
                continue
            interval = self._interval(index)
            if interval is not None:
                after, before = self._bisected(*interval, index)
                met.append((after, -index, before))
        if not met:
            return None
        # If the loops stop closing, all events coincide. Then the last one, the singularity, is
        # returned.
        _, index, before = min(met)
        return -index, before

    def _interval(self, index: int) -> tuple[float, float] | None:
        """Interval that brackets the first occurrence of an event; None if it does not occur."""
        margins, times = self._margins[:, index], self._step.times
        for k in range(1, len(times)):
            end = float(times[k])
            if margins[k] > 0.0:
                lowest = self._lowest(index, k)
                if lowest is None or self._margin(index, lowest) > 0.0:
                    continue
                end = lowest
            return float(times[k - 1]), end
        return None

    def _lowest(self, index: int, k: int) -> float | None:
        """Time of a possible minimum of the margin between two samples with positive margin."""
        interval = (float(self._step.times[k - 1]), float(self._step.times[k]))
        if self._watch.is_limit(index):
            first, last = self._speeds[k - 1, index], self._speeds[k, index]
            if not first > 0.0 >= last:
                return None
            return self._turn(index, interval)
        if not self._may_dip(index, k):
            return None
        minimum = minimize_scalar(
            lambda time: self._margin(index, time),
            bounds=interval,
            method="bounded",
            options={"xatol": 1e-9 * (interval[1] - interval[0])},
        )
        return float(minimum.x)

    def _may_dip(self, index: int, k: int) -> bool:
        """Whether a margin without derivative, extrapolated from both sides, could reach zero."""
        margins = self._margins[:, index]
        changes = np.abs(np.diff(margins[max(k - 2, 0) : k + 2]))
        return bool(min(margins[k - 1], margins[k]) < 2.0 * changes.max())

    def _turn(self, index: int, interval: tuple[float, float]) -> float:
        """Time at which a coordinate that moved towards its limit turns back."""

        def has_turned(time: float) -> bool:
            return not self._watch.speeds(self._step.at(time))[index] > 0.0

        after, _ = bisected(*interval, has_turned)
        return after

    def _margin(self, index: int, time: float) -> float:
        return float(self._watch.margins(self._step.at(time))[index])

    def _bisected(self, low: float, high: float, index: int) -> tuple[float, float]:
        return bisected(low, high, lambda time: not self._margin(index, time) > 0.0)


def bisected(low: float, high: float, true: Callable[[float], bool]) -> tuple[float, float]:
    """Bisect for the time at which `true` becomes true; returns the times just after and before."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if true(middle):
            high = middle
        else:
            low = middle
    return high, low
