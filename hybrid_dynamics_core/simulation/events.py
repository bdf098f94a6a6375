"""What a simulation watches for: ends of strokes, limits of joints, singular configurations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from ..robot.robot import Robot

LIMIT, SINGULAR = "limit", "singular"
HALVINGS = 60  # of a step, until its time is exact to rounding

StateAt = Callable[[float], ClosedState]  # the state at a time [s] within a step


@dataclass(frozen=True)
class Event:
    """Something met by a simulation.

    Attributes:
        time: when it was met [s].
        kind: "limit" or "singular".
        name: of the coordinate or of the loop.
        message: what was met, in a sentence.
    """

    time: float
    kind: str
    name: str
    message: str


@dataclass(frozen=True)
class _Limit:
    """One finite limit of a coordinate."""

    name: str
    index: int
    value: float
    is_upper: bool
    unit: str

    def distance(self, s: Array) -> float:
        """From coordinates (n,) to the limit, negative beyond it."""
        if self.is_upper:
            return float(self.value - s[self.index])
        return float(s[self.index] - self.value)

    def speed(self, state: ClosedState) -> float:
        """The rate at which the limit comes nearer."""
        rate = float(state.ds[self.index])
        if self.is_upper:
            return rate
        return -rate

    def may_be_passed(self, start: ClosedState, end: ClosedState, duration: float) -> bool:
        """Whether a coordinate that set out for its limit and turned back may have been there."""
        first = self.speed(start)
        last = self.speed(end)
        turned_back = first > 0.0 >= last
        # With speeds between these two it comes less far.
        farthest = (abs(first) + abs(last)) * duration
        nearest = min(self.distance(start.s), self.distance(end.s))
        return turned_back and nearest < farthest


class Watch:
    """Watches the states of one robot.

    Events have an index: one for each limit, and the last one for the nearest singularity.

    Args:
        robot: whose states are watched.
        singular: distance to a singular configuration at which a simulation ends.
    """

    def __init__(self, robot: Robot, singular: float) -> None:
        self._singular = singular
        self._limits = _limits(robot)

    def check_start(self, state: ClosedState) -> None:
        """Raise InputError where the start is beyond a limit or too near to a singular place."""
        for limit in self._limits:
            if limit.distance(state.s) < 0.0:
                side = "above" if limit.is_upper else "below"
                raise InputError(
                    f"{limit.name} = {state.s[limit.index]:.6g} {limit.unit} starts {side} its"
                    f" limit {limit.value:.6g} {limit.unit}"
                )
        if state.singularity < self._singular:
            raise InputError(
                f"loop '{state.singular_loop}' starts {state.singularity:.3g} (of at most 1) from a"
                f" singular configuration; the simulation would end at {self._singular:.3g}"
            )

    def margins(self, state: ClosedState) -> Array:
        """(k,) distance to each event, zero or negative where it has come."""
        if state.status is not ClosureStatus.OK:
            return np.full(len(self._limits) + 1, -1.0)
        margins = [limit.distance(state.s) for limit in self._limits]
        margins.append(float(state.singularity) - self._singular)
        return np.array(margins)

    def find(
        self,
        start: ClosedState,
        at: StateAt,
        t: tuple[float, float],
        ignored: Sequence[int],
    ) -> tuple[int, float] | None:
        """The first event in a step.

        Args:
            start: the state at t[0].
            at: the state at any time of the step.
            t: start and end of the step [s].
            ignored: indices of events that are not looked for.

        Returns:
            The index of the event and the time just before it [s]; None where nothing is met.
        """
        # Zero is watched too: a state on a limit may leave it either way.
        watched = self.margins(start) >= 0.0
        watched[list(ignored)] = False

        def is_met(time: float) -> bool:
            return len(self._met(watched, at(time))) > 0

        low, high = t
        end = at(high)
        if not len(self._met(watched, end)):
            turns = self._turns(start, end, at, t, watched)
            passed = [time for time in turns if is_met(time)]
            if not passed:
                return None
            high = min(passed)
        after, before = _bisected(low, high, is_met)
        events = self._met(watched, at(after))
        # Where the loops stop closing, all events come at once: the singularity was met.
        return int(events[-1]), before

    def _met(self, watched: NDArray[np.bool_], state: ClosedState) -> NDArray[np.intp]:
        """Indices of the watched events that have come."""
        return np.flatnonzero(watched & ~(self.margins(state) > 0.0))

    def _turns(
        self,
        start: ClosedState,
        end: ClosedState,
        at: StateAt,
        t: tuple[float, float],
        watched: NDArray[np.bool_],
    ) -> list[float]:
        """Times within a step at which coordinates turned back that may have met their limit."""
        duration = t[1] - t[0]
        turns = []
        for index in np.flatnonzero(watched[:-1]).tolist():
            limit = self._limits[index]
            if limit.may_be_passed(start, end, duration):
                turns.append(_turn(limit, at, t))
        return turns

    def event(self, index: int, time: float, state: ClosedState) -> Event:
        """The event with an index; `state` is the one just before it."""
        if index == len(self._limits):
            place = f"{state.singularity:.3g} (of at most 1) from a singular configuration"
            message = f"loop '{state.singular_loop}' came to {place}"
            return Event(time, SINGULAR, str(state.singular_loop), message)
        limit = self._limits[index]
        side = "upper" if limit.is_upper else "lower"
        message = f"{limit.name} reached its {side} limit {limit.value:.6g} {limit.unit}"
        return Event(time, LIMIT, limit.name, message)

    def is_limit(self, index: int) -> bool:
        """Whether the event is of a coordinate, not of a singularity."""
        return index < len(self._limits)


def _turn(limit: _Limit, at: StateAt, t: tuple[float, float]) -> float:
    """When a coordinate that set out for its limit turned back."""

    def has_turned(time: float) -> bool:
        return not limit.speed(at(time)) > 0.0

    after, _ = _bisected(*t, has_turned)
    return after


def _bisected(low: float, high: float, true: Callable[[float], bool]) -> tuple[float, float]:
    """The time at which `true` becomes so, as it is at `high`, and the one just before."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if true(middle):
            high = middle
        else:
            low = middle
    return high, low


def _limits(robot: Robot) -> list[_Limit]:
    """Finite limits of all joints, narrowed by the strokes of their cylinders."""
    limits = []
    for index, name in enumerate(robot.coordinates):
        lower, upper = robot.description.joints[name].limits
        if name in robot.cylinders:
            stroke = robot.cylinders[name].stroke
            lower = max(lower, stroke[0])
            upper = min(upper, stroke[1])
        unit = coordinate_unit(robot.joint_types[name])
        for value, is_upper in ((lower, False), (upper, True)):
            if np.isfinite(value):
                limits.append(_Limit(name, index, value, is_upper, unit))
    return limits
