"""Derivatives of inverse and forward dynamics against central differences of fourth order, on every
robot.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, Robot
from tests.laws.test_loads import heavy_loads
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept

H = 2e-4  # truncation H^4 and rounding 1e-16 / H meet at about 1e-12 of the higher derivatives
ROUNDING = 1e-12  # the mass matrix comes out of two programs, which round in different orders


def slope(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """d function / d at, (m, n)."""
    columns = []
    for unit in np.eye(len(at)) * H:
        near, far = (function(at + k * unit) - function(at - k * unit) for k in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * H))
    return np.stack(columns, axis=-1)


def moved(machine: Robot, state: ClosedState, u: np.ndarray, du: np.ndarray) -> ClosedState:
    return machine.close(u, du, near=state)


def tolerance(state: ClosedState) -> float:
    """The fifth derivatives that the differences leave out grow near singular places."""
    return 1e-8 / min(1.0, float(state.singularity)) ** 2


@pytest.mark.parametrize("laden", [False, True], ids=["bare", "laden"])
@pytest.mark.parametrize("name", swept(ROBOTS))
class TestDerivatives:
    def test_inverse_dynamics(self, name: str, laden: bool) -> None:
        machine, ddu = robot(name), random_vector(robot(name), 1)
        loads = heavy_loads(machine) if laden else machine.loads
        for state in random_states(name)[: 1 if laden else 2]:
            d_u, d_du, d_ddu = machine.inverse_dynamics_derivatives(state, ddu, loads)

            def tau(u: np.ndarray, du: np.ndarray, near: ClosedState = state) -> np.ndarray:
                return machine.inverse_dynamics(moved(machine, near, u, du), ddu, loads)

            by_u = slope(lambda u, s=state: tau(u, s.du), state.u)
            by_du = slope(lambda du, s=state: tau(s.u, du), state.du)
            assert scaled(d_u - by_u, by_u, d_ddu) < tolerance(state)
            assert scaled(d_du - by_du, by_du, d_ddu) < tolerance(state)
            mass = machine.minimal_form(state, loads)[0]
            assert scaled(d_ddu - mass, mass) < ROUNDING

    def test_forward_dynamics(self, name: str, laden: bool) -> None:
        machine, tau = robot(name), random_vector(robot(name), 2, 30.0)
        loads = heavy_loads(machine) if laden else machine.loads
        for state in random_states(name)[: 1 if laden else 2]:
            d_u, d_du, d_tau = machine.forward_dynamics_derivatives(state, tau, loads)

            def ddu(u: np.ndarray, du: np.ndarray, near: ClosedState = state) -> np.ndarray:
                return machine.forward_dynamics(moved(machine, near, u, du), tau, loads)

            by_u = slope(lambda u, s=state: ddu(u, s.du), state.u)
            by_du = slope(lambda du, s=state: ddu(s.u, du), state.du)
            size = ddu(state.u, state.du)
            assert scaled(d_u - by_u, by_u, size) < tolerance(state)
            assert scaled(d_du - by_du, by_du, size) < tolerance(state)
            unit = d_tau @ machine.minimal_form(state, loads)[0]
            assert unit == pytest.approx(np.eye(state.n), abs=1e-9)


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_one_undoes_the_other(name: str) -> None:
    """With u'' = FD(u, u', ID(u, u', u'')):  d FD/du + d FD/d tau d ID/du = 0, and for u' alike.

    No differences.
    """
    machine, ddu = robot(name), random_vector(robot(name), 3)
    for state in random_states(name):
        tau = machine.inverse_dynamics(state, ddu)
        of_tau = machine.inverse_dynamics_derivatives(state, ddu)
        of_ddu = machine.forward_dynamics_derivatives(state, tau)
        for k in (0, 1):
            assert (
                scaled(
                    of_ddu[k] + of_ddu[2] @ of_tau[k],
                    of_ddu[k],
                    np.abs(of_ddu[2]) @ np.abs(of_tau[k]),
                )
                < 1e-9
            )


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_a_batch_is_its_states(name: str) -> None:
    machine, states = robot(name), random_states(name)
    batch = machine.close(np.array([s.u for s in states]), np.array([s.du for s in states]))
    ddu = np.ones_like(batch.u)
    many = machine.inverse_dynamics_derivatives(batch, ddu)
    for k, state in enumerate(states):
        for rows, single in zip(
            many, machine.inverse_dynamics_derivatives(state, ddu[k]), strict=True
        ):
            assert scaled(rows[k] - single, single, many[2][k]) < 1e-9
