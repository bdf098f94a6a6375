"""Events of a simulation: ends of strokes, limits of joints, singular configurations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..closed_state.passages.record import Passage
from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from ..robot.robot import Robot

LIMIT, SINGULAR, PASSAGE = "limit", "singular", "passage"


@dataclass(frozen=True)
class Event:
    """A limit or singularity that a simulation reached, or a singular place that it passed.

    Attributes:
        time: time of the event [s].
        kind: "limit", "singular" or "passage".
        name: name of the coordinate or of the loop; of several loops joined by +.
        message: description of the event, in a sentence.
        passage: the place of a "passage", with both motions that meet there; else None.
    """

    time: float
    kind: str
    name: str
    message: str
    passage: Passage | None = None


def passage_event(time: float, passage: Passage) -> Event:
    """The event of a passage."""
    return Event(time, PASSAGE, "+".join(passage.loops), passage.message, passage)


@dataclass(frozen=True)
class _Limit:
    """One finite limit of a coordinate."""

    name: str
    index: int
    value: float
    is_upper: bool
    unit: str

    def distance(self, s: Array) -> Array:
        """Distance (...) of coordinates s (..., n_s) to the limit, negative beyond it."""
        if self.is_upper:
            return self.value - s[..., self.index]
        return s[..., self.index] - self.value

    def speed(self, ds: Array) -> Array:
        """Speed (...) towards the limit, from rates (..., n_s)."""
        if self.is_upper:
            return ds[..., self.index]
        return -ds[..., self.index]


class Watch:
    """Event functions of one robot's states.

    Events have an index: one for each limit, and the last one for the nearest singularity.

    Args:
        robot: the model.
        singular: distance to a singular configuration at which a simulation ends.

    Attributes:
        singular: that distance.
    """

    def __init__(self, robot: Robot, singular: float) -> None:
        self.singular = singular
        self._limits = _limits(robot)

    def check_limits(self, state: ClosedState) -> None:
        """Raise InputError if the start is beyond a limit."""
        for limit in self._limits:
            if limit.distance(state.s) < 0.0:
                side = "above" if limit.is_upper else "below"
                raise InputError(
                    f"{limit.name} = {state.s[limit.index]:.6g} {limit.unit} starts {side} its"
                    f" limit {limit.value:.6g} {limit.unit}"
                )

    def check_singularity(self, state: ClosedState) -> None:
        """Raise InputError if the start is too near to a singularity."""
        if state.singularity < self.singular:
            raise InputError(
                f"loop '{state.singular_loop}' starts {state.singularity:.3g} (of at most 1) from a"
                f" singular configuration; the simulation would end at {self.singular:.3g}"
            )

    def margins(self, state: ClosedState) -> Array:
        """Distance to each event, negative after it: (k,), or (N, k) for a batch."""
        margins = np.empty((*state.u.shape[:-1], len(self._limits) + 1))
        for k, limit in enumerate(self._limits):
            margins[..., k] = limit.distance(state.s)
        margins[..., -1] = state.singularity - self.singular
        margins[np.asarray(state.status) != ClosureStatus.OK] = -1.0
        return margins

    def speeds(self, state: ClosedState) -> Array:
        """Speeds towards the limits: (k - 1,), or (N, k - 1) for a batch."""
        speeds = np.empty((*state.u.shape[:-1], len(self._limits)))
        for k, limit in enumerate(self._limits):
            speeds[..., k] = limit.speed(state.ds)
        return speeds

    def event(self, index: int, time: float, state: ClosedState) -> Event:
        """The event with a given index; `state` is the one just before it."""
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
