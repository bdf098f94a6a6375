"""This library against Pinocchio: closed forms and Newton, minimal form and the full DAE."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import load
from tests.agreement.pinocchio_model import PinocchioRobot
from tests.strategies import positions, rates

ROBOT = load("forging_chu2020")
ORACLE = PinocchioRobot(ROBOT.description, ROBOT.coordinates)
N = len(ROBOT.active)


@given(positions(ROBOT))
def test_closed_form_is_newton(u: np.ndarray) -> None:
    """Newton started 0.03 rad or so off the answer, on pins written in space."""
    state = ROBOT.close(u)
    start = state.s.copy()
    start[N:] += 0.03 * float(state.singularity) ** 2 * np.cos(np.arange(len(start) - N))
    if abs(np.cos(state.s[4] + state.s[5])) < 0.05 or abs(np.sin(state.s[4])) < 0.05:
        start = state.s  # Newton on a parallelogram's pins is singular where its bars are in line
    error = 1e-11 / float(state.singularity) ** 2
    assert ORACLE.close(start, N) == pytest.approx(state.s, abs=error)


@given(positions(ROBOT), rates(ROBOT), rates(ROBOT))
def test_inverse_dynamics_is_pinocchios_projected_with_R(
    u: np.ndarray, du: np.ndarray, ddu: np.ndarray
) -> None:
    state = ROBOT.close(u, du)
    forces = ORACLE.tree_forces(state.s, state.ds, ROBOT.accelerations(state, ddu))
    tau = ROBOT.inverse_dynamics(state, ddu)
    size = np.abs(state.R).max() * np.abs(forces).max()  # cancellation in R^T f
    assert np.abs(state.R.T @ forces - tau).max() < 1e-12 * size


@given(positions(ROBOT), rates(ROBOT), rates(ROBOT))
def test_minimal_form_is_the_dae_as_one_kkt_system(
    u: np.ndarray, du: np.ndarray, ddu: np.ndarray
) -> None:
    """The DAE of Chu (2020), Eq. 10, with J_s of Eq. 16, gives u'' back.

    [M  -J^T; J  0] [s''; lambda] = [tau - C s' - g; -J' s']. The redundant rows of the planar pins
    are left to the least-squares solution.
    """
    state = ROBOT.close(u, du)
    # Elsewhere the oracle's pins are near-singular.
    assume(state.singularity > 0.2)
    assume(abs(np.cos(state.s[4] + state.s[5])) > 0.1)
    assume(abs(np.sin(state.s[4])) > 0.1)
    tau = ROBOT.inverse_dynamics(state, ddu)
    _, jacobian = ORACLE.gaps(state.s)
    mass = ORACLE.mass_matrix(state.s)
    force = np.zeros(len(state.s))
    force[:N] = tau
    force -= ORACLE.tree_forces(state.s, state.ds, np.zeros(len(state.s)))
    m = len(jacobian)
    kkt = np.block([[mass, -jacobian.T], [jacobian, np.zeros((m, m))]])
    right = np.concatenate([force, -ORACLE.bias(state.s, state.ds)])
    dds = np.linalg.lstsq(kkt, right, rcond=1e-11)[0][: len(state.s)]
    assert dds[:N] == pytest.approx(ddu, abs=1e-7)
    size = max(np.abs(dds).max(), 1.0)
    assert dds == pytest.approx(ROBOT.accelerations(state, ddu), abs=1e-7 * size)


@given(positions(ROBOT))
def test_mass_matrix_is_pinocchios_projected_with_R(u: np.ndarray) -> None:
    state = ROBOT.close(u)
    mass, _, gravity = ROBOT.minimal_form(state)
    theirs = state.R.T @ ORACLE.mass_matrix(state.s) @ state.R
    assert np.abs(mass - theirs).max() < 1e-11 * np.abs(theirs).max()
    still = np.zeros(len(state.s))
    forces = ORACLE.tree_forces(state.s, still, still)
    size = np.abs(state.R).max() * np.abs(forces).max()
    assert np.abs(state.R.T @ forces - gravity).max() < 1e-12 * size
