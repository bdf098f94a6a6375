"""The momentum observer gives external efforts, exactly where the model is exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from hybrid_dynamics_core import ClosedState, InputError, Payload, Robot, load
from hybrid_dynamics_core.control import (
    ComputedTorque,
    ForceCompensation,
    JointTrajectory,
    MomentumObserver,
)
from hybrid_dynamics_core.control.momentum_observer import balance
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples
from tests.generated.test_dynamics_laws import at, slope
from tests.laws.test_loads import heavy_loads

STEP = 1e-3  # [s]


@pytest.fixture(scope="module")
def excavator() -> Robot:
    return load("excavator")


@pytest.fixture(scope="module")
def motion(excavator):
    """Times, states and accelerations of a motion at 1 kHz."""
    time = np.arange(0.0, 1.2, STEP)
    path = JointTrajectory.between([0.0, 0.5, 0.9, 0.7], [0.5, 0.7, 0.7, 0.8], 1.2)
    goal = path(time)
    return time, excavator.close(goal.u, goal.du), goal.ddu


@examples(8)
@given(class_three(max_links=2, max_loops=2), STATES)
def test_momentum_changes_by_the_balance_of_efforts(case: Case, seed: int):
    """p' = tau + C-bar^T u' - G-bar - f, whatever the robot, its motion and its loads."""
    robot, state, loads = case.robot, at(case, seed), heavy_loads(case.robot)
    ddu = case.rates(seed + 1)

    def momentum(t: float) -> np.ndarray:
        u = state.u + t * state.du + 0.5 * t**2 * ddu
        later = robot.close(u, state.du + t * ddu, near=state)
        return balance(robot, ClosedState.joined([later]), np.zeros((1, case.n)), loads)[0][0]

    tau = robot.inverse_dynamics(state, ddu, loads)
    _, expected = balance(robot, ClosedState.joined([state]), tau[None], loads)
    rate, unsure = slope(momentum)
    size = max(1.0, float(np.abs(tau).max()), float(np.abs(rate).max()))
    assert np.abs(rate - expected[0]).max() < 2.0 * unsure + 1e-8 * size


def filtered(values: np.ndarray, cutoff: float) -> np.ndarray:
    """A low-pass filter of first order on values that are linear between samples."""
    decay = np.exp(-2.0 * np.pi * cutoff * STEP)
    result = np.zeros_like(values)
    for k in range(1, len(values)):
        middle = 0.5 * (values[k] + values[k - 1])
        weight = max(1.0 - decay, 1.0 / k)
        result[k] = result[k - 1] + weight * (middle - result[k - 1])
    return result


def test_the_residual_is_the_filtered_external_effort(excavator, motion):
    time, state, ddu = motion
    force = 2e4 * np.sin(4.0 * time)[:, None] * np.array([1.0, 0.5, -2.0, 0.0, 0.0, 0.0])
    tau = excavator.inverse_dynamics(state, ddu, excavator.loads.with_wrench(force))
    jacobian = excavator.jacobian(state)
    external = np.einsum("kij,ki->kj", jacobian, force)
    residuals = MomentumObserver(excavator, 5.0).run(time, state, tau)
    wanted = filtered(external, 5.0)
    assert residuals.values == pytest.approx(wanted, abs=2e-4 * np.abs(external).max())
    assert residuals.is_ready[-1]


def test_the_second_order_follows_a_ramp_without_lag(excavator, motion):
    time, state, ddu = motion
    force = 3e4 * time[:, None] * np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    tau = excavator.inverse_dynamics(state, ddu, excavator.loads.with_wrench(force))
    external = np.einsum("kij,ki->kj", excavator.jacobian(state), force)
    late = time > 0.4
    errors = {}
    for order in (1, 2):
        observer = MomentumObserver(excavator, 5.0, order)
        errors[order] = np.abs(observer.run(time, state, tau).values - external)[late].max()
    assert errors[2] < 0.02 * np.abs(external).max()
    assert errors[2] < 0.2 * errors[1]


def test_samples_one_by_one_give_the_same_bits(excavator, motion):
    time, state, ddu = motion
    tau = excavator.inverse_dynamics(state, ddu) + np.cos(40.0 * time)[:, None]
    rows = slice(0, 1200, 7)
    whole = MomentumObserver(excavator, 5.0, 2)
    expected = whole.run(time[rows], state.rows(rows), tau[rows]).values
    observer = MomentumObserver(excavator, 5.0, 2)
    for k, row in enumerate(range(0, 1200, 7)):
        one = observer.step(time[row], state.rows(row), tau[row])
        assert one.tobytes() == expected[k].tobytes()
    assert observer.noise.tobytes() == whole.noise.tobytes()


def test_a_gap_starts_anew_and_a_clock_that_goes_back_is_refused(excavator):
    state = excavator.close(excavator.reference)
    held = excavator.inverse_dynamics(state, np.zeros(4))
    observer = MomentumObserver(excavator, 5.0)
    for k in range(20):
        observer.step(0.01 * k, state, held + 100.0)
    assert observer.residual == pytest.approx(np.full(4, -100.0))
    with pytest.raises(InputError, match=r"the clock goes from 0.19 s to 0.1 s"):
        observer.step(0.1, state, held)
    observer.step(5.0, state, held)
    assert observer.residual == pytest.approx(np.zeros(4))
    assert not observer.is_ready
    with pytest.raises(InputError, match="tau"):
        observer.step(5.1, state, held * np.nan)
    with pytest.raises(InputError, match="cutoff is 0"):
        MomentumObserver(excavator, 0.0)
    with pytest.raises(InputError, match="order is 3"):
        MomentumObserver(excavator, 1.0, 3)


def test_compensation_carries_a_load_that_the_controller_ignores(excavator):
    start = [0.0, 0.7, 0.7, 0.6]
    trajectory = JointTrajectory.between(start, [0.2, 0.75, 0.65, 0.65], 0.5)
    settings = Settings(loads=excavator.loads.with_payload(Payload(800.0)), hold=0.005, rtol=1e-6)
    alone = ComputedTorque(excavator, trajectory, 100.0, 20.0)
    observed = ForceCompensation(alone, MomentumObserver(excavator, 10.0))
    errors = []
    for controller in (alone, observed):
        run = simulate(excavator, start, None, controller, (0.0, 1.0), settings)
        errors.append(np.abs(trajectory(run.t[-1]).u - run.u[-1]).max())
    assert errors[0] > 1e-4
    assert errors[1] < 0.1 * errors[0]
    with pytest.raises(InputError, match="share is 2"):
        replace(observed, share=2.0)


def test_a_single_sample_is_a_state(excavator):
    state = excavator.close(excavator.reference)
    joined = ClosedState.joined([state])
    momentum, _ = balance(excavator, joined, np.zeros((1, 4)))
    assert momentum == pytest.approx(np.zeros((1, 4)))


def test_the_second_order_follows_a_ramp_at_uneven_times(excavator):
    state = excavator.close(excavator.reference)
    held = excavator.inverse_dynamics(state, np.zeros(4))
    steps = np.random.default_rng(3).uniform(0.002, 0.05, 200)
    time = np.cumsum(steps)
    ramp = time[:, None] * np.array([100.0, -2e3, 1e3, 500.0])
    still = ClosedState.joined([state] * len(time))
    found = MomentumObserver(excavator, 5.0, 2).run(time, still, held - ramp).values
    assert found[2:] == pytest.approx(ramp[2:], rel=1e-6, abs=1e-6)
