"""Laws of the filter on random robots with random sensors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from hybrid_dynamics_core import ClosedState
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.filtering import (
    MotionModel,
    ObservabilityError,
    StateFilter,
    observability,
)
from tests.filtering.mixes import mix, motion, on_joint
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples

NOISE = 3e-4
TIMES = np.linspace(0.0, 0.3, 7)


def model_of(case: Case) -> MotionModel:
    return MotionModel(np.full(case.n, 0.5), 0.5)


@examples(200)
@given(st.floats(-6.0, 1.0), st.sampled_from([-1.0, 1.0]), st.floats(0.01, 10.0))
def test_motion_between_readings_is_that_of_its_equation(power, side, time) -> None:
    """Exponential of the equation's matrix; the noise of two steps adds up."""
    step = 10.0**power * time
    model = MotionModel(np.array([0.7]), time)
    rates = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / time]])
    size = np.array([step**2, step, 1.0])  # of what u'' adds to each order
    expected = expm(rates * side * step)
    moved = model.transition(side * step)
    assert moved * size / size[:, None] == pytest.approx(expected * size / size[:, None], abs=1e-9)
    moved, noise = model.transition(step), model.noise(step)
    both = (moved @ noise @ moved.T + noise) / np.outer(size, size)
    assert model.noise(2.0 * step) / np.outer(size, size) == pytest.approx(both, rel=1e-6)


@examples(12)
@given(class_three(max_links=4, max_loops=2), STATES)
def test_slopes_are_those_of_readings(case: Case, seed: int) -> None:
    robot, n = case.robot, case.n
    x = np.concatenate([case.start[:n], case.rates(seed), case.rates(seed + 1)])
    for sensor in mix(robot, seed, NOISE):

        def read(x: np.ndarray, sensor=sensor) -> np.ndarray:
            near = robot.close(case.start[:n])
            return sensor.observe(robot.close(x[:n], x[n : 2 * n], near=near), x[2 * n :]).readings

        slopes = sensor.observe(robot.close(x[:n], x[n : 2 * n]), x[2 * n :]).slopes
        size = 1.0 + np.abs(slopes).max()
        for k, unit in enumerate(1e-6 * np.eye(3 * n)):
            change = sensor.difference(read(x + unit), read(x - unit))
            assert np.abs(change / 2e-6 - slopes[:, k]).max() < 1e-5 * size**2


@examples(12)
@given(class_three(max_links=4, max_loops=2), STATES)
def test_exact_readings_at_rest_give_the_truth(case: Case, seed: int) -> None:
    """Any mix that determines the state does; one that does not is refused by name."""
    robot, model = case.robot, model_of(case)
    start = case.start[: case.n]
    sensors = mix(robot, seed, NOISE)
    shown = observability(robot, sensors, model, start)
    if shown.undetermined:
        with pytest.raises(ObservabilityError, match=shown.undetermined[0]):
            StateFilter(robot, sensors, model, start)
    sensors += [on_joint(robot, name, NOISE) for name in robot.active if name not in shown.at_rest]
    truth = robot.close(start)
    still = np.zeros(case.n)
    watched = StateFilter(robot, sensors, model, start + 1e-3, latest=0.0)
    for time in TIMES.tolist():
        for sensor in sensors:
            watched.add(time, sensor.name, sensor.observe(truth, still).readings)
    _require_near(watched, truth, still)


@examples(12)
@given(class_three(max_links=4, max_loops=2), STATES)
def test_exact_readings_in_motion_give_the_truth(case: Case, seed: int) -> None:
    """Encoders of the active joints, and any others."""
    robot, model = case.robot, model_of(case)
    start = case.start[: case.n]
    sensors = [on_joint(robot, name, NOISE) for name in robot.active]
    sensors += mix(robot, seed, NOISE)
    try:
        state, ddu = motion(robot, model, start, TIMES, seed)
    except StateError:
        return
    watched = StateFilter(robot, sensors, model, start + 1e-3, latest=0.0)
    for k, time in enumerate(TIMES.tolist()):
        for sensor in sensors:
            watched.add(time, sensor.name, sensor.observe(state.rows(k), ddu[k]).readings)
    _require_near(watched, state.rows(len(TIMES) - 1), ddu[-1])


def _require_near(watched: StateFilter, truth: ClosedState, ddu: np.ndarray) -> None:
    """No error is beyond what its deviation allows, and no reading is refused."""
    estimate = watched.estimate
    deviations = np.sqrt(np.diagonal(estimate.covariance))
    estimated = [estimate.state.u, estimate.state.du, estimate.ddu]
    error = np.concatenate(estimated) - np.concatenate([truth.u, truth.du, ddu])
    assert np.abs(error / deviations).max() < 3.0
    assert not watched.counts.beyond_gate.total()
