"""Outliers: bad samples are left out even where they pull the fit; intervals stay as confident."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_core.dynamics.parameters import Parameters, described_parameters
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.identification import TooLittleShownError, identify, random_motion
from hybrid_dynamics_core.identification.outliers import CASES, outlying_samples

FLOOR = np.full(2, 1e-9)
NOISE = np.array([0.01, 30.0])


def problem(seed, samples=300, size=6):
    """Equations of two joints with noise of very different sizes, and the truth."""
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(samples, 2, size))
    truth = rng.normal(size=size)
    noise = rng.normal(size=(samples, 2)) * NOISE
    return rng, columns, columns @ truth + noise, truth


def test_of_clean_recordings_one_in_twenty_loses_a_sample():
    lost = []
    for seed in range(200):
        _, columns, target, _ = problem(seed)
        outlying = outlying_samples(columns, target, FLOOR)
        lost.append(int(outlying.sum()))
    # Binomial, 200 cases of 5 %: mean 10, deviation 3; 5 deviations above. Hardly any loses two of
    # its 300.
    assert np.count_nonzero(lost) <= 200 * CASES + 15
    assert max(lost) <= 3


@pytest.mark.parametrize("share", [0.003, 0.1, 0.25])
def test_spikes_are_outliers_and_nothing_else(share):
    rng, columns, target, _ = problem(3)
    count = max(1, round(share * len(target)))
    bad = rng.choice(len(target), count, replace=False)
    joint = rng.integers(2, size=count)
    sign = rng.choice([-1.0, 1.0], count)
    target[bad, joint] += sign * NOISE[joint] * rng.uniform(15, 1e4, count)
    out = outlying_samples(columns, target, FLOOR)
    assert set(np.flatnonzero(out)) >= set(bad)
    assert out.sum() <= len(bad) + 1


def test_a_bad_sample_that_pulls_the_fit_onto_itself_is_an_outlier():
    """A wrong acceleration: the columns of its equation are a thousand times the others."""
    _, columns, target, _ = problem(5)
    columns[7] *= 1e3
    assert np.flatnonzero(outlying_samples(columns, target, FLOOR)).tolist() == [7]


def test_identification_from_a_recording_with_spikes_keeps_its_confidence():
    robot = load("five_bar")
    parameters = described_parameters(robot.description)
    truth = parameters.values(robot.description)
    inside, width = [], []
    state, ddu = random_motion(robot, 400, 1)
    clean = robot.inverse_dynamics(state, ddu)
    for seed in range(6):
        rng = np.random.default_rng(seed)
        tau = clean + rng.normal(0.0, 0.05, clean.shape)
        alone = identify(robot, state, ddu, tau)
        bad = rng.choice(400, 12, replace=False)
        joint = rng.integers(clean.shape[1], size=12)
        sign = rng.choice([-1.0, 1.0], 12)
        tau[bad, joint] += sign * rng.uniform(3.0, 300.0, 12)
        result = identify(robot, state, ddu, tau)
        assert set(np.flatnonzero(result.outlying)) >= set(bad)
        assert result.outlying.sum() <= 13
        sizes = np.abs(result.residual[bad]).max(axis=1)
        assert sizes.min() > 2.0  # of at least 3 N m, less what 40 deviations move
        value = result.base.values(truth)
        low, high = result.interval.T
        inside.append((value > low) & (value < high))
        width.append(np.median(result.deviation / alone.deviation))
    # of 6 b intervals of 95 %, dependent within a fit, fewer than 85 % inside are as good as never
    assert np.mean(inside) > 0.85
    # 3 % of the samples are worth 1.5 % of a deviation.
    assert np.mean(width) == pytest.approx(1.0, abs=0.05)


def test_efforts_without_noise_lose_no_sample():
    robot = load("five_bar")
    state, ddu = random_motion(robot, 200, 2)
    result = identify(robot, state, ddu, robot.inverse_dynamics(state, ddu))
    assert not result.outlying.any()


def test_names_that_the_robot_does_not_have_and_motions_that_show_too_little_are_refused():
    robot = load("five_bar")
    state, ddu = random_motion(robot, 50, 2)
    tau = robot.inverse_dynamics(state, ddu)
    links = described_parameters(robot.description).links
    with pytest.raises(InputError, match="there is no joint 'bom'; known: "):
        identify(robot, state, ddu, tau, Parameters(links, ("bom",)))
    still = robot.close(np.tile(robot.reference, (50, 1)))
    with pytest.raises(TooLittleShownError, match="the motion shows"):
        identify(robot, still, np.zeros_like(ddu), np.zeros_like(tau))
