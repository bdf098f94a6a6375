"""One run of the integrator: its steps, samples and events."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DenseOutput, OdeSolver

from ..closed_state.state import ClosedState, ClosureStatus
from ..dynamics.energy import Energy
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
from .compiled import Batch, CompiledIntegrator, anchors_of, step_of
from .events import Event, Watch, passage_event
from .passing.choice import CoordinateChoice, require_fixed_charts
from .passing.coordinates import Coordinates
from .result import Simulation
from .samples import Samples
from .search import Step, first_event
from .settings import COMPILED, METHODS, Settings
from .step_bound import PLACES, StepBound


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
            require_fixed_charts(robot)
            self.choice = CoordinateChoice(robot, settings.loads, settings.singular)
        self._watch_coordinates()
        self.watch.check_limits(start)
        self.tau = tau if callable(tau) else constant(tau, robot)
        if settings.saturate:
            self.tau = saturating(robot, self.tau)
        self.held: Array | None = None  # tau of the present period
        self.y = np.concatenate([start.u, start.du, [0.0]])
        self.times = sample_times(span, settings.rate)
        self.samples = Samples()
        self.events: list[Event] = []
        self.steps = self.evaluations = 0
        self.message = "the end of the time span was reached"
        self.done = False
        self.time = span[0]
        self.compiled = self._compiled()
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

    def _compiled(self) -> CompiledIntegrator | None:
        """The integrator in compiled code, where the motion allows it."""
        settings = self.settings
        if settings.method != COMPILED or settings.through_change_points or self.robot.middle_turns:
            return None
        if callable(self.tau) and settings.hold is None:
            return None
        steps = self.robot.motion_steps(settings.loads)
        if steps is None:
            return None
        return CompiledIntegrator(self.robot, steps, settings, self.watch, self.bound, self.span)

    def integrate(self, progress: Progress) -> None:
        """Integrate over the span; period by period if tau is held."""
        hold = self.settings.hold
        if hold is None:
            self._record_start()
            self._integrate_period(self.span[1], progress)
            return
        for begin, end in periods(self.span, hold):
            self.held = self._evaluate_tau(begin, self.coordinates.simulated_state(self.anchor))
            if not self.samples:
                self._record_start()
            self._integrate_period(end, progress)
            if self.done:
                return

    def _integrate_period(self, end: float, progress: Progress) -> None:
        while self._take_compiled_steps(end):
            progress.update(self.time - self.span[0])
        if not self.done and self.time < end:
            self._integrate_step_by_step(end, progress)

    def _integrate_step_by_step(self, end: float, progress: Progress) -> None:
        """Integrate with a method of SciPy."""
        solver = self._solver(self.time, end)
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

    def _take_compiled_steps(self, end: float) -> bool:
        """Take steps in compiled code; whether it made any."""
        tau = self.tau if self.held is None else self.held
        if self.compiled is None or callable(tau) or self.done or self.time >= end:
            return False
        batch = self.compiled.advance(self.anchor, self.y, tau, (self.time, end))
        if batch is None:
            return False
        steps = batch.steps
        self.evaluations += steps.evaluations
        self._accept_clear(batch, tau)
        if batch.clear == steps.number:
            return True
        step = step_of(batch, batch.clear, self.robot)
        if self.bound.is_too_long(self.anchor, step.states):
            self.bound.shorten(step.times[-1] - step.times[0])
            return True
        self.steps += 1
        self._accept(step)
        return True

    def _accept_clear(self, batch: Batch, tau: Array) -> None:
        """Accept the steps of a batch that have no event."""
        if not batch.clear:
            return
        steps = batch.steps
        end = float(steps.times[batch.clear])
        times = self.times[(self.times > self.time) & (self.times <= end)]
        numbers = np.searchsorted(steps.times, times).astype(np.int64) - 1
        anchors = anchors_of(steps, numbers, self.anchor)
        self.samples.add_rows(self.coordinates, times, steps.at(numbers, times), tau, anchors)
        self.steps += batch.clear
        self.bound.relax(batch.clear)
        self.time, self.y = end, steps.y[batch.clear]
        self.coordinates.move_to(batch.end(batch.clear - 1))

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
        return self.coordinates.simulated_state(state)

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
        if self.done and self.samples.last_time < end:
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
        if self.samples.last_time < self.time:
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
        self.samples.add(self.coordinates, t, y, tau, self.anchor)

    def _record_start(self) -> None:
        """Record the first sample."""
        tau = self.held
        if tau is None:
            tau = self._evaluate_tau(self.span[0], self.coordinates.simulated_state(self.anchor))
        self.samples.add(self.coordinates, self.span[0], self.y, tau, self.anchor)

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
        parts = list(self.samples.recorded())
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
            t=self.samples.times(),
            state=state,
            ddu=ddu,
            tau=self.samples.efforts(),
            energy=energies,
            work=self.samples.work(),
            events=tuple(events),
            message=self.message,
            completed=not self.done,
            steps=self.steps,
            evaluations=self.evaluations,
            names=self.robot.active,
            coordinates=self.robot.coordinates,
        )


class _NearSingular(NamedTuple):
    """An event near a singular place, before it is decided whether the motion passes it.

    Attributes:
        event: the event.
        level: distance to the place at which it was met.
    """

    event: Event
    level: float
