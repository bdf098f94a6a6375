"""One run of the integrator: its steps, samples and events."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DenseOutput, OdeSolver

from ..closed_state.state import ClosedState, ClosureStatus
from ..dynamics.energy import Energy
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from ..ground.progress import Progress
from ..robot.robot import Robot
from .arguments import (
    Efforts,
    Span,
    constant,
    periods,
    sample_times,
    saturating,
)
from .events import Event, Watch, passage_event
from .passing.choice import CoordinateChoice
from .passing.coordinates import Coordinates, Recorded
from .result import Simulation
from .search import Step, first_event
from .settings import METHODS, Settings
from .step_bound import StepBound

PLACES = 9  # least number of samples in a step: the degree of DOP853's output plus one


class _Sample(NamedTuple):
    """A recorded sample: time [s], y = (u, u', work), its coordinates and a closed state near it.

    It also has the efforts (n,) of the simulated robot.
    """

    t: float
    y: Array
    coordinates: Coordinates
    near: ClosedState
    tau: Array


class Run:
    """A running simulation."""

    def __init__(
        self,
        robot: Robot,
        start: ClosedState,
        tau: ArrayLike | Efforts | None,
        span: Span,
        settings: Settings,
    ) -> None:
        self.robot = robot
        self.settings = settings
        self.span = span
        self.coordinates = Coordinates(robot, start, settings.loads)
        self.choice: CoordinateChoice | None = None
        if settings.through_change_points:
            _require_fixed_charts(robot)
            self.choice = CoordinateChoice(robot, settings.loads, settings.singular)
        self._watch_coordinates()
        self.watch.check_limits(start)
        self.tau = tau if callable(tau) else constant(tau, robot)
        if settings.saturate:
            self.tau = saturating(robot, self.tau)
        self.held: Array | None = None  # tau of the present period
        self.y = np.concatenate([start.u, start.du, [0.0]])
        self.times = sample_times(span, settings.rate)
        self.samples: list[_Sample] = []
        self.events: list[Event] = []
        self.steps = self.evaluations = 0
        self.message = "the end of the time span was reached"
        self.done = False
        self.time = span[0]
        self.near_singular: _NearSingular | None = None
        if self.choice is None or not self._change_coordinates():
            Watch(robot, settings.singular).check_singularity(start)

    @property
    def anchor(self) -> ClosedState:
        """The last accepted state."""
        return self.coordinates.anchor

    def _watch_coordinates(self) -> None:
        """Events and bounds of steps in the present coordinates."""
        level = self.settings.singular
        if self.choice is not None:
            level = self.choice.level(self.coordinates)
        self.watch = Watch(self.coordinates.robot, level)
        self.bound = StepBound(self.coordinates.robot, self.settings.max_step)

    def integrate(self, progress: Progress) -> None:
        """Integrate over the span; period by period if tau is held."""
        hold = self.settings.hold
        if hold is None:
            self._record_start()
            self._integrate_period(*self.span, progress)
            return
        for begin, end in periods(self.span, hold):
            self.held = self._evaluate_tau(begin, self.coordinates.at_home(self.anchor))
            if not self.samples:
                self._record_start()
            self._integrate_period(begin, end, progress)
            if self.done:
                return

    def _integrate_period(self, begin: float, end: float, progress: Progress) -> None:
        solver = self._solver(begin, end)
        while solver.status == "running" and not self.done:
            # integrators read this before each step, LSODA only at its start
            solver.max_step = self._longest()
            try:
                problem = solver.step()
            except (ValueError, np.linalg.LinAlgError) as error:  # an implicit method met NaN
                problem = str(error)
            if not np.isfinite(solver.y).all():  # LSODA takes NaN for a step
                problem = "its step is not finite"
            if problem is not None or solver.status == "failed":
                self._fail(solver.t, str(problem))
                return
            step = self._step(solver.t_old, solver.t, solver.dense_output())
            if self.bound.is_too_long(self.anchor, step.states):
                self.bound.shorten(solver.t - solver.t_old)
                solver = self._solver(solver.t_old, end)
                continue
            self.bound.relax()
            self.steps += 1
            self._accept(step)
            if self._recentre() or self._pass_on(step):
                solver = self._solver(self.time, end)
            progress.update(solver.t - self.span[0])

    def _solver(self, begin: float, end: float) -> OdeSolver:
        """The integrator, from the present state."""
        return METHODS[self.settings.method](
            self._slope,
            begin,
            self.y,
            end,
            rtol=self.settings.rtol,
            atol=self.settings.atol,
            max_step=self._longest(),
        )

    def _longest(self) -> float:
        """The longest step from the present state [s]."""
        return min(self.bound.longest(self.anchor), self.coordinates.longest(self.anchor.du))

    def _slope(self, t: float, y: Array) -> Array:
        self.evaluations += 1
        if not np.isfinite(y).all():  # an earlier stage of the step did not close
            return np.full_like(y, np.nan)
        u, du = self._split(y)
        tau = self.held
        if tau is None:
            state = self._state_for_tau(u, du)
            if not np.isfinite(state.s).all():
                return np.full_like(y, np.nan)
            tau = self._evaluate_tau(t, state)
        ddu, power = self.coordinates.motion(u, du, tau)
        return np.concatenate([du, ddu, [power]])

    def _split(self, y: Array) -> tuple[Array, Array]:
        n = len(self.anchor.u)
        return y[:n], y[n : 2 * n]

    def _state_for_tau(self, u: Array, du: Array) -> ClosedState:
        """The state for the function of efforts; an arbitrary one if tau is constant."""
        if not callable(self.tau):
            return self.anchor
        state = self.coordinates.near(u, du)
        if state.status is not ClosureStatus.OK:
            return state
        return self.coordinates.at_home(state)

    def _evaluate_tau(self, t: float, state: ClosedState) -> Array:
        if not callable(self.tau):
            return self.tau
        tau = self.tau(t, state)
        return finite_vectors("tau", tau, self.robot.active, -1)

    def _step(self, begin: float, end: float, dense: DenseOutput) -> Step:
        """The step's dense output, sampled densely enough to find events inside."""

        def at(t: float) -> ClosedState:
            return self.coordinates.near(*self._split(dense(t)))

        times = np.linspace(begin, end, PLACES)
        y = dense(times).T
        times = np.linspace(begin, end, PLACES + self.bound.more_places(self.anchor, y))
        y = dense(times).T
        n = len(self.anchor.u)
        return Step(times, self.coordinates.near(y[:, :n], y[:, n : 2 * n]), at, dense)

    def _accept(self, step: Step) -> None:
        """Accept a step: find its events, record its samples, and continue from its end."""
        begin = step.times[0]
        end = self.time = self._watch_step(step)
        within = (self.times > begin) & (self.times <= end)
        for t in self.times[within]:
            self._record(float(t), step.dense(t))
        self.y = step.dense(end)
        if self.done and self.samples[-1].t < end:
            self._record(end, self.y)
        state = step.at(end)
        self.coordinates.move_to(state)
        if state.status is not ClosureStatus.OK:
            self._stop(end, "the loops no longer close on their branch")

    def _recentre(self) -> bool:
        """Change the charts of ball and free joints that are near their singularity."""
        if self.done or not self.robot.middle_turns:
            return False
        recentred = self.robot.recentred(self.anchor)
        if recentred is self.anchor:
            return False
        self.coordinates.move_to(recentred)
        self.y = np.concatenate([recentred.u, recentred.du, self.y[-1:]])
        return True

    def _pass_on(self, step: Step) -> bool:
        """Record passages of a step; whether the integrator has to begin anew after it."""
        if self.choice is None:
            return False
        for time, passed in self.coordinates.passed(step):
            if time <= self.time:
                passage = self.robot.singular_places.recorded(passed)
                self.events.append(passage_event(time, passage))
        if self.done:
            return False
        return self._change_coordinates() or self._decide(self.choice)

    def _decide(self, choice: CoordinateChoice) -> bool:
        """Go on at a lower level, or end, if a singular place was met; whether it was."""
        if self.near_singular is None:
            return False
        (event, level), self.near_singular = self.near_singular, None
        if choice.level(self.coordinates) < level:
            self._watch_coordinates()
            return True
        self.events.append(event)
        self._stop(self.time, event.message)
        if self.samples[-1].t < self.time:
            self._record(self.time, self.y)
        return True

    def _change_coordinates(self) -> bool:
        """Take the best coordinates at the last accepted state; whether they changed."""
        if self.choice is None:
            return False
        following = self.choice.following(self.coordinates)
        if following is None:
            return False
        self.near_singular = None
        self.coordinates = following
        self.y = np.concatenate([self.anchor.u, self.anchor.du, self.y[-1:]])
        self._watch_coordinates()
        return True

    def _watch_step(self, step: Step) -> float:
        """Record the events of a step; returns its end, or the time of the event that ends it."""
        ignored: list[int] = []
        while True:
            met = first_event(self.watch, step, ignored)
            if met is None:
                return float(step.times[-1])
            index, time = met
            event = self.watch.event(index, time, step.at(time))
            if self.choice is not None and not self.watch.is_limit(index):
                self.near_singular = _NearSingular(event, self.watch.singular)
                return time
            self.events.append(event)
            if self.settings.stop_at_limits or not self.watch.is_limit(index):
                self._stop(time, event.message)
                return time
            ignored.append(index)

    def _record(self, t: float, y: Array) -> None:
        tau = self.held
        if tau is None:
            state = self._state_for_tau(*self._split(y))
            tau = self._evaluate_tau(t, state)
        self.samples.append(_Sample(t, y, self.coordinates, self.anchor, tau))

    def _record_start(self) -> None:
        """Record the first sample."""
        tau = self.held
        if tau is None:
            tau = self._evaluate_tau(self.span[0], self.coordinates.at_home(self.anchor))
        self.samples.append(_Sample(self.span[0], self.y, self.coordinates, self.anchor, tau))

    def _stop(self, time: float, message: str) -> None:
        self.done = True
        self.message = f"ended at t = {time:.6g} s: {message}"

    def _fail(self, time: float, problem: str) -> None:
        near = (
            f"loop '{self.anchor.singular_loop}' is {self.anchor.singularity:.3g} from a singular"
            " configuration"
        )
        self._stop(time, f"the integrator found no step on ({problem.rstrip('.')}); {near}")

    def result(self) -> Simulation:
        """The recorded motion, with its states closed as batches."""
        parts = list(self._recorded_parts())
        state, ddu, energies = parts[0]
        if len(parts) > 1:
            state = ClosedState.joined([part.state for part in parts])
            ddu = np.concatenate([part.ddu for part in parts])
            columns = zip(*[part.energy for part in parts], strict=True)
            energies = Energy(*[np.concatenate(column) for column in columns])
        events = sorted(self.events, key=lambda event: event.time)
        passages = [event.passage for event in events if event.passage is not None]
        if passages:
            state = replace(state, passages=tuple(passages))
        return Simulation(
            robot=self.robot.name,
            t=np.array([sample.t for sample in self.samples]),
            state=state,
            ddu=ddu,
            tau=np.array([sample.tau for sample in self.samples]),
            energy=energies,
            work=np.array([sample.y[-1] for sample in self.samples]),
            events=tuple(events),
            message=self.message,
            completed=not self.done,
            steps=self.steps,
            evaluations=self.evaluations,
            names=self.robot.active,
            coordinates=self.robot.coordinates,
        )

    def _recorded_parts(self) -> Iterator[Recorded]:
        """What is recorded, by the coordinates in which it was integrated."""
        for coordinates, samples in groupby(self.samples, key=lambda sample: sample.coordinates):
            _, y, _, anchors, tau = zip(*samples, strict=True)
            yield coordinates.recorded(np.array(y), anchors, np.array(tau))


class _NearSingular(NamedTuple):
    """An event near a singular place, before it is decided whether the motion passes it.

    Attributes:
        event: the event.
        level: distance to the place at which it was met.
    """

    event: Event
    level: float


def _require_fixed_charts(robot: Robot) -> None:
    """Raise InputError for robots whose angles change their chart on the way."""
    if robot.middle_turns:
        raise InputError(
            "through_change_points: this robot has ball or free joints, whose angles change their"
            " chart on the way; expected a robot without them"
        )
