"""Laws of the equations of motion, on every robot.

Matrices, full DAE, forward against inverse dynamics.
"""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept

STATES = [(name, k) for name in ROBOTS for k in range(4)]
H = 1e-6  # step of central differences
ROUNDING = 1e-12  # relative to the terms that cancel


def state_of(name: str, k: int) -> ClosedState:
    return random_states(name, 4)[k]


@pytest.mark.parametrize(("name", "k"), swept(STATES))
class TestMinimalForm:
    def test_coriolis_matrix_gives_the_coriolis_forces(self, name: str, k: int) -> None:
        state, machine = state_of(name, k), robot(name)
        _, bias, _ = machine.minimal_form(state)
        matrix = machine.coriolis_matrix(state)
        assert (
            scaled(matrix @ state.du - bias, np.abs(matrix) @ np.abs(state.du), np.ones(1))
            < ROUNDING
        )

    def test_rate_of_the_velocity_map_gives_the_bias_acceleration(self, name: str, k: int) -> None:
        state, machine = state_of(name, k), robot(name)
        assert (
            scaled(machine.velocity_map_rate(state) @ state.du - state.bias, state.bias, np.ones(1))
            < 1e-11
        )

    def test_mass_rate_less_twice_coriolis_is_skew(self, name: str, k: int) -> None:
        """M-bar' along the motion is a central difference; the law itself is exact."""
        state, machine = state_of(name, k), robot(name)
        ahead, behind = (
            machine.minimal_form(machine.close(state.u + s * H * state.du))[0] for s in (1, -1)
        )
        rate = (ahead - behind) / (2 * H)
        matrix = machine.coriolis_matrix(state)
        twist = rate - 2 * matrix
        assert scaled(twist + twist.T, matrix, ahead) < 1e-7 / float(state.singularity) ** 2

    def test_coriolis_matrix_holds_the_christoffel_symbols(self, name: str, k: int) -> None:
        """Which no part of the computation forms: central differences of M-bar."""
        state, machine = state_of(name, k), robot(name)
        slopes = []
        for unit in np.eye(len(state.u)):
            ahead, behind = (
                machine.minimal_form(machine.close(state.u + s * H * unit))[0] for s in (1, -1)
            )
            slopes.append((ahead - behind) / (2 * H))
        slope, du = np.array(slopes), state.du  # (k, i, j)
        symbols = 0.5 * (
            np.einsum("kij,k->ij", slope, du)
            + np.einsum("jik,k->ij", slope, du)
            - np.einsum("ijk,k->ij", slope, du)
        )
        matrix = machine.coriolis_matrix(state)
        assert scaled(matrix - symbols, matrix, slope) < 1e-7 / float(state.singularity) ** 2

    def test_mass_matrix_is_symmetric_positive_definite(self, name: str, k: int) -> None:
        mass, _, _ = robot(name).minimal_form(state_of(name, k))
        assert np.array_equal(mass, mass.T)
        assert np.linalg.eigvalsh(mass)[0] > 0.0

    def test_minimal_form_is_the_inverse_dynamics(self, name: str, k: int) -> None:
        state, machine = state_of(name, k), robot(name)
        mass, bias, gravity = machine.minimal_form(state)
        ddu = random_vector(machine, k)
        rest = machine.passive_forces(state)
        tau = machine.inverse_dynamics(state, ddu)
        assert (
            scaled(mass @ ddu + bias + gravity + rest - tau, mass, bias, gravity, rest) < ROUNDING
        )

    def test_inverse_of_forward_dynamics(self, name: str, k: int) -> None:
        state, machine = state_of(name, k), robot(name)
        tau = random_vector(machine, k, 50.0)
        ddu = machine.forward_dynamics(state, tau)
        again = machine.inverse_dynamics(state, ddu)
        assert scaled(again - tau, tau, machine.minimal_form(state)[1]) < 1e-9


@pytest.mark.parametrize(("name", "k"), swept(STATES))
class TestSpanningTerms:
    def test_equations_hold(self, name: str, k: int) -> None:
        """M s'' + C s' + g + extra + J^T lambda = [tau; 0] and J s'' + J' s' = 0.

        The DAE of Chu (2020), Eq. 10, with J_s of Eq. 16.
        """
        state, machine = state_of(name, k), robot(name)
        ddu = random_vector(machine, k)
        terms, dds = machine.spanning_terms(state, ddu), machine.accelerations(state, ddu)
        tau = np.zeros(len(state.s))
        tau[: state.n] = machine.inverse_dynamics(state, ddu)
        loops = terms.J.T @ terms.multipliers
        inertia = terms.M @ dds
        error = inertia + terms.C @ state.ds + terms.g + terms.extra + loops - tau
        assert scaled(error, inertia, terms.g, loops, tau) < 1e-11
        if len(terms.bias):
            assert scaled(terms.J @ dds + terms.bias, np.abs(terms.J) @ np.abs(dds)) < 1e-11
            assert scaled(terms.J @ state.R, np.abs(terms.J) @ np.abs(state.R)) < 1e-12

    def test_projection_is_the_minimal_form(self, name: str, k: int) -> None:
        """M-bar = R^T M R and C-bar = R^T (M R' + C R)."""
        state, machine = state_of(name, k), robot(name)
        terms, rate = machine.spanning_terms(state), machine.velocity_map_rate(state)
        mass = machine.minimal_form(state)[0]
        assert scaled(state.R.T @ terms.M @ state.R - mass, mass) < 1e-11
        matrix = state.R.T @ (terms.M @ rate + terms.C @ state.R)
        assert scaled(matrix - machine.coriolis_matrix(state), matrix, mass) < 1e-11

    def test_whole_system_gives_the_accelerations(self, name: str, k: int) -> None:
        """[M J^T; J 0] [s''; lambda] = [tau - C s' - g - extra.

        -J' s'], solved as one, is the forward dynamics.
        """
        state, machine = state_of(name, k), robot(name)
        tau = random_vector(machine, k, 20.0)
        terms = machine.spanning_terms(state)
        z = len(terms.bias)
        force = -terms.C @ state.ds - terms.g - terms.extra
        force[: state.n] += tau
        rows = terms.J.reshape(z, len(state.s))
        system = np.block([[terms.M, rows.T], [rows, np.zeros((z, z))]])
        answer = np.linalg.solve(system, np.concatenate([force, -terms.bias]))
        ddu = machine.forward_dynamics(state, tau)
        assert scaled(answer[: state.n] - ddu, answer[: len(state.s)]) < 1e-9


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_a_batch_is_its_states(name: str) -> None:
    machine, states = robot(name), random_states(name, 4)
    u, du = (np.array([getattr(s, key) for s in states]) for key in ("u", "du"))
    tau = np.array([random_vector(machine, k, 30.0) for k in range(4)])
    batch = machine.close(u, du)
    ddu, matrix = machine.forward_dynamics(batch, tau), machine.coriolis_matrix(batch)
    terms = machine.spanning_terms(batch, ddu)
    for k, state in enumerate(states):
        single = machine.forward_dynamics(state, tau[k])
        assert scaled(ddu[k] - single, single, machine.forward_dynamics(state, 0 * tau[k])) < 1e-9
        assert scaled(matrix[k] - machine.coriolis_matrix(state), matrix[k]) < 1e-10
        assert terms.M[k] == pytest.approx(machine.spanning_terms(state).M, rel=1e-9, abs=1e-11)
