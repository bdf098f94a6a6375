"""Functions of PyTorch: values and gradients beside those of the compiled code."""

from functools import cache

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.programs import OutcomeKind
from tests.sampling import swept

torch = pytest.importorskip("torch")

ROBOTS = ("five_bar", "forging_chu2020", "ankle", "excavator")
EXACT = 1e-12  # [-] of the largest value, for sums in another order
shared = cache(load)


def states(robot, count):
    """Active coordinates near the reference, rates and accelerations, which ask for gradients."""
    rng = np.random.default_rng(5)
    n = len(robot.active)
    u = robot.reference + 0.02 * rng.uniform(-1.0, 1.0, (count, n))
    arrays = (u, rng.normal(size=(count, n)), rng.normal(size=(count, n)))
    return tuple(torch.tensor(array, requires_grad=True) for array in arrays)


@pytest.mark.parametrize("name", swept(ROBOTS, sample=("five_bar", "ankle")))
def test_values_and_gradients_are_those_of_the_library(name):
    robot = shared(name)
    u, du, ddu = states(robot, 3)
    arrays = [tensor.detach().numpy() for tensor in (u, du, ddu)]
    tau, status = robot.torch.inverse_dynamics(u, du, ddu)
    assert not status.any()
    right = robot.kernels.inverse_dynamics(*arrays)
    np.testing.assert_allclose(tau.detach(), right, rtol=0.0, atol=EXACT * np.abs(right).max())
    weights = torch.tensor(np.random.default_rng(6).normal(size=tau.shape))
    gradients = torch.autograd.grad((weights * tau).sum(), (u, du, ddu))
    state = robot.close(*arrays[:2])
    for ours, slope in zip(
        gradients, robot.inverse_dynamics_derivatives(state, arrays[2]), strict=True
    ):
        right = np.einsum("ni,nij->nj", weights.numpy(), slope)
        np.testing.assert_allclose(ours, right, rtol=0.0, atol=EXACT * np.abs(right).max())


def test_every_call_passes_the_check_of_pytorch():
    """Its differences have about six digits in 64 bits."""
    robot = shared("five_bar")
    u, du, tau = states(robot, 2)
    gravity = torch.tensor([0.5, 0.0, -9.81], dtype=torch.float64, requires_grad=True)
    calls = robot.torch
    check = torch.autograd.gradcheck
    assert check(lambda *x: calls.close(*x)[:2], (u, du))
    assert check(lambda x: calls.forward_kinematics(x)[:2], (u,))
    assert check(lambda x: calls.jacobian(x)[0], (u,))
    assert check(lambda *x: calls.minimal_form(*x)[:3], (u, du, gravity))
    assert check(lambda *x: calls.forward_dynamics(*x)[0], (u, du, tau, gravity))


def test_rates_and_gravity_of_all_states_get_the_sum_of_the_gradients():
    robot = shared("five_bar")
    u, du, ddu = states(robot, 4)
    rate = du[0].detach().requires_grad_()
    tau, _ = robot.torch.inverse_dynamics(u.detach().reshape(2, 2, 3), rate, ddu[0].detach())
    assert tau.shape == (2, 2, 3)
    (gradient,) = torch.autograd.grad(tau.sum(), rate)
    total = np.zeros(3)
    for row in u.detach().numpy():
        state = robot.close(row, rate.detach().numpy())
        total += robot.inverse_dynamics_derivatives(state, ddu[0].detach().numpy())[1].sum(axis=0)
    np.testing.assert_allclose(gradient, total, rtol=1e-12, atol=1e-14)


def test_types_of_the_arguments_are_those_of_the_results():
    robot = shared("five_bar")
    u, du, ddu = (tensor.detach().float() for tensor in states(robot, 2))
    tau, status = robot.torch.inverse_dynamics(u, du, ddu)
    assert tau.dtype == torch.float32
    assert not status.any()
    arrays = [tensor.double().numpy() for tensor in (u, du, ddu)]
    right = robot.kernels.inverse_dynamics(*arrays)
    np.testing.assert_allclose(tau, right, rtol=1.2e-7)  # computed in 64 bits, rounded at the end


def test_what_does_not_close_is_nan_with_its_status():
    robot = shared("forging_chu2020")
    u = np.array([robot.reference] * 3)
    u[1, 1] = 5.0  # [m], longer than its loop
    u[2, 0] = np.nan
    position, _, status = robot.torch.forward_kinematics(u)
    assert status.tolist() == [
        OutcomeKind.CLOSED,
        OutcomeKind.UNREACHABLE,
        OutcomeKind.NOT_FINITE,
    ]
    assert torch.isfinite(position[0]).all()
    assert torch.isnan(position[1:]).all()


@pytest.mark.parametrize("name", ["forging_chu2020", "ankle"])
def test_what_does_not_close_has_no_gradient(name):
    robot = shared(name)
    u, du, ddu = states(robot, 2)
    far = torch.stack([u[0], u[1] + 50.0])
    tau, status = robot.torch.inverse_dynamics(far, du, ddu)
    assert [bool(code) for code in status] == [False, True]
    (gradient,) = torch.autograd.grad(tau.sum(), ddu)
    assert torch.isfinite(gradient[0]).all()
    assert torch.isnan(gradient[1]).all()


def test_an_iterated_robot_goes_in_steps():
    robot = shared("ankle")
    far = robot.reference + 0.6
    assert robot.torch.forward_kinematics(far)[2] == OutcomeKind.JUMP
    start = None
    for share in np.linspace(0.0, 1.0, 11)[1:]:
        u = torch.tensor(robot.reference + share * 0.6, dtype=torch.float32)
        start, status = robot.torch.step(u, start=start)
        assert status == OutcomeKind.CLOSED
    position, _, status = robot.torch.forward_kinematics(far, start=start)
    assert status == OutcomeKind.CLOSED
    right = robot.forward_kinematics(robot.close(far)).position
    np.testing.assert_allclose(position, right, rtol=0.0, atol=1e-12)


def test_wrong_shapes_and_second_derivatives_are_refused():
    robot = shared("five_bar")
    with pytest.raises(InputError, match=r"u has shape \(2,\); expected \(\.\.\., 3\)"):
        robot.torch.forward_kinematics(np.zeros(2))
    u = torch.tensor(robot.reference, requires_grad=True)
    position, _, _ = robot.torch.forward_kinematics(u)
    (slope,) = torch.autograd.grad((position**2).sum(), u, create_graph=True)
    with pytest.raises(RuntimeError, match="once_differentiable"):
        slope.sum().backward()
