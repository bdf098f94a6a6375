"""Many steps at once in compiled code, and which of them are certainly without an event."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..robot.motion.steps import MotionSteps, StepControl, Steps
from ..robot.robot import Robot
from .events import Watch
from .passing.anchors import Anchors
from .search import Step
from .settings import Settings
from .step_bound import LONGEST, PLACES, StepBound

FIRST = 1e-3  # the first step to try, as a share of the span
FEWEST, MOST = 16, 256  # steps at once
DIP = 2.0  # a margin above so many of its changes between places has no zero between them


class Batch(NamedTuple):
    """Steps with the closed states at places of each.

    Attributes:
        steps: K steps.
        times: (K, P), places of each step, from its start to its end [s].
        states: states there, a batch of K P.
        clear: number of leading steps without an event and with unambiguous turns.
    """

    steps: Steps
    times: Array
    states: ClosedState
    clear: int

    def end(self, step: int) -> ClosedState:
        """The state at the end of a step."""
        return self.states.rows((step + 1) * self.times.shape[1] - 1)

    def start(self, step: int) -> ClosedState:
        """The state at the start of a step."""
        return self.states.rows(step * self.times.shape[1])

    def places(self, step: int) -> ClosedState:
        """The states at the places of a step, a batch of P."""
        places = self.times.shape[1]
        return self.states.rows(slice(step * places, (step + 1) * places))


class CompiledIntegrator:
    """Takes steps of DOP853 in compiled code.

    Args:
        robot: the robot.
        steps: its integrator.
        settings: of the simulation.
        watch: event functions.
        bound: bounds of steps.
        span: start and end of the motion [s].
    """

    def __init__(
        self,
        robot: Robot,
        steps: MotionSteps,
        settings: Settings,
        watch: Watch,
        bound: StepBound,
        span: tuple[float, float],
    ) -> None:
        self._robot = robot
        self._steps = steps
        self._watch = watch
        self._bound = bound
        self._tolerances = settings.rtol, settings.atol
        self._step = FIRST * (span[1] - span[0])
        self._most = FEWEST

    def advance(
        self, start: ClosedState, y: Array, tau: Array, span: tuple[float, float]
    ) -> Batch | None:
        """Some steps towards the end of a span; None if there is no first one.

        Args:
            start: closed state at y.
            y: (u, u', work).
            tau: constant efforts (n,).
            span: start and end [s].
        """
        control = StepControl(self._step, self._bound.allowed, *self._tolerances, LONGEST)
        most = FEWEST if self._bound.is_short else self._most
        steps = self._steps.advance(start, y, tau, span, control, most)
        if not steps.number:
            return None
        batch = self._with_states(steps, start)
        if batch.clear == steps.number:
            self._most = min(2 * self._most, MOST)
            self._step = steps.following
        else:  # steps after the doubtful one may have shrunk at a place that is not reached
            self._most = FEWEST
            self._step = float(np.diff(steps.times)[batch.clear])
        return batch

    def _with_states(self, steps: Steps, start: ClosedState) -> Batch:
        n = len(start.u)
        times, numbers, y = _places(steps, PLACES)
        u = y[:, :n].reshape(steps.number, PLACES, n)
        more = self._bound.more_places_of(u, steps.R[:-1])
        if more:
            times, numbers, y = _places(steps, PLACES + more)
        places = PLACES + more
        near = anchors_of(steps, numbers, start).as_near(start)
        states = self._robot.close(y[:, :n], y[:, n : 2 * n], check=False, near=near)
        doubtful = self._doubtful(states, steps, places)
        clear = int(doubtful.argmax()) if doubtful.any() else steps.number
        return Batch(steps, times, states, clear)

    def _doubtful(self, states: ClosedState, steps: Steps, places: int) -> NDArray[np.bool_]:
        """Whether each step (K,) may have an event, or a turn that is too long."""
        shape = (steps.number, places, -1)
        margins = self._watch.margins(states).reshape(shape)
        may_meet = (margins <= 0.0).any(axis=(1, 2))
        changes = np.abs(np.diff(margins[..., -1], axis=1)).max(axis=1)
        may_meet |= margins[..., -1].min(axis=1) < DIP * changes
        speeds = self._watch.speeds(states).reshape(shape)
        if speeds.shape[2]:
            between = np.diff(steps.times)[:, None] / (places - 1)
            way = np.abs(speeds).max(axis=1) * between
            may_meet |= (margins[..., :-1].min(axis=1) < DIP * way).any(axis=1)
        too_long = self._bound.are_too_long(states, steps.s[:-1], steps.R[:-1], places)
        return np.asarray(may_meet | too_long)


def _places(steps: Steps, count: int) -> tuple[Array, NDArray[np.int64], Array]:
    """Times (K, count) of places of each step, and of all places: step (N,) and state (N, m)."""
    lengths = np.diff(steps.times)
    times = steps.times[:-1, None] + np.linspace(0.0, 1.0, count) * lengths[:, None]
    times[:, -1] = steps.times[1:]
    numbers = np.arange(steps.number, dtype=np.int64).repeat(count)
    return times, numbers, steps.at(numbers, times.ravel())


def step_of(batch: Batch, number: int, robot: Robot) -> Step:
    """One step of a batch, for a search of its events."""
    steps, start = batch.steps, batch.start(number)
    n = len(start.u)

    def dense(t: float) -> Array:
        row: Array = steps.at(np.array([number]), np.array([t]))[0]
        return row

    def at(t: float) -> ClosedState:
        y = dense(t)
        return robot.close(y[:n], y[n : 2 * n], check=False, near=start)

    return Step(batch.times[number], batch.places(number), at, dense)


def anchors_of(steps: Steps, numbers: NDArray[np.int64], start: ClosedState) -> Anchors:
    """The closed configurations at the starts of steps (N,)."""
    signs = np.broadcast_to(start.signs, (len(numbers), len(start.signs)))
    return Anchors(steps.s[numbers], steps.R[numbers], signs)
