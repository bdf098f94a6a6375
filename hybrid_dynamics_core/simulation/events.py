"""What a simulation watches for: ends of strokes, limits of joints, singular configurations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from ..robot.robot import Robot

LIMIT, SINGULAR = "limit", "singular"
HALVINGS = 60  # of a step, until its time is known to rounding


@dataclass(frozen=True)
class Event:
    """Something met at a time [s]: `kind` "limit" or "singular"; `name` of the coordinate or loop; `message`."""

    time: float
    kind: str
    name: str
    message: str


@dataclass(frozen=True)
class _Limit:
    name: str
    index: int
    value: float
    upper: bool
    unit: str

    def left(self, s: Array) -> float:
        """How far it is to the limit, negative beyond."""
        return float(self.value - s[self.index] if self.upper else s[self.index] - self.value)

    def speed(self, state: ClosedState) -> float:
        """The rate at which the limit comes nearer."""
        rate = float(state.ds[self.index])
        return rate if self.upper else -rate

    def may_be_passed(self, start: ClosedState, end: ClosedState, duration: float) -> bool:
        """Whether a coordinate that set out for its limit and turned back may have been there."""
        speeds = self.speed(start), self.speed(end)
        farthest = (
            abs(speeds[0]) + abs(speeds[1])
        ) * duration  # with speeds between these it comes less far
        return speeds[0] > 0.0 >= speeds[1] and min(self.left(start.s), self.left(end.s)) < farthest


class Watch:
    """Watches the states of one robot."""

    def __init__(self, robot: Robot, singular: float) -> None:
        self._singular = singular
        self._limits = _limits(robot)

    def check_start(self, state: ClosedState) -> None:
        """Raise InputError where the start is beyond a limit or too near to a singular place."""
        for limit in self._limits:
            if limit.left(state.s) < 0.0:
                side = "above" if limit.upper else "below"
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
        """One entry a limit and one for the nearest singularity; not above zero where the event has come."""
        if state.status is not ClosureStatus.OK:
            return np.full(len(self._limits) + 1, -1.0)
        left = [limit.left(state.s) for limit in self._limits]
        return np.array([*left, float(state.singularity) - self._singular])

    def find(
        self,
        start: ClosedState,
        at: Callable[[float], ClosedState],
        t: tuple[float, float],
        ignored: Sequence[int],
    ) -> tuple[int, float] | None:
        """The first event in a step from t[0], where the state was `start`, to t[1]: its index and time."""
        watched = (
            self.margins(start) >= 0.0
        )  # zero: it starts at a limit, and may leave it either way
        watched[list(ignored)] = False

        def met(state: ClosedState) -> np.ndarray:
            return np.flatnonzero(watched & ~(self.margins(state) > 0.0))

        (low, high), end = t, at(t[1])
        if not len(met(end)):
            limits = (self._limits[k] for k in np.flatnonzero(watched[:-1]).tolist())
            turns = [
                _turn(limit, at, t)
                for limit in limits
                if limit.may_be_passed(start, end, t[1] - t[0])
            ]
            beyond = [time for time in turns if len(met(at(time)))]
            if not beyond:
                return None
            high = min(beyond)
        high, low = _bisected(low, high, lambda time: len(met(at(time))) > 0)
        # several at once where the loops stop closing: then it is the singularity that was met
        return int(met(at(high))[-1]), low

    def event(self, index: int, time: float, state: ClosedState) -> Event:
        """The event with this index; `state` just before it."""
        if index == len(self._limits):
            place = f"{state.singularity:.3g} (of at most 1) from a singular configuration"
            message = f"loop '{state.singular_loop}' came to {place}"
            return Event(time, SINGULAR, str(state.singular_loop), message)
        limit = self._limits[index]
        side = "upper" if limit.upper else "lower"
        return Event(
            time,
            LIMIT,
            limit.name,
            f"{limit.name} reached its {side} limit {limit.value:.6g} {limit.unit}",
        )

    def is_limit(self, index: int) -> bool:
        """Whether the event is of a coordinate, not of a singularity."""
        return index < len(self._limits)


def _turn(limit: _Limit, at: Callable[[float], ClosedState], t: tuple[float, float]) -> float:
    """When a coordinate that set out for its limit turned back."""
    return _bisected(*t, lambda time: not limit.speed(at(time)) > 0.0)[0]


def _bisected(low: float, high: float, true: Callable[[float], bool]) -> tuple[float, float]:
    """The time at which `true` becomes so, as it is at `high`, and the one just before."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (low, middle) if true(middle) else (middle, high)
    return high, low


def _limits(robot: Robot) -> list[_Limit]:
    """Finite limits of all joints, narrowed by the strokes of their cylinders."""
    found = []
    for k, name in enumerate(robot.coordinates):
        lower, upper = robot.description.joints[name].limits
        if name in robot.cylinders:
            stroke = robot.cylinders[name].stroke
            lower, upper = max(lower, stroke[0]), min(upper, stroke[1])
        kind = coordinate_unit(robot.joint_types[name])
        found += [_Limit(name, k, lower, False, kind)] if np.isfinite(lower) else []
        found += [_Limit(name, k, upper, True, kind)] if np.isfinite(upper) else []
    return found
