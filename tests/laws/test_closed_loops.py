"""Laws of closed mechanisms, on random states of the forging robot."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import ClosedState, Robot, load
from tests.strategies import positions, rates

ROBOT = load("forging_chu2020")
PINS = {c.name: c for c in ROBOT.description.closures}
H = 1e-6  # step of central differences: truncation ~H^2, rounding ~1e-16/H, so they agree to about 1e-8 of the scale


def pin_gaps(robot: Robot, state: ClosedState) -> np.ndarray:
    """Distance vectors between the two halves of every pin, from the link poses in space."""
    gaps = []
    for pin in PINS.values():
        a, b = (robot.forward_kinematics(state, frame=link) for link in (pin.link_a, pin.link_b))
        gaps.append(a.position + a.rotation @ pin.point_a - b.position - b.rotation @ pin.point_b)
    return np.array(gaps)


@given(positions(ROBOT))
def test_every_pin_is_closed_in_space(u: np.ndarray) -> None:
    state = ROBOT.close(u)
    assert np.abs(pin_gaps(ROBOT, state)).max() < 1e-13  # [m]: rounding of coordinates of order 1 m
    assert state.residual < 1e-13


@given(positions(ROBOT), rates(ROBOT))
def test_rates_are_the_derivative_of_the_closure(u: np.ndarray, du: np.ndarray) -> None:
    ahead, behind = (ROBOT.close(u + sign * H * du) for sign in (1, -1))
    state = ROBOT.close(u, du)
    # the third derivative grows with the inverse distance to the toggle point, hence the wide bound
    assert (ahead.s - behind.s) / (2 * H) == pytest.approx(state.ds, abs=1e-6 / float(state.singularity) ** 4)
    assert state.R @ du == pytest.approx(state.ds, abs=1e-12 / float(state.singularity) ** 2)


@given(positions(ROBOT), rates(ROBOT), rates(ROBOT))
def test_accelerations_are_the_derivative_of_the_rates(u: np.ndarray, du: np.ndarray, ddu: np.ndarray) -> None:
    ahead, behind = (ROBOT.close(u + t * du + t * t / 2 * ddu, du + t * ddu) for t in (H, -H))
    state = ROBOT.close(u, du)
    numeric = (ahead.ds - behind.ds) / (2 * H)
    assert numeric == pytest.approx(ROBOT.accelerations(state, ddu), abs=1e-6 / float(state.singularity) ** 6)


@given(positions(ROBOT), rates(ROBOT))
def test_jacobian_is_the_derivative_of_the_pose(u: np.ndarray, du: np.ndarray) -> None:
    state = ROBOT.close(u, du)
    ahead, behind = (ROBOT.forward_kinematics(ROBOT.close(u + sign * H * du)) for sign in (1, -1))
    twist = ROBOT.jacobian(state) @ du
    scale = 1.0 / float(state.singularity) ** 4
    assert (ahead.position - behind.position) / (2 * H) == pytest.approx(twist[:3], abs=1e-6 * scale)
    spin = (ahead.rotation - behind.rotation) / (2 * H) @ ROBOT.forward_kinematics(state).rotation.T
    assert [spin[2, 1], spin[0, 2], spin[1, 0]] == pytest.approx(twist[3:], abs=1e-6 * scale)


@given(positions(ROBOT), rates(ROBOT))
def test_closures_do_no_work(u: np.ndarray, du: np.ndarray) -> None:
    """J_s R = 0: any motion u' keeps every pin closed, so pin forces have no power."""
    state = ROBOT.close(u, du)
    for pin in PINS.values():
        speeds = []
        for link, point in ((pin.link_a, pin.point_a), (pin.link_b, pin.point_b)):
            pose = ROBOT.forward_kinematics(state, frame=link)
            linear, angular = np.split(ROBOT.jacobian(state, frame=link), 2)
            arm = pose.rotation @ point
            speeds.append(linear + np.cross(angular.T, arm).T)
        assert np.abs(speeds[0] - speeds[1]).max() < 1e-11 / float(state.singularity) ** 2


@given(positions(ROBOT))
def test_mass_matrix_is_symmetric_positive_definite(u: np.ndarray) -> None:
    mass, _, _ = ROBOT.minimal_form(ROBOT.close(u))
    assert np.array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass)[0] > 0.0


@given(positions(ROBOT), rates(ROBOT), rates(ROBOT))
def test_minimal_form_is_the_inverse_dynamics(u: np.ndarray, du: np.ndarray, ddu: np.ndarray) -> None:
    state = ROBOT.close(u, du)
    mass, bias, gravity = ROBOT.minimal_form(state)
    tau = ROBOT.inverse_dynamics(state, ddu)
    size = np.abs(mass).max() + np.abs(bias).max() + np.abs(gravity).max()
    assert np.abs(mass @ ddu + bias + gravity - tau).max() < 1e-12 * size


def energy(u: np.ndarray, du: np.ndarray) -> float:
    state = ROBOT.close(u, du)
    mass, _, _ = ROBOT.minimal_form(state)
    potential = 0.0
    for link in ROBOT.description.links.values():
        pose = ROBOT.forward_kinematics(state, frame=link.name)
        potential -= link.mass * float(ROBOT.description.gravity @ (pose.position + pose.rotation @ link.com))
    return float(0.5 * du @ mass @ du + potential)


@given(positions(ROBOT), rates(ROBOT), rates(ROBOT))
def test_power_in_is_the_change_of_energy(u: np.ndarray, du: np.ndarray, ddu: np.ndarray) -> None:
    step = 1e-4  # energies of order 1e3 J: rounding 1e-13 * 1e3 / 1e-4 = 1e-6 W
    ahead, behind = (energy(u + t * du + t * t / 2 * ddu, du + t * ddu) for t in (step, -step))
    state = ROBOT.close(u, du)
    power = float(ROBOT.inverse_dynamics(state, ddu) @ du)
    assert (ahead - behind) / (2 * step) == pytest.approx(power, rel=1e-5, abs=1e-2 / float(state.singularity) ** 5)


@given(positions(ROBOT), rates(ROBOT), rates(ROBOT), st.integers(0, 4))
def test_a_state_in_a_batch_is_the_state_alone(u: np.ndarray, du: np.ndarray, ddu: np.ndarray, row: int) -> None:
    many_u, many_du = np.tile(ROBOT.reference, (5, 1)), np.zeros((5, 4))
    many_u[row], many_du[row] = u, du
    batch, single = ROBOT.close(many_u, many_du), ROBOT.close(u, du)
    size = 1.0 / float(single.singularity) ** 4
    assert batch.s[row] == pytest.approx(single.s, rel=1e-13, abs=1e-13 * size)
    assert batch.R[row] == pytest.approx(single.R, rel=1e-12, abs=1e-12 * size)
    tau = ROBOT.inverse_dynamics(batch, np.tile(ddu, (5, 1)))[row]
    assert tau == pytest.approx(ROBOT.inverse_dynamics(single, ddu), rel=1e-10, abs=1e-8 * size)


@given(positions(ROBOT))
def test_inverse_kinematics_of_a_pose_gives_the_joints_back(u: np.ndarray) -> None:
    pose = ROBOT.forward_kinematics(ROBOT.close(u))
    result = ROBOT.inverse_kinematics(pose, seed=u + 0.01 * (ROBOT.reference - u))
    reached = ROBOT.forward_kinematics(ROBOT.close(result.u))
    assert reached.position == pytest.approx(pose.position, abs=1e-9)
    assert reached.rotation == pytest.approx(pose.rotation, abs=1e-8)
