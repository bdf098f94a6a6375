"""Integration of the equations of motion in minimal coordinates: the loops are closed at every step, so nothing drifts.

The state integrated is (u, u', work): work is the energy that tau and applied wrenches bring in and
friction takes out, so that the energy of the robot less the work stays what it was, but for the
integrator's error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from ..ground.progress import Progress
from ..robot.robot import Robot
from .events import Event, Watch
from .result import Simulation
from .settings import METHODS, Settings, checked_span

Efforts = Callable[[float, ClosedState], ArrayLike]  # (t [s], state) -> tau (n,)


def simulate(
    robot: Robot,
    u: ArrayLike | ClosedState,
    du: ArrayLike | None = None,
    tau: ArrayLike | Efforts | None = None,
    t_span: tuple[float, float] = (0.0, 10.0),
    settings: Settings | None = None,
) -> Simulation:
    """The motion from active coordinates u and rates du (zero if None), or from a ClosedState, under efforts tau.

    tau: None (none), constant (n,), or a function of time [s] and ClosedState that returns (n,) and
    keeps no memory
        (unless `settings.hold` is given: then it is called once a period, in order).

    Returns the recorded motion; it ends early where a limit or singular configuration is met, see
    its `events`. Raises InputError for bad arguments, ClosureError where the start does not close,
    MassSingularityError.
    """
    settings = settings or Settings()
    span = checked_span(t_span)
    start = u if isinstance(u, ClosedState) else robot.close(u, du)
    if start.u.ndim != 1:
        raise InputError("a simulation starts from one state, not from a batch")
    run = _Run(robot, start, tau, span, settings)
    with Progress(f"simulating {robot.name}", span[1] - span[0], settings.progress) as progress:
        run.go(progress)
    return run.result()


class _Run:
    def __init__(
        self,
        robot: Robot,
        start: ClosedState,
        tau: ArrayLike | Efforts | None,
        span: tuple[float, float],
        settings: Settings,
    ) -> None:
        self.robot, self.settings, self.span = robot, settings, span
        self.watch = Watch(robot, settings.singular)
        self.watch.check_start(start)
        self.tau = tau if callable(tau) else _constant(tau, robot)
        self.held: Array | None = None  # tau of the present period
        self.anchor = start  # the last accepted state
        self.motion = robot.motion_near(start, settings.loads)
        self.y = np.concatenate([start.u, start.du, [0.0]])
        count = int(np.floor((span[1] - span[0]) * settings.rate + 1e-9)) + 1
        times = span[0] + np.arange(count) / settings.rate
        self.times = (
            times if times[-1] >= span[1] - 1e-12 * abs(span[1]) else np.append(times, span[1])
        )
        self.rows: list[tuple[float, Array, ClosedState]] = [(span[0], self.y, start)]
        self.efforts: list[Array] = []
        self.events: list[Event] = []
        self.steps = self.evaluations = 0
        self.message = "the end of the time span was reached"
        self.done = False

    def go(self, progress: Progress) -> None:
        """Integrate over the span, period by period where tau is held."""
        start, end = self.span
        hold = self.settings.hold
        count = 1 if hold is None else int(np.ceil((end - start) / hold - 1e-9))
        if hold is None:
            self.efforts.append(self._asked(start, self.anchor))
        for k in range(count):
            until = end if hold is None else min(end, start + (k + 1) * hold)
            begin = start if hold is None else start + k * hold
            if hold is not None:
                self.held = self._asked(begin, self.anchor)
                if k == 0:
                    self.efforts.append(self.held)
            self._integrate(begin, until, progress)
            if self.done:
                return

    def _integrate(self, begin: float, until: float, progress: Progress) -> None:
        s = self.settings
        method = METHODS[s.method]
        solver = method(
            self._slope, begin, self.y, until, rtol=s.rtol, atol=s.atol, max_step=s.max_step
        )
        while solver.status == "running" and not self.done:
            try:
                problem = solver.step()
            except (ValueError, np.linalg.LinAlgError) as error:  # an implicit method met NaN
                problem = str(error)
            if problem is not None or solver.status == "failed":
                self._stuck(solver.t, str(problem))
                return
            self.steps += 1
            self._accept(solver.t_old, solver.t, solver.dense_output())
            progress.update(solver.t - self.span[0])

    def _slope(self, t: float, y: Array) -> Array:
        self.evaluations += 1
        n = len(self.anchor.u)
        u, du = y[:n], y[n : 2 * n]
        tau = self.held
        if tau is None:
            state = self.anchor if not callable(self.tau) else self._near(u, du)
            if state.status is not ClosureStatus.OK:
                return np.full_like(y, np.nan)
            tau = self._efforts(t, state)
        ddu, power = self.motion(u, du, tau)
        return np.concatenate([du, ddu, [power]])

    def _efforts(self, t: float, state: ClosedState) -> Array:
        return self._asked(t, state) if self.held is None else self.held

    def _asked(self, t: float, state: ClosedState) -> Array:
        if not callable(self.tau):
            return self.tau
        return finite_vectors("tau", self.tau(t, state), self.robot.active, -1)

    def _near(self, u: Array, du: Array) -> ClosedState:
        return self.robot.close(u, du, check=False, near=self.anchor)

    def _accept(self, old: float, new: float, dense: Callable[[float], Array]) -> None:
        """Take a step over: look for events in it, keep its samples, go on from its end."""
        n = len(self.anchor.u)

        def at(t: float) -> ClosedState:
            y = dense(t)
            return self._near(y[:n], y[n : 2 * n])

        ignored: list[int] = []
        while (found := self.watch.find(self.anchor, at, (old, new), ignored)) is not None:
            index, time = found
            self.events.append(self.watch.event(index, time, at(time)))
            if self.settings.stop_at_limits or not self.watch.is_limit(index):
                self._stop(time, self.events[-1].message)
                new = time
                break
            ignored.append(index)
        for t in self.times[(self.times > old) & (self.times <= new)]:
            self._keep(float(t), dense(t))
        self.y = dense(new)
        if self.done and self.rows[-1][0] < new:
            self._keep(new, self.y)
        self.anchor = at(new)
        if self.anchor.status is not ClosureStatus.OK:
            self._stop(new, "the loops no longer close on their branch")
            return
        self.motion = self.robot.motion_near(self.anchor, self.settings.loads)

    def _keep(self, t: float, y: Array) -> None:
        n = len(self.anchor.u)
        self.rows.append((t, y, self.anchor))
        state = (
            self._near(y[:n], y[n : 2 * n])
            if callable(self.tau) and self.held is None
            else self.anchor
        )
        self.efforts.append(self._efforts(t, state))

    def _stop(self, time: float, message: str) -> None:
        self.done, self.message = True, f"ended at t = {time:.6g} s: {message}"

    def _stuck(self, time: float, problem: str) -> None:
        near = (
            f"loop '{self.anchor.singular_loop}' is {self.anchor.singularity:.3g} from a singular"
            " configuration"
        )
        self._stop(time, f"the integrator found no step on ({problem.rstrip('.')}); {near}")

    def result(self) -> Simulation:
        """Everything recorded, closed again as a batch."""
        n = len(self.anchor.u)
        t = np.array([row[0] for row in self.rows])
        y = np.array([row[1] for row in self.rows])
        anchors = [row[2] for row in self.rows]
        near = replace(
            anchors[0], s=np.array([a.s for a in anchors]), R=np.array([a.R for a in anchors])
        )
        state = self.robot.close(y[:, :n], y[:, n : 2 * n], near=near)
        tau, loads = np.array(self.efforts), self.settings.loads
        return Simulation(
            robot=self.robot.name,
            t=t,
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


def _constant(tau: ArrayLike | None, robot: Robot) -> Array:
    return (
        np.zeros(len(robot.active)) if tau is None else finite_vectors("tau", tau, robot.active, -1)
    )
