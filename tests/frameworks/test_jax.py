"""Pure functions of JAX: values and derivatives beside those of the compiled code."""

from functools import cache

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load, shipped_robots
from hybrid_dynamics_core.programs import OutcomeKind
from tests.sampling import swept

jax = pytest.importorskip("jax")

EXACT = 1e-12  # [-] of the largest value, for sums in another order
ROBOTS = shipped_robots()
TRACED = ("five_bar", "forging_chu2020", "ankle", "palletizer", "excavator", "delta", "staicu2015")
CASES = (*ROBOTS, *[f"{name} traced" for name in TRACED])
COMPILED = ("five_bar", "ankle")  # the sample of calls by machine code


shared = cache(load)  # JAX compiles each function of a robot once


@pytest.fixture(autouse=True)
def double():
    """64 bits, as robots are computed elsewhere."""
    with jax.enable_x64(True):
        yield


def states(robot, count, width=0.02):
    """Active coordinates near the reference, rates and accelerations."""
    rng = np.random.default_rng(5)
    n = len(robot.active)
    u = robot.reference + width * rng.uniform(-1.0, 1.0, (count, n))
    return u, rng.normal(size=(count, n)), rng.normal(size=(count, n))


def agree(ours, right):
    scale = np.abs(right).max() or 1.0
    np.testing.assert_allclose(np.asarray(ours) / scale, right / scale, rtol=0.0, atol=EXACT)


def robot_and_calls(case):
    """A robot, and its calls by machine code of the library; or those that XLA compiles."""
    name, *traced = case.split()
    robot = shared(name)
    return robot, robot.jax.traced if traced else robot.jax


@pytest.mark.parametrize("case", swept(CASES, sample=COMPILED))
def test_every_call_has_the_values_of_the_compiled_one(case):
    robot, calls = robot_and_calls(case)
    u, du, ddu = states(robot, 50)
    s, ds, status = calls.close(u, du)
    closed = robot.kernels.close(u, du)
    assert not np.any(status)
    agree(s, closed[0])
    agree(ds, closed[1])
    *pose, _ = calls.forward_kinematics(u)
    for ours, right in zip(pose, robot.kernels.forward_kinematics(u), strict=True):
        agree(ours, right)
    agree(calls.jacobian(u)[0], robot.kernels.jacobian(u))
    tau = robot.kernels.inverse_dynamics(u, du, ddu)
    agree(calls.inverse_dynamics(u, du, ddu)[0], tau)
    if robot.description.name != "staicu2015":  # without masses
        agree(calls.forward_dynamics(u, du, tau)[0], ddu)
    *terms, _ = calls.minimal_form(u, du)
    for ours, right in zip(terms, robot.kernels.minimal_form(u, du), strict=True):
        agree(ours, right)


@pytest.mark.parametrize("case", swept(CASES, sample=(*COMPILED, "five_bar traced")))
def test_derivatives_are_those_of_the_exact_programs(case):
    robot, calls = robot_and_calls(case)
    u, du, ddu = (rows[0] for rows in states(robot, 1))
    state = robot.close(u, du)
    by_all = jax.jacobian(lambda *x: calls.inverse_dynamics(*x)[0], argnums=(0, 1, 2))
    rights = robot.inverse_dynamics_derivatives(state, ddu)
    for ours, right in zip(by_all(u, du, ddu), rights, strict=True):
        agree(ours, right)
    by_u = jax.jacfwd(lambda u: calls.close(u, du)[0])(u)
    agree(by_u, state.R)


def test_gradients_of_batches_are_those_of_states():
    robot = shared("five_bar")
    u, du, tau = states(robot, 3)

    def cost(u, tau):
        ddu, _ = robot.jax.forward_dynamics(u, du, tau)
        return (ddu**2).sum()

    by_u, by_tau = jax.grad(cost, argnums=(0, 1))(u, tau)
    for k in range(3):
        state = robot.close(u[k], du[k])
        ddu = robot.forward_dynamics(state, tau[k])
        d_u, _, d_tau = robot.forward_dynamics_derivatives(state, tau[k])
        agree(by_u[k], 2.0 * ddu @ d_u)
        agree(by_tau[k], 2.0 * ddu @ d_tau)


def test_mapped_over_any_inputs_at_any_depth():
    """Vectors that all states share stay shared; axes come in the order of the maps."""
    robot = shared("ankle")
    u, du, ddu = states(robot, 3)

    def tau(u, du, ddu):
        return robot.jax.inverse_dynamics(u, du, ddu)[0]

    over_rates = jax.vmap(tau, in_axes=(None, 0, None))
    grid = jax.jit(jax.vmap(over_rates, in_axes=(0, None, None)))(u, du[:2], ddu[0])
    again = jax.vmap(over_rates, in_axes=(0, 0, None))(u, np.stack([du[:2]] * 3), ddu[0])
    for k in range(3):
        for j in range(2):
            right = robot.kernels.inverse_dynamics(u[k], du[j], ddu[0])
            agree(grid[k, j], right)
            agree(again[k, j], right)
    assert robot.jax.inverse_dynamics(u[:0], du[:0], ddu[:0])[0].shape == (0, 2)


def test_in_a_loop_of_jax():
    robot = shared("five_bar")
    u, du, ddu = (rows[0] for rows in states(robot, 1))

    def advance(carried, _):
        tau, status = robot.jax.inverse_dynamics(carried, du, ddu)
        return carried + 1e-3 * du, (tau, status)

    _, (efforts, status) = jax.lax.scan(advance, u, None, length=20)
    rows = u + 1e-3 * np.arange(20)[:, None] * du
    assert not np.any(status)
    agree(efforts, robot.kernels.inverse_dynamics(rows, du, ddu))


@pytest.mark.sweep(sample="test_derivatives_are_those_of_the_exact_programs")
def test_gradients_through_a_motion_are_those_of_traced_calls():
    robot = shared("five_bar")
    efforts = 0.01 * np.random.default_rng(3).normal(size=(20, 3))

    def distance(calls):
        @jax.checkpoint
        def step(state, tau):
            u, du = state
            ddu, _ = calls.forward_dynamics(u, du, tau)
            return (u + 1e-3 * du, du + 1e-3 * ddu), None

        def of_efforts(efforts):
            (u, du), _ = jax.lax.scan(step, (robot.reference, np.zeros(3)), efforts)
            return (u**2).sum() + (du**2).sum()

        return of_efforts

    ours = jax.jit(jax.grad(distance(robot.jax)))(efforts)
    agree(ours, np.asarray(jax.jit(jax.grad(distance(robot.jax.traced)))(efforts)))


def test_without_machine_code_xla_compiles(monkeypatch):
    robot = load("five_bar")
    u, du, ddu = states(robot, 2)
    right, _ = robot.jax.inverse_dynamics(u, du, ddu)
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
    tau, status = load("five_bar").jax.inverse_dynamics(u, du, ddu)
    assert not np.any(status)
    agree(tau, np.asarray(right))


@pytest.mark.sweep(sample="test_gradients_of_batches_are_those_of_states")
def test_second_derivatives_are_those_of_the_first():
    robot = shared("five_bar")
    u, du, ddu = (rows[0] for rows in states(robot, 1))
    second = jax.hessian(lambda u: robot.jax.inverse_dynamics(u, du, ddu)[0][0])(u)
    step = 1e-6
    for k in range(len(u)):
        sides = []
        for sign in (1.0, -1.0):
            moved = robot.close(u + sign * step * np.eye(len(u))[k], du)
            sides.append(robot.inverse_dynamics_derivatives(moved, ddu)[0][0])
        numeric = (sides[0] - sides[1]) / (2.0 * step)
        # central differences of a step of 1e-6 have about nine digits
        np.testing.assert_allclose(second[k], numeric, rtol=1e-6, atol=1e-6)


def test_derivatives_by_gravity():
    robot = shared("five_bar")
    u, du, ddu = (rows[0] for rows in states(robot, 1))
    slope = jax.jacobian(lambda g: robot.jax.inverse_dynamics(u, du, ddu, gravity=g)[0])
    for k, unit in enumerate(np.eye(3)):
        above = robot.kernels.inverse_dynamics(u, du, ddu, gravity=unit)
        below = robot.kernels.inverse_dynamics(u, du, ddu, gravity=-unit)
        column = 0.5 * (above - below)  # efforts are linear in gravity
        agree(np.asarray(slope(np.zeros(3)))[:, k], column)


def test_what_does_not_close_is_nan_with_its_status():
    robot = shared("forging_chu2020")
    u = np.array([robot.reference] * 3)
    u[1, 1] = 5.0  # [m], longer than its loop
    u[2, 0] = np.nan
    position, rotation, status = robot.jax.forward_kinematics(u)
    assert status.tolist() == [
        OutcomeKind.CLOSED,
        OutcomeKind.UNREACHABLE,
        OutcomeKind.NOT_FINITE,
    ]
    for values in (position, rotation):
        assert np.isfinite(values[0]).all()
        assert np.isnan(values[1:]).all()


def test_functions_are_mapped_and_compiled():
    robot = shared("five_bar")
    u, du, ddu = states(robot, 4)
    whole, _ = robot.jax.inverse_dynamics(u, du, ddu)
    mapped = jax.jit(jax.vmap(lambda *x: robot.jax.inverse_dynamics(*x)[0]))(u, du, ddu)
    agree(mapped, np.asarray(whole))


@pytest.mark.parametrize(
    ("case", "error"),
    swept(
        [
            ("five_bar", 2e-7),  # rounded once
            ("ankle", 2e-7),
            ("five_bar traced", 2e-5),  # a sum of some hundred products, each rounded to 6e-8
        ],
        sample=COMPILED,
    ),
)
def test_digits_of_32_bits(case, error):
    robot, calls = robot_and_calls(case)
    rounded = [x.astype(np.float32) for x in states(robot, 20)]
    right = robot.kernels.inverse_dynamics(*(x.astype(float) for x in rounded))
    tau, status = calls.inverse_dynamics(*rounded)
    assert tau.dtype == np.float32
    assert not np.any(status)
    assert np.abs(np.asarray(tau) - right).max() < error * np.abs(right).max()
    one, _ = calls.inverse_dynamics(*(x[0] for x in rounded))
    assert np.abs(np.asarray(one) - right[0]).max() < error * np.abs(right).max()
    moved, status = calls.step(rounded[0][0])
    assert status == OutcomeKind.CLOSED
    _, status = calls.step(rounded[0][0], start=moved)  # a rounded start is closed too
    assert status == OutcomeKind.CLOSED
    slope = jax.jacobian(lambda u: calls.inverse_dynamics(u, *(x[0] for x in rounded[1:]))[0])
    state = robot.close(rounded[0][0].astype(float), rounded[1][0].astype(float))
    exact = robot.inverse_dynamics_derivatives(state, rounded[2][0].astype(float))[0]
    assert np.abs(np.asarray(slope(rounded[0][0])) - exact).max() < 10 * error * np.abs(exact).max()


def test_without_64_bits_arrays_become_32_bits():
    robot = shared("five_bar")
    with jax.enable_x64(False):
        tau, status = robot.jax.inverse_dynamics(*states(robot, 3))
    assert tau.dtype == np.float32
    assert not np.any(status)


@pytest.mark.sweep(sample="test_what_does_not_close_is_nan_with_its_status")
def test_far_from_its_start_an_iterated_robot_says_jump_and_steps_go_there():
    robot = shared("ankle")
    far = robot.reference + 0.6
    _, status = robot.jax.forward_kinematics(far)[1:]
    assert status == OutcomeKind.JUMP
    start = None
    for share in np.linspace(0.0, 1.0, 11)[1:]:
        start, status = robot.jax.step(robot.reference + share * 0.6, start=start)
        assert status == OutcomeKind.CLOSED
    position, _, status = robot.jax.forward_kinematics(far, start=start)
    assert status == OutcomeKind.CLOSED
    state = robot.close(far)
    agree(position, robot.forward_kinematics(state).position)


@pytest.mark.parametrize("name", swept(("gough", "forging_chu2020"), sample=("forging_chu2020",)))
def test_what_does_not_close_has_no_derivative(name):
    calls = shared(name).jax
    u = jax.numpy.asarray(shared(name).reference) + 50.0
    still = jax.numpy.zeros(u.shape)

    def efforts(u):
        return calls.inverse_dynamics(u, still, still)[0]

    for derivative in (jax.jacfwd, jax.jacrev):
        assert np.isnan(derivative(efforts)(u)).all()


def test_wrong_shapes_and_frames_are_refused():
    robot = shared("five_bar")
    with pytest.raises(InputError, match=r"u has shape \(2,\); expected \(\.\.\., 3\)"):
        robot.jax.forward_kinematics(np.zeros(2))
    with pytest.raises(InputError, match="there is no frame 'nowhere'"):
        robot.jax.at("nowhere")
