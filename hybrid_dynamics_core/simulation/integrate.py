"""Integration of the equations of motion in minimal coordinates.

The loops are closed at every step, so there is no drift. The integrated state is (u, u', work).
Work is the energy from tau and applied wrenches, minus the losses by friction. So the robot's
energy minus the work is constant up to the integrator's error.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DenseOutput, OdeSolver

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import finite_vectors
from ..ground.progress import Progress
from ..limits import Limits, saturated
from ..robot.robot import Robot
from ..robot.taken import AnyRobot, robot_of
from .events import Event, Watch
from .result import Simulation
from .search import Step, first_event
from .settings import METHODS, Settings, checked_span
from .step_bound import StepBound

Efforts = Callable[[float, ClosedState], ArrayLike]  # (t [s], state) -> tau (n,)
Span = tuple[float, float]  # start and end [s]
MOST_SAMPLES = 10_000_000
PLACES = 9  # least number of samples in a step: the degree of DOP853's output plus one


def simulate(
    robot: AnyRobot,
    u: ArrayLike | ClosedState,
    du: ArrayLike | None = None,
    tau: ArrayLike | Efforts | None = None,
    t_span: tuple[float, float] = (0.0, 10.0),
    settings: Settings | None = None,
) -> Simulation:
    """Simulate the motion from an initial state under efforts tau.

    Args:
        robot: the model, or its description.
        u: (n,) active coordinates [rad or m], or a ClosedState.
        du: (n,) active rates [rad/s or m/s]; zero if None.
        tau: efforts [N m or N]: None for zero, a constant (n,), or a function of time [s] and
            ClosedState that returns (n,). The function must be free of memory, unless
            `settings.hold` is given: then it is called once a period, in order.
        t_span: start and end [s].
        settings: tolerances, sampling, and when to stop.

    Returns:
        The recorded motion. It ends early at a limit or singular configuration, see its `events`.

    Raises:
        InputError: an argument is wrong.
        ClosureError: the start does not close.
        MassSingularityError: the mass matrix is singular.
    """
    robot = robot_of(robot)
    if settings is None:
        settings = Settings()
    _check_order(du, tau, t_span, settings)
    span = checked_span(t_span)
    start = u if isinstance(u, ClosedState) else robot.close(u, du)
    if start.u.ndim != 1:
        raise InputError("a simulation starts from one state, not from a batch")
    if callable(tau):
        _check_takes(tau, start)
    run = _Run(robot, start, tau, span, settings)
    duration = span[1] - span[0]
    with Progress(f"simulating {robot.name}", duration, settings.progress) as progress:
        run.integrate(progress)
    return run.result()


def _check_order(du: object, tau: object, t_span: object, settings: object) -> None:
    """Raise a clear error if positional arguments are shifted because one was left out."""
    order = "simulate(robot, u, du, tau, t_span, settings)"
    if isinstance(t_span, Settings):
        raise InputError(f"t_span is of type Settings; the order is {order}: is `du` left out?")
    if callable(du) or isinstance(du, Settings):
        raise InputError(f"du is of type {type(du).__name__}; the order is {order}")
    if isinstance(tau, Settings):
        raise InputError(f"tau is of type Settings; the order is {order}")
    require_type("settings", settings, Settings, "Settings(rate=100.0)")


class _Sample(NamedTuple):
    """A recorded sample: time [s], y = (u, u', work), and a closed state near it."""

    t: float
    y: Array
    near: ClosedState


class _Run:
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
        self.watch = Watch(robot, settings.singular)
        self.watch.check_start(start)
        self.bound = StepBound(robot, settings.max_step)
        self.tau = tau if callable(tau) else _constant(tau, robot)
        if settings.saturate:
            self.tau = _saturating(robot, self.tau)
        self.held: Array | None = None  # tau of the present period
        self.anchor = start  # the last accepted state
        self.motion = robot.motion_near(start, settings.loads)
        self.y = np.concatenate([start.u, start.du, [0.0]])
        self.times = _sample_times(span, settings.rate)
        self.samples = [_Sample(span[0], self.y, start)]
        self.efforts: list[Array] = []
        self.events: list[Event] = []
        self.steps = self.evaluations = 0
        self.message = "the end of the time span was reached"
        self.done = False

    def integrate(self, progress: Progress) -> None:
        """Integrate over the span; period by period if tau is held."""
        hold = self.settings.hold
        if hold is None:
            tau = self._evaluate_tau(self.span[0], self.anchor)
            self.efforts.append(tau)
            self._integrate_period(*self.span, progress)
            return
        for begin, end in _periods(self.span, hold):
            self.held = self._evaluate_tau(begin, self.anchor)
            if not self.efforts:
                self.efforts.append(self.held)
            self._integrate_period(begin, end, progress)
            if self.done:
                return

    def _integrate_period(self, begin: float, end: float, progress: Progress) -> None:
        solver = self._solver(begin, end)
        while solver.status == "running" and not self.done:
            # integrators read this before each step, LSODA only at its start
            solver.max_step = self.bound.longest(self.anchor)
            try:
                problem = solver.step()
            except (ValueError, np.linalg.LinAlgError) as error:  # an implicit method met NaN
                problem = str(error)
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
            if self._recentre():
                solver = self._solver(solver.t, end)
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
            max_step=self.bound.longest(self.anchor),
        )

    def _slope(self, t: float, y: Array) -> Array:
        self.evaluations += 1
        u, du = self._split(y)
        tau = self.held
        if tau is None:
            state = self._state_for_tau(u, du)
            if state.status is not ClosureStatus.OK:
                return np.full_like(y, np.nan)
            tau = self._evaluate_tau(t, state)
        ddu, power = self.motion(u, du, tau)
        return np.concatenate([du, ddu, [power]])

    def _split(self, y: Array) -> tuple[Array, Array]:
        n = len(self.anchor.u)
        return y[:n], y[n : 2 * n]

    def _state_for_tau(self, u: Array, du: Array) -> ClosedState:
        """The state for the function of efforts; an arbitrary one if tau is constant."""
        if callable(self.tau):
            return self._near(u, du)
        return self.anchor

    def _evaluate_tau(self, t: float, state: ClosedState) -> Array:
        if not callable(self.tau):
            return self.tau
        tau = self.tau(t, state)
        return finite_vectors("tau", tau, self.robot.active, -1)

    def _near(self, u: Array, du: Array) -> ClosedState:
        return self.robot.close(u, du, check=False, near=self.anchor)

    def _step(self, begin: float, end: float, dense: DenseOutput) -> Step:
        """The step's dense output, sampled densely enough to find events inside."""

        def at(t: float) -> ClosedState:
            return self._near(*self._split(dense(t)))

        times = np.linspace(begin, end, PLACES)
        y = dense(times).T
        times = np.linspace(begin, end, PLACES + self.bound.more_places(self.anchor, y))
        y = dense(times).T
        n = len(self.anchor.u)
        return Step(times, self._near(y[:, :n], y[:, n : 2 * n]), at, dense)

    def _accept(self, step: Step) -> None:
        """Accept a step: find its events, record its samples, and continue from its end."""
        begin = step.times[0]
        end = self._watch_step(step)
        within = (self.times > begin) & (self.times <= end)
        for t in self.times[within]:
            self._record(float(t), step.dense(t))
        self.y = step.dense(end)
        if self.done and self.samples[-1].t < end:
            self._record(end, self.y)
        self.anchor = step.at(end)
        if self.anchor.status is not ClosureStatus.OK:
            self._stop(end, "the loops no longer close on their branch")
            return
        self.motion = self.robot.motion_near(self.anchor, self.settings.loads)

    def _recentre(self) -> bool:
        """Change the charts of ball and free joints that are near their singularity."""
        if self.done or not self.robot.middle_turns:
            return False
        recentred = self.robot.recentred(self.anchor)
        if recentred is self.anchor:
            return False
        self.anchor = recentred
        self.y = np.concatenate([recentred.u, recentred.du, self.y[-1:]])
        self.motion = self.robot.motion_near(recentred, self.settings.loads)
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
            self.events.append(event)
            if self.settings.stop_at_limits or not self.watch.is_limit(index):
                self._stop(time, event.message)
                return time
            ignored.append(index)

    def _record(self, t: float, y: Array) -> None:
        self.samples.append(_Sample(t, y, self.anchor))
        tau = self.held
        if tau is None:
            state = self._state_for_tau(*self._split(y))
            tau = self._evaluate_tau(t, state)
        self.efforts.append(tau)

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
        """The recorded motion, with its states closed as a batch."""
        y = np.array([sample.y for sample in self.samples])
        state = self._closed_batch(y)
        tau = np.array(self.efforts)
        loads = self.settings.loads
        return Simulation(
            robot=self.robot.name,
            t=np.array([sample.t for sample in self.samples]),
            state=state,
            ddu=self.robot.forward_dynamics(state, tau, loads),
            tau=tau,
            energy=self.robot.energy(state, loads),
            work=y[:, -1],
            events=tuple(self.events),
            message=self.message,
            completed=not self.done,
            steps=self.steps,
            evaluations=self.evaluations,
            names=self.robot.active,
            coordinates=self.robot.coordinates,
        )

    def _closed_batch(self, y: Array) -> ClosedState:
        """The states of all samples (N, 2 n + 1) as a batch."""
        n = len(self.anchor.u)
        s = np.array([sample.near.s for sample in self.samples])
        R = np.array([sample.near.R for sample in self.samples])
        signs = np.array([sample.near.signs for sample in self.samples])
        if (signs == signs[0]).all():
            signs = self.samples[0].near.signs
        near = replace(self.samples[0].near, s=s, R=R, signs=signs)
        u, du = y[:, :n], y[:, n : 2 * n]
        return self.robot.close(u, du, near=near)


def _check_takes(tau: Efforts, state: ClosedState) -> None:
    """Raise if a function of efforts does not take a time and a state."""
    try:
        inspect.signature(tau).bind(0.0, state)
    except TypeError as error:
        raise InputError(f"tau: expected a function of (t, state): {error}") from error
    except ValueError:  # a builtin has no signature
        return


def _saturating(robot: Robot, tau: Array | Efforts) -> Efforts:
    """Efforts as a function, no more than the drives give."""
    limits = Limits(robot)

    def given(t: float, state: ClosedState) -> Array:
        asked = tau(t, state) if callable(tau) else tau
        checked = finite_vectors("tau", asked, robot.active, -1)
        return saturated(limits, state, checked)

    return given


def _constant(tau: ArrayLike | None, robot: Robot) -> Array:
    if tau is None:
        return np.zeros(len(robot.active))
    return finite_vectors("tau", tau, robot.active, -1)


def _sample_times(span: Span, rate: float) -> Array:
    """Times at which samples are recorded [s], the end of the span included."""
    start, end = span
    count = int(np.floor((end - start) * rate + 1e-9)) + 1
    if count > MOST_SAMPLES:
        raise InputError(
            f"rate is {rate:g}: {count:.3g} samples in {end - start:g} s; expected at most"
            f" {MOST_SAMPLES:.0e}"
        )
    times = start + np.arange(count) / rate
    if times[-1] >= end - 1e-12 * abs(end):
        return times
    return np.append(times, end)


def _periods(span: Span, hold: float) -> Iterator[Span]:
    """Start and end of each period of a digital controller [s]."""
    start, end = span
    count = int(np.ceil((end - start) / hold - 1e-9))
    for k in range(count):
        begin = start + k * hold
        until = min(end, start + (k + 1) * hold)
        yield begin, until
