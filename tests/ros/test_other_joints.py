"""Motions of other joints than the active ones, with and without rates: held against the model.

Each optional input is given in some test, and the outcome is that of `close` and
`inverse_dynamics` on the active joints, which these motions come from.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, Payload, Robot, load
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.services.trajectory_conversion import convert
from hybrid_dynamics_ros.services.trajectory_follower import ConversionSettings
from hybrid_dynamics_ros.services.trajectory_motion import SampledTrajectory
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.sampling import swept

ROBOTS = ("excavator", "forging_chu2020", "type_c", "five_bar", "palletizer", "staicu2015")
SAMPLED = ("excavator", "five_bar")
STEP = 0.01  # [s]


@cache
def shipped(name: str) -> Robot:
    return load(name)


def motion_of(robot: Robot, count: int = 40) -> tuple[ClosedState, np.ndarray]:
    """States and active accelerations (N, n) of a gentle motion about the reference."""
    time = STEP * np.arange(count)[:, None]
    n = len(robot.active)
    rng = np.random.default_rng(3)
    width = rng.uniform(0.005, 0.01, n)
    rate = rng.uniform(2.0, 4.0, n)
    wave, turn = width * np.sin(rate * time), width * rate * np.cos(rate * time)
    u = robot.reference + wave
    return robot.close_path(u, turn), -(rate**2) * wave


def other_set(robot: Robot, state: ClosedState, seed: int) -> tuple[str, ...]:
    """Names of a random independent set, not only of active coordinates."""
    rng = np.random.default_rng(seed)
    first = state.rows(0)
    for _ in range(400):
        names = tuple(rng.permutation(robot.coordinates)[: len(robot.active)].tolist())
        if set(names) == set(robot.active):
            continue
        index = [robot.coordinates.index(name) for name in names]
        motion = first.R[index]
        if np.linalg.svd(motion, compute_uv=False)[-1] < 0.2:
            continue
        try:
            robot.close_given(dict(zip(names, first.s[index].tolist(), strict=True)))
        except HybridDynamicsError:
            continue
        return names
    raise AssertionError("no independent set was met")


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", swept(ROBOTS, SAMPLED))
def test_given_accelerations_are_those_of_the_measured_joints(name: str, seed: int) -> None:
    robot = shipped(name)
    state, ddu = motion_of(robot, 6)
    names = other_set(robot, state, seed)
    index = [robot.coordinates.index(joint) for joint in names]
    dds = robot.accelerations(state, ddu)
    expected = robot.inverse_dynamics(state, ddu)
    pipeline = Pipeline(robot, 10.0, 0.5, names)
    scale = 1.0 + np.abs(expected).max()
    for k in range(len(ddu)):
        stamp = round(k * STEP * 1e9)
        sample = JointSample(stamp, names, state.s[k, index], state.ds[k, index], dds[k, index])
        result = pipeline.process(sample)
        assert isinstance(result, MotionResult)
        np.testing.assert_allclose(result.position, state.s[k], atol=1e-9)
        np.testing.assert_allclose(result.active.acceleration, ddu[k], atol=1e-7)
        np.testing.assert_allclose(result.efforts, expected[k], atol=1e-7 * scale)


@pytest.mark.parametrize("name", swept(ROBOTS, SAMPLED))
def test_estimated_accelerations_are_those_of_the_measured_joints(name: str) -> None:
    robot = shipped(name)
    state, ddu = motion_of(robot, 60)
    names = other_set(robot, state, 1)
    index = [robot.coordinates.index(joint) for joint in names]
    pipeline = Pipeline(robot, 10.0, 0.5, names)
    for k in range(len(ddu)):
        stamp = round(k * STEP * 1e9)
        result = pipeline.process(JointSample(stamp, names, state.s[k, index], state.ds[k, index]))
    assert isinstance(result, MotionResult)
    assert result.efforts is not None
    # the filter lags by some samples: a tenth of the largest
    off = np.abs(result.active.acceleration - ddu[-1]) / np.abs(ddu).max(axis=0)
    assert off.max() < 0.2
    efforts = robot.inverse_dynamics(result.state, result.active.acceleration)
    np.testing.assert_allclose(result.efforts, efforts, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("given", ["positions", "velocities", "accelerations"])
@pytest.mark.parametrize("name", swept(ROBOTS, SAMPLED))
def test_a_trajectory_without_rates_is_that_of_its_spline(name: str, given: str) -> None:
    """A cubic that begins and ends at rest: its splines are exact."""
    robot = shipped(name)
    time = np.linspace(0.0, 1.0, 9)
    way = 0.01 * np.random.default_rng(1).normal(size=len(robot.active))
    u = robot.reference + np.outer(3.0 * time**2 - 2.0 * time**3, way)
    du = np.outer(6.0 * time - 6.0 * time**2, way)
    ddu = np.outer(6.0 - 12.0 * time, way)
    motion = SampledTrajectory(
        robot.active,
        time,
        u,
        None if given == "positions" else du,
        ddu if given == "accelerations" else None,
    )
    payload = Payload(7.0, np.array([0.05, 0.0, 0.1]))
    loads = robot.loads.with_payload(payload, robot.end_effector)
    near = robot.close(robot.reference)
    converted = convert(robot, motion, near, ConversionSettings(loads, 1e-3))
    assert converted.problem is None
    state = robot.close(u, du)
    expected = robot.inverse_dynamics(state, ddu, loads)
    np.testing.assert_allclose(converted.acceleration, ddu, atol=1e-9)
    scale = 1.0 + np.abs(expected).max()
    np.testing.assert_allclose(converted.efforts, expected, atol=1e-7 * scale)
    assert converted.nearest == pytest.approx(float(np.min(state.singularity)), abs=1e-9)


@pytest.mark.parametrize("name", swept(ROBOTS, SAMPLED))
def test_a_trajectory_of_other_joints_gives_the_efforts_of_the_active_ones(name: str) -> None:
    robot = shipped(name)
    state, ddu = motion_of(robot, 12)
    names = other_set(robot, state, 2)
    index = [robot.coordinates.index(joint) for joint in names]
    dds = robot.accelerations(state, ddu)
    time = STEP * np.arange(len(ddu))
    motion = SampledTrajectory(names, time, state.s[:, index], state.ds[:, index], dds[:, index])
    converted = convert(robot, motion)
    assert converted.problem is None
    np.testing.assert_allclose(converted.position, state.u, atol=1e-9)
    expected = robot.inverse_dynamics(state, ddu)
    scale = 1.0 + np.abs(expected).max()
    np.testing.assert_allclose(converted.efforts, expected, atol=1e-6 * scale)
    # velocities alone: the pieces of a Hermite spline, off by the square of the step
    without = SampledTrajectory(names, time, state.s[:, index], state.ds[:, index])
    off = np.abs(convert(robot, without).acceleration - ddu)[1:-1]
    assert off.max() < 0.05 * np.abs(ddu).max()
