"""A simulated motion against the full DAE in all coordinates, with Pinocchio's tree and pins."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hybrid_dynamics_core import load
from hybrid_dynamics_core.simulation import simulate
from tests.agreement.pinocchio_model import PinocchioRobot


@pytest.mark.parametrize(
    ("name", "u", "du"),
    [
        ("forging_chu2020", [0.0, 0.3, 0.1, 0.0], [0.5, 0.1, 0.1, 1.0]),
        ("excavator", [0.0, 0.7, 0.8, 0.6], [0.3, 0.0, 0.1, 0.0]),
    ],
)
def test_fall_is_that_of_the_constrained_tree(name: str, u: list[float], du: list[float]) -> None:
    robot = load(name)
    theirs = PinocchioRobot(robot.description, robot.coordinates)
    size = len(robot.coordinates)

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        s, ds = y[:size], y[size:]
        _, jacobian = theirs.gaps(s)
        m = len(jacobian)
        system = np.block([[theirs.mass_matrix(s), -jacobian.T], [jacobian, np.zeros((m, m))]])
        force = -theirs.tree_forces(s, ds, np.zeros(size))
        right = np.concatenate([force, -theirs.bias(s, ds)])
        return np.concatenate([ds, np.linalg.lstsq(system, right, rcond=1e-11)[0][:size]])

    ours = simulate(robot, u, du, t_span=(0.0, 0.3))
    start = ours.state
    y = solve_ivp(
        slope,
        (0.0, 0.3),
        np.concatenate([start.s[0], start.ds[0]]),
        method="DOP853",
        rtol=1e-9,
        atol=1e-10,
    )
    # The DAE drifts off its loops, at this order.
    assert y.y[:size, -1] == pytest.approx(start.s[-1], abs=1e-6)
    assert y.y[size:, -1] == pytest.approx(start.ds[-1], abs=1e-5)
