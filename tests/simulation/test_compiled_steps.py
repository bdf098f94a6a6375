"""Steps in compiled code against SciPy's DOP853, which integrates where efforts are a function.

Both keep the same tolerance. So they differ by what a motion makes of it, far below 1e-6.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import (
    ClosedState,
    InputError,
    Loads,
    MassSingularityError,
    Robot,
    load,
)
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.kernels.run import is_native
from hybrid_dynamics_core.robot.motion import motions
from hybrid_dynamics_core.robot.motion.steps import StepControl, Steps
from hybrid_dynamics_core.simulation import Settings, Simulation, simulate
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.laws.inputs.ask import near
from tests.laws.inputs.of_motion import heavy, moving
from tests.robots import random_states, robot
from tests.sampling import swept

NAMES = ("excavator", "forging_chu2020", "gough", "palletizer", "ankle", "three_rrr", "rssr")
FINE = Settings(rtol=1e-11, atol=1e-13, rate=200.0)
compiled = pytest.mark.skipif(not is_native(), reason="there is no compiled code here")


def both_ways(
    machine: Robot, u: Array, du: Array, tau: Array, end: float, settings: Settings = FINE
) -> tuple[Simulation, Simulation]:
    """The motion under constant efforts, and under a function that returns them."""
    span = (0.0, end)
    at_once = simulate(machine, u, du, tau, span, settings)
    one_by_one = simulate(machine, u, du, lambda _t, _state: tau, span, settings)
    return at_once, one_by_one


def assert_same(at_once: Simulation, one_by_one: Simulation) -> None:
    """Same samples, work and events."""
    assert len(at_once.t) == len(one_by_one.t)
    np.testing.assert_allclose(at_once.t, one_by_one.t, atol=1e-8)
    for name in ("s", "ds"):
        values = getattr(one_by_one.state, name)
        scale = 1.0 + np.abs(values).max()
        assert np.abs(getattr(at_once.state, name) - values).max() < 1e-7 * scale
    scale = 1.0 + np.abs(one_by_one.work).max()
    assert np.abs(at_once.work - one_by_one.work).max() < 1e-7 * scale
    assert at_once.message == one_by_one.message
    events = [(event.kind, event.name) for event in one_by_one.events]
    assert [(event.kind, event.name) for event in at_once.events] == events


@pytest.mark.parametrize("name", swept(NAMES))
def test_a_function_that_returns_constant_efforts_gives_the_same_motion(name: str) -> None:
    machine = robot(name)
    (state,) = random_states(name, 1, seed=3)
    tau = 0.9 * machine.inverse_dynamics(state, np.zeros(state.n))
    at_once, one_by_one = both_ways(machine, state.u, 0.3 * state.du, tau, 0.3)
    assert len(at_once.t) > 5
    assert_same(at_once, one_by_one)


@examples(3)
@given(robots(), STATES)
def test_random_robots_move_the_same_way(case: Case, seed: int) -> None:
    machine = case.robot
    state = machine.close(case.somewhere(seed)[: case.n], near=None, check=False)
    assume(not state.status and float(state.singularity) > 0.05)
    tau = machine.inverse_dynamics(state, np.zeros(case.n))
    du = 0.3 * case.rates(seed)
    assert_same(*both_ways(machine, state.u, du, tau, 0.1))


def test_both_stop_at_the_same_limit() -> None:
    """An arm that falls until a cylinder is at its end; without a stop all limits are met."""
    excavator = load("excavator")
    u, zero = excavator.reference, np.zeros(4)
    at_once, one_by_one = both_ways(excavator, u, zero, zero, 3.0)
    assert not at_once.completed
    assert_same(at_once, one_by_one)
    settings = Settings(rtol=1e-11, atol=1e-13, stop_at_limits=False)
    further, stepwise = both_ways(excavator, u, zero, zero, 1.2 * at_once.t[-1], settings)
    assert len(further.events) > 0
    assert further.steps < 2 * stepwise.steps  # none of the short ones beyond a singular place
    assert_same(further, stepwise)
    times = [event.time for event in stepwise.events]
    assert [event.time for event in further.events] == pytest.approx(times, abs=1e-8)


def test_efforts_that_are_held_are_constant_in_each_period() -> None:
    """A feedback at 50 Hz, against its integration period by period."""
    excavator = load("excavator")

    def feedback(_t: float, state: ClosedState) -> Array:
        return np.asarray(tau - gains * (state.u - excavator.reference))

    start = excavator.close(excavator.reference)
    tau = excavator.inverse_dynamics(start, np.zeros(4))
    gains = np.array([1e3, 5e5, 4e5, 3e5])
    settings = Settings(rtol=1e-11, atol=1e-13, rate=50.0, hold=0.02)
    held = simulate(excavator, start.u, np.full(4, 0.02), feedback, (0.0, 0.2), settings)
    y, dy = start.u, np.full(4, 0.02)
    fine = Settings(rtol=1e-11, atol=1e-13, rate=50.0)
    for k in range(10):
        efforts = feedback(0.0, excavator.close(y, dy))
        period = simulate(excavator, y, dy, lambda _t, _s, e=efforts: e, (0.0, 0.02), fine)
        y, dy = period.state.u[-1], period.state.du[-1]
        np.testing.assert_allclose(held.state.u[k + 1], y, atol=1e-9)


@compiled
def test_dense_output_and_ends_of_steps_are_those_of_scipy() -> None:
    """As many steps, the same dense output in a step from the same state."""
    from scipy.integrate import DOP853

    machine = robot("gough")
    start = machine.close(machine.reference, np.full(6, 0.05))
    tau = 0.9 * machine.inverse_dynamics(start, np.zeros(6))
    motion = machine.motion_near(start)
    y = np.concatenate([start.u, start.du, [0.0]])

    def slope(_t: float, y: Array) -> Array:
        ddu, power = motion(y[:6], y[6:12], tau)
        return np.concatenate([y[6:12], ddu, [power]])

    oracle = DOP853(slope, 0.0, y, 0.3, rtol=1e-9, atol=1e-11, first_step=1e-3)
    steps = advanced(machine, y, tau, 40)
    times = [0.0]
    while oracle.status == "running":
        oracle.step()
        times.append(oracle.t)
    np.testing.assert_allclose(steps.times, times, rtol=1e-5)
    within = np.linspace(0.0, steps.times[1], 7)
    first = DOP853(slope, 0.0, y, 0.3, rtol=1e-9, atol=1e-11, first_step=1e-3)
    first.step()
    expected = first.dense_output()(within).T
    found = steps.at(np.zeros(7, dtype=np.int64), within)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


@compiled
def test_steps_go_on_where_others_ended() -> None:
    """In parts of three, to rounding, as all at once."""
    machine = robot("gough")
    start = machine.close(machine.reference, np.full(6, 0.05))
    tau = 0.9 * machine.inverse_dynamics(start, np.zeros(6))
    y = np.concatenate([start.u, start.du, [0.0]])
    whole = advanced(machine, y, tau, 40)
    part = advanced(machine, y, tau, 3)
    assert part.number == 3
    np.testing.assert_array_equal(part.y, whole.y[:4])
    np.testing.assert_array_equal(part.R, whole.R[:4])


@compiled
def test_loads_are_as_in_the_description() -> None:
    machine, state = moving()
    loads, other = heavy(machine)
    y = np.concatenate([state.u, state.du, [0.0]])
    tau = machine.inverse_dynamics(state, np.zeros(state.n))
    times = np.linspace(0.0, 0.2, 9)  # steps end elsewhere: rounding decides on the first ones
    under, described, bare = (
        at(times, steps)
        for steps in (
            advanced(machine, y, tau, 20, loads),
            advanced(other, y, tau, 20),
            advanced(machine, y, tau, 20),
        )
    )
    assert near(under, described, 1e-7)  # both keep 1e-9 a step
    assert not near(under, bare, 1e-3)


def at(times: Array, steps: Steps) -> Array:
    """The states (N, m) at times."""
    return steps.at(np.searchsorted(steps.times[1:], times), times)


def advanced(machine: Robot, y: Array, tau: Array, most: int, loads: Loads | None = None) -> Steps:
    """Some steps within 0.3 s."""
    n = len(machine.active)
    start = machine.close(y[:n], y[n : 2 * n])
    integrator = machine.motion_steps(loads)
    assert integrator is not None
    control = StepControl(1e-3, np.inf, 1e-9, 1e-11, 10.0)
    return integrator.advance(start, y, tau, (0.0, 0.3), control, most)


def test_a_robot_without_masses_is_refused_as_before() -> None:
    staicu = load("staicu2015")
    with pytest.raises(MassSingularityError):
        simulate(staicu, staicu.reference, None, None, (0.0, 0.1))


def test_rates_beside_a_closed_state_are_refused() -> None:
    """They would not be used: the state has its own."""
    machine = robot("rssr")
    with pytest.raises(InputError, match="du: the closed state has rates"):
        simulate(machine, machine.close(machine.reference), [0.1])


def test_large_robots_are_integrated_step_by_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """R of a tree of a thousand joints would not fit on the stack of a step."""
    machine = robot("rssr")
    monkeypatch.setattr(motions, "LARGEST_MAP", 3)
    assert machine.motion_steps() is None
    assert simulate(machine, machine.reference, [0.1], None, (0.0, 0.1)).completed
