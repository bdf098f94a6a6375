"""Certificates of states: boxes that hold what compiled code computes anywhere in them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Robot, shipped_robots
from hybrid_dynamics_core.certified.boxes.interval_matrix import IntervalMatrix
from tests.robots import REACH, robot
from tests.sampling import SHIPPED_SAMPLE, examples, swept

RADIUS = 2e-4  # [rad, m]
ROUNDING = 1e-9  # of compiled code, in shares of the largest effort


def near_reference(machine: Robot, rng: np.random.Generator) -> np.ndarray:
    return machine.reference + 0.2 * REACH * rng.uniform(-1.0, 1.0, len(machine.active))


@pytest.mark.parametrize("name", swept(shipped_robots(), SHIPPED_SAMPLE))
def test_boxes_hold_the_configurations_and_efforts_of_all_inputs_in_them(name: str) -> None:
    machine = robot(name)
    n = len(machine.active)
    rng = np.random.default_rng(3)
    state = machine.close(near_reference(machine, rng), rng.normal(size=n))
    ddu = rng.normal(size=n)
    certificate = machine.certify(state, ddu, RADIUS)
    assert certificate, certificate.reason
    u = state.u + RADIUS * rng.uniform(-1.0, 1.0, (20, n))
    states = machine.close(u, np.tile(state.du, (20, 1)), near=state)
    assert (certificate.s_lower <= states.s + 1e-12).all()
    assert (states.s - 1e-12 <= certificate.s_upper).all()
    tau = machine.inverse_dynamics(states, np.tile(ddu, (20, 1)))
    slack = ROUNDING * np.abs(tau).max()
    assert (certificate.tau_lower - slack <= tau).all()
    assert (tau <= certificate.tau_upper + slack).all()


@pytest.mark.parametrize("name", swept(shipped_robots(), SHIPPED_SAMPLE))
def test_one_state_is_certified_to_rounding(name: str) -> None:
    machine = robot(name)
    state = machine.close(machine.reference)
    certificate = machine.certify(state)
    assert certificate.holds
    assert np.ptp([certificate.s_lower, certificate.s_upper], axis=0).max() < 1e-12
    passive = [k for k, name in enumerate(machine.coordinates) if name in machine.passive]
    assert certificate.alone[passive].min(initial=1.0) >= 1e-4
    tau = machine.inverse_dynamics(state, np.zeros(len(machine.active)))
    slack = ROUNDING * np.abs(tau).max()
    assert (certificate.tau_lower - slack <= tau).all()
    assert (tau <= certificate.tau_upper + slack).all()


def test_other_modes_are_outside_the_box_in_which_a_configuration_is_alone() -> None:
    machine = robot("five_bar")
    modes = machine.assembly_modes(machine.reference)
    for mode in modes:
        alone = machine.certify(mode.state).alone
        for other in modes:
            apart = np.abs(np.sin(0.5 * (other.state.s - mode.state.s)))
            assert other is mode or (2.0 * apart > alone).any()


def test_a_box_that_holds_a_singular_configuration_is_not_certified() -> None:
    machine = robot("five_bar")
    state = machine.close(machine.reference)
    certificate = machine.certify(state, radius=2.0)
    assert not certificate
    assert np.isnan(certificate.s_lower).all()
    assert np.isnan(certificate.tau_upper).all()


def test_what_is_no_state_or_radius_is_refused() -> None:
    machine = robot("five_bar")
    state = machine.close(machine.reference)
    batch = machine.close(np.tile(machine.reference, (2, 1)))
    with pytest.raises(InputError, match="expected no batch"):
        machine.certify(batch)
    with pytest.raises(InputError, match="not negative"):
        machine.certify(state, radius=-1.0)
    with pytest.raises(InputError, match="another robot"):
        machine.certify(robot("delta").close(robot("delta").reference))
    with pytest.raises(InputError, match="ddu"):
        machine.certify(state, [1.0])


@given(st.integers(0, 10**6), st.integers(1, 6))
@examples(60)
def test_inverses_of_all_matrices_of_a_box_are_in_the_inverse(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    middle = rng.normal(size=(4, size, size))
    radius = 10.0 ** rng.uniform(-14.0, -2.0) * rng.uniform(0.0, 1.0, middle.shape)
    inverse = IntervalMatrix(middle, radius).inverse()
    member = middle + radius * rng.uniform(-1.0, 1.0, middle.shape)
    exact = np.linalg.inv(member)
    slack = 1e-13 * np.abs(exact).max() * np.linalg.cond(member).max()
    assert (np.abs(exact - inverse.middle) <= inverse.radius + slack).all()
