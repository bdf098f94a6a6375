"""The centre of mass of a load: its covariance is that of small changes of what was fitted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core.estimation.centre import centre_of_mass
from hybrid_dynamics_core.estimation.fit import Fit
from tests.sampling import examples

SHOWN = 100.0  # [m] deviation before the measurement, far above those here


def fit_of(values: np.ndarray, covariance: np.ndarray) -> Fit:
    return Fit(values, covariance, np.zeros(1), np.zeros(1), 1.0)


def mass_and_centre(values: np.ndarray) -> np.ndarray:
    return np.array([values[0], *values[1:4] / values[0]])


@examples(20)
@given(st.integers(0, 10**6))
def test_covariance_is_that_of_small_changes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = np.concatenate([rng.uniform(100.0, 900.0, 1), rng.uniform(-300.0, 300.0, 9)])
    root = rng.normal(size=(10, 10))
    covariance = root @ root.T
    com, found = centre_of_mass(fit_of(values, covariance), SHOWN)
    steps = 1e-4 * np.eye(10)[:4]
    columns = [mass_and_centre(values + h) - mass_and_centre(values - h) for h in steps]
    gradient = np.transpose(columns) / 2e-4
    assert com == pytest.approx(values[1:4] / values[0])
    expected = gradient @ covariance[:4, :4] @ gradient.T
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 * np.abs(expected).max())


def test_what_the_measurement_does_not_show_is_nan() -> None:
    covariance = np.diag([1.0, 1e-4, 1e-4, 1e6])
    com, found = centre_of_mass(fit_of(np.array([10.0, 1.0, 2.0, 3.0]), covariance), 1.0)
    assert np.isnan(com).tolist() == [False, False, True]
    assert found[0, 0] == 1.0
    assert np.isnan(found[3]).all()
    assert np.isnan(found[:, 3]).all()
    assert np.isfinite(found[:3, :3]).all()
    com, found = centre_of_mass(fit_of(np.array([-1.0, 0, 0, 0]), covariance), 1.0)
    assert np.isnan(com).all()
    assert found[0, 0] == 1.0
