"""Functions of CasADi beside the compiled code."""

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.programs import OutcomeKind
from tests.sampling import swept

casadi = pytest.importorskip("casadi")

EXACT = 1e-12  # [-] of the largest value, for sums in another order
ROBOTS = ("five_bar", "forging_chu2020", "ankle", "palletizer", "excavator", "delta", "gough")


def agree(ours, right, tolerance=EXACT):
    scale = np.abs(right).max() or 1.0
    ours = np.asarray(ours.full()).reshape(np.shape(right))
    np.testing.assert_allclose(ours / scale, right / scale, rtol=0.0, atol=tolerance)


def one_state(robot, width=0.02):
    rng = np.random.default_rng(7)
    n = len(robot.active)
    u = robot.reference + width * rng.uniform(-1.0, 1.0, n)
    return u, rng.normal(size=n), rng.normal(size=n)


@pytest.mark.parametrize("name", swept(ROBOTS, sample=("forging_chu2020", "ankle")))
def test_functions_have_the_values_and_derivatives_of_the_library(name):
    robot = load(name)
    u, du, ddu = one_state(robot)
    state = robot.close(u, du)
    s, ds, status = robot.casadi.close(u, du)
    assert status == OutcomeKind.CLOSED
    agree(s, state.s)
    agree(ds, state.ds)
    position, rotation, _ = robot.casadi.forward_kinematics(u)
    pose = robot.forward_kinematics(state)
    agree(position, pose.position)
    agree(rotation, pose.rotation)
    agree(robot.casadi.jacobian(u)[0], robot.jacobian(state))
    tau = robot.inverse_dynamics(state, ddu)
    agree(robot.casadi.inverse_dynamics(u, du, ddu)[0], tau)
    agree(robot.casadi.forward_dynamics(u, du, tau)[0], ddu, 1e-10)  # a linear system
    for ours, right in zip(
        robot.casadi.minimal_form(u, du)[:3], robot.minimal_form(state)[:3], strict=True
    ):
        agree(ours, right)
    x = [casadi.MX.sym(key, len(u)) for key in ("u", "du", "ddu")]
    efforts, _ = robot.casadi.inverse_dynamics(*x)
    slopes = casadi.Function("slopes", x, [casadi.jacobian(efforts, one) for one in x])
    rights = robot.inverse_dynamics_derivatives(state, ddu)
    for ours, right in zip(slopes(u, du, ddu), rights, strict=True):
        agree(ours, right, 1e-10)  # through the solved loops


@pytest.mark.parametrize("name", ["forging_chu2020", "ankle"])
def test_second_derivatives_are_those_of_the_exact_first_ones(name):
    robot = load(name)
    u, du, ddu = one_state(robot)
    x = casadi.MX.sym("u", len(u))
    total = casadi.sum1(robot.casadi.inverse_dynamics(x, du, ddu)[0])
    second = casadi.Function("second", [x], [casadi.hessian(total, x)[0]])(u)
    step = 1e-6
    numeric = []
    for unit in np.eye(len(u)):
        slopes = []
        for sign in (1.0, -1.0):
            state = robot.close(u + sign * step * unit, du)
            slopes.append(robot.inverse_dynamics_derivatives(state, ddu)[0].sum(axis=0))
        numeric.append((slopes[0] - slopes[1]) / (2.0 * step))
    # central differences of a step of 1e-6 have about nine digits
    agree(second, np.array(numeric), 1e-7)


def test_what_does_not_close_has_its_status():
    robot = load("forging_chu2020")
    u = robot.reference.copy()
    u[1] = 5.0  # [m], longer than its loop
    assert robot.casadi.forward_kinematics(u)[2] == OutcomeKind.UNREACHABLE


def test_from_another_state_on_its_mode():
    robot = load("ankle")
    far = robot.reference + 0.6
    assert robot.casadi.forward_kinematics(far)[2] == OutcomeKind.JUMP
    state = robot.close(far)
    position, _, status = robot.casadi.near(state).forward_kinematics(far - 0.01)
    assert status == OutcomeKind.CLOSED
    agree(position, robot.forward_kinematics(robot.close(far - 0.01, near=state)).position)


def test_a_map_and_generated_code(tmp_path):
    robot = load("forging_chu2020")
    u, du, ddu = one_state(robot)
    function = robot.casadi.inverse_dynamics
    columns = [np.stack([x] * 3, axis=1) for x in (u, du, ddu)]
    agree(function.map(3)(*columns)[0][:, 2], robot.kernels.inverse_dynamics(u, du, ddu))
    generator = casadi.CodeGenerator("model.c")
    generator.add(function)
    generator.generate(f"{tmp_path}/")
    assert function.name() in (tmp_path / "model.c").read_text()


def test_wrong_states_and_frames_are_refused():
    robot = load("five_bar")
    with pytest.raises(InputError, match="there is no frame 'nowhere'"):
        robot.casadi.at("nowhere")
    batch = robot.close([robot.reference] * 2)
    with pytest.raises(InputError, match="expected one closed state"):
        robot.casadi.near(batch)
