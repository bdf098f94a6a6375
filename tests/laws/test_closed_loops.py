"""Laws of closed mechanisms, on random states of every shipped robot."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import ClosedState, Robot, load, shipped_robots
from tests.sampling import examples, swept
from tests.strategies import positions, rates

# step of central differences: truncation ~H^2, rounding ~1e-16/H, so they agree to about 1e-8 of
# the scale
H = 1e-6
EXAMPLES = 10  # states a robot and law
REGULAR = 0.05  # states nearer to a singularity are left out: derivatives grow there without bound


@cache
def shipped(name: str) -> Robot:
    return load(name)


@pytest.fixture(params=swept(shipped_robots()), scope="module")
def robot(request: pytest.FixtureRequest) -> Robot:
    return shipped(request.param)


def regular(
    robot: Robot, data: st.DataObject
) -> tuple[np.ndarray, np.ndarray, np.ndarray, ClosedState, float]:
    """A random regular state: u, u', u'', the closed state, and how derivatives may grow there."""
    u, du, ddu = data.draw(positions(robot)), data.draw(rates(robot)), data.draw(rates(robot))
    state = robot.close(u, du, check=False)
    assume(state.status == 0 and state.singularity > REGULAR)
    return u, du, ddu, state, 1.0 / float(state.singularity)


def pin_gaps(robot: Robot, state: ClosedState) -> np.ndarray:
    """Distance vectors between the two halves of every closure, from the link poses in space."""
    gaps = [np.zeros(3)]
    for pin in robot.description.closures:
        a, b = (robot.forward_kinematics(state, frame=link) for link in (pin.link_a, pin.link_b))
        gaps.append(a.position + a.rotation @ pin.point_a - b.position - b.rotation @ pin.point_b)
    return np.array(gaps)


def law(function):
    """A law on a robot and random data, a few states each."""
    return examples(EXAMPLES)(given(data=st.data())(function))


@law
def test_every_closure_closes_in_space(robot: Robot, data: st.DataObject) -> None:
    _, _, _, state, _ = regular(robot, data)
    reach = max(1.0, float(np.abs(robot.forward_kinematics(state).position).max()))
    assert (
        np.abs(pin_gaps(robot, state)).max() < 1e-12 * reach
    )  # rounding of coordinates of that size
    assert state.residual < 1e-12


@law
def test_rates_are_the_derivative_of_the_closure(robot: Robot, data: st.DataObject) -> None:
    u, du, _, state, grow = regular(robot, data)
    ahead, behind = (robot.close(u + sign * H * du, near=state) for sign in (1, -1))
    # the third derivative grows with the inverse distance to the toggle point, hence the wide bound
    assert (ahead.s - behind.s) / (2 * H) == pytest.approx(state.ds, abs=1e-6 * grow**4)
    assert state.R @ du == pytest.approx(state.ds, abs=1e-12 * grow**2)


@law
def test_accelerations_are_the_derivative_of_the_rates(robot: Robot, data: st.DataObject) -> None:
    u, du, ddu, state, grow = regular(robot, data)
    ahead, behind = (
        robot.close(u + t * du + t * t / 2 * ddu, du + t * ddu, near=state) for t in (H, -H)
    )
    numeric = (ahead.ds - behind.ds) / (2 * H)
    assert numeric == pytest.approx(robot.accelerations(state, ddu), abs=1e-6 * grow**6)


@law
def test_jacobian_is_the_derivative_of_the_pose(robot: Robot, data: st.DataObject) -> None:
    u, du, _, state, grow = regular(robot, data)
    ahead, behind = (
        robot.forward_kinematics(robot.close(u + sign * H * du, near=state)) for sign in (1, -1)
    )
    twist = robot.jacobian(state) @ du
    scale = grow**4 * max(1.0, float(np.abs(ahead.position).max()))
    assert (ahead.position - behind.position) / (2 * H) == pytest.approx(
        twist[:3], abs=1e-6 * scale
    )
    spin = (ahead.rotation - behind.rotation) / (2 * H) @ robot.forward_kinematics(state).rotation.T
    assert [spin[2, 1], spin[0, 2], spin[1, 0]] == pytest.approx(twist[3:], abs=1e-6 * scale)


@law
def test_closures_do_no_work(robot: Robot, data: st.DataObject) -> None:
    """J_s R = 0: any motion u' keeps every closure closed, so its forces have no power."""
    _, _, _, state, grow = regular(robot, data)
    for pin in robot.description.closures:
        speeds = []
        for link, point in ((pin.link_a, pin.point_a), (pin.link_b, pin.point_b)):
            pose = robot.forward_kinematics(state, frame=link)
            linear, angular = np.split(robot.jacobian(state, frame=link), 2)
            arm = pose.rotation @ point
            speeds.append(linear + np.cross(angular.T, arm).T)
        assert np.abs(speeds[0] - speeds[1]).max() < 1e-11 * grow**2


@law
def test_mass_matrix_is_symmetric_positive_definite(robot: Robot, data: st.DataObject) -> None:
    _, _, _, state, _ = regular(robot, data)
    mass, _, _ = robot.minimal_form(state)
    assert np.array_equal(mass, mass.T)
    if any(link.mass for link in robot.description.links.values()):
        assert np.linalg.eigvalsh(mass)[0] > 0.0
    else:
        assert not mass.any()


@law
def test_minimal_form_is_the_inverse_dynamics(robot: Robot, data: st.DataObject) -> None:
    _, _, ddu, state, _ = regular(robot, data)
    mass, bias, gravity = robot.minimal_form(state)
    tau = robot.inverse_dynamics(state, ddu)
    size = np.abs(mass).max() + np.abs(bias).max() + np.abs(gravity).max()
    assert np.abs(mass @ ddu + bias + gravity - tau).max() <= 1e-11 * size


def energy(robot: Robot, u: np.ndarray, du: np.ndarray, near: ClosedState) -> float:
    state = robot.close(u, du, near=near)
    mass, _, _ = robot.minimal_form(state)
    potential = 0.0
    for link in robot.description.links.values():
        pose = robot.forward_kinematics(state, frame=link.name)
        potential -= link.mass * float(
            robot.description.gravity @ (pose.position + pose.rotation @ link.com)
        )
    return float(0.5 * du @ mass @ du + potential)


@law
def test_power_in_is_the_change_of_energy(robot: Robot, data: st.DataObject) -> None:
    u, du, ddu, state, grow = regular(robot, data)
    step = 1e-4
    ahead, behind = (
        energy(robot, u + t * du + t * t / 2 * ddu, du + t * ddu, state) for t in (step, -step)
    )
    power = float(robot.inverse_dynamics(state, ddu) @ du)
    weight = sum(link.mass for link in robot.description.links.values()) * 9.81
    # truncation ~ step^2 times a third derivative of the energy [weight times a few m/s]
    assert (ahead - behind) / (2 * step) == pytest.approx(
        power, rel=1e-5, abs=1e-6 * weight * grow**5
    )


@law
def test_a_state_in_a_batch_is_the_state_alone(robot: Robot, data: st.DataObject) -> None:
    u, du, ddu, single, grow = regular(robot, data)
    row = data.draw(st.integers(0, 4))
    many_u, many_du = np.tile(robot.reference, (5, 1)), np.zeros((5, len(robot.active)))
    many_u[row], many_du[row] = u, du
    batch = robot.close(many_u, many_du)
    assert batch.s[row] == pytest.approx(single.s, rel=1e-12, abs=1e-12 * grow**4)
    assert batch.R[row] == pytest.approx(single.R, rel=1e-11, abs=1e-11 * grow**4)
    tau, alone = (
        robot.inverse_dynamics(batch, np.tile(ddu, (5, 1)))[row],
        robot.inverse_dynamics(single, ddu),
    )
    assert tau == pytest.approx(
        alone, rel=1e-9, abs=1e-10 * grow**4 * max(1.0, float(np.abs(alone).max()))
    )


@law
def test_given_passive_coordinates_bring_the_active_ones_back(
    robot: Robot, data: st.DataObject
) -> None:
    """close_given of an active set is close itself, with rates and accelerations."""
    _, du, ddu, state, grow = regular(robot, data)
    names = robot.active
    found = robot.close_given(
        dict(zip(names, state.u, strict=True)),
        dict(zip(names, du, strict=True)),
        dict(zip(names, ddu, strict=True)),
        near=state,
    )
    assert found.s == pytest.approx(state.s, abs=1e-12 * grow**2)
    assert found.dds == pytest.approx(robot.accelerations(state, ddu), abs=1e-9 * grow**4)


@law
def test_inverse_kinematics_of_a_pose_reaches_it(robot: Robot, data: st.DataObject) -> None:
    u, _, _, state, _ = regular(robot, data)
    pose = robot.forward_kinematics(state)
    result = robot.inverse_kinematics(pose, seed=u + 0.01 * (robot.reference - u))
    assume(result.state is not None)
    reached = robot.forward_kinematics(result.state)
    assert reached.position == pytest.approx(pose.position, abs=1e-8)
    assert reached.rotation == pytest.approx(pose.rotation, abs=1e-7)
