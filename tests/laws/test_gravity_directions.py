"""Code for gravity along an axis has the values of code for any gravity, and never other ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given

from hybrid_dynamics_core import ClosedState, InputError, Robot, programs
from hybrid_dynamics_core.dynamics.load_pattern import LoadPattern
from hybrid_dynamics_core.programs import Program
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.robots import ROBOTS, random_states, random_vector, robot
from tests.sampling import swept

DIRECTIONS = ((0.0, 0.0, -9.81), (0.0, 9.81, 0.0), (-3.7, 0.0, 1.6), (0.0, 0.0, 0.0))
OBLIQUE = np.array([1.0, 2.0, -9.8])
# of the largest value: the same sums, with fewer terms and rounded in another order
ROUNDING = 1e-11
PROGRAMS: tuple[Callable[[LoadPattern], Program], ...] = (
    programs.inverse_dynamics,
    programs.forward_dynamics,
    programs.minimal_form,
    programs.spanning_terms,
)


def require_equal(machine: Robot, state: ClosedState, seed: int) -> None:
    gravity = DIRECTIONS[seed % len(DIRECTIONS)]
    pattern, values = machine._dynamics.pack(machine.loads.with_gravity(gravity))
    assert pattern.gravity == tuple(component != 0.0 for component in gravity)
    vector = random_vector(machine, seed)
    inputs = {"u": state.u, "du": state.du, "ddu": vector, "tau": vector}
    inputs |= {"branch": state.signs, "guess": state.s, "gravity": gravity, **values}
    for make in PROGRAMS:
        along_axes = run(machine, make(pattern), inputs)
        along_any = run(machine, make(pattern.under_any_gravity()), inputs)
        for name, expected in along_any.items():
            size = np.abs(expected).max(initial=1e-3)
            np.testing.assert_allclose(along_axes[name], expected, atol=ROUNDING * size, rtol=0.0)


def run(machine: Robot, program: Program, inputs: dict[str, object]) -> dict[str, np.ndarray]:
    """Values of a program, without a compiler."""
    kernel = program.kernel(machine._model.program_model, "program")
    kernel.backend = "python"
    arguments = [np.array(inputs[name], dtype=float) for name in program.inputs]
    values, _ = kernel(*arguments)
    return values


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_shipped_robots_and_mechanisms(name: str) -> None:
    for seed, state in enumerate(random_states(name, len(DIRECTIONS))):
        require_equal(robot(name), state, seed)


@examples(12)
@given(robots(), STATES)
def test_random_robots(case: Case, seed: int) -> None:
    state = case.robot.close(case.somewhere(seed)[: case.n], case.rates(seed))
    require_equal(case.robot, state, seed)


@pytest.mark.parametrize("name", ["type_c", "ankle"])
def test_calls_under_another_gravity(name: str) -> None:
    """A closed form, and loops that are iterated and followed."""
    machine = robot(name)
    assert machine.loads.gravity.tolist()[:2] == [0.0, 0.0]
    kernels = machine.kernels
    under = kernels.under(machine.loads.with_gravity(OBLIQUE))
    u, du = machine.reference + 1e-3, np.full(len(machine.active), 0.2)
    ddu = random_vector(machine, 1)
    expected = under.inverse_dynamics(u, du, ddu)
    assert np.abs(expected - kernels.inverse_dynamics(u, du, ddu)).max() > 1e-3  # it matters
    out = np.empty_like(expected)
    kernels.inverse_dynamics(u, du, ddu, out, gravity=OBLIQUE)
    given_start = kernels.inverse_dynamics(u, du, ddu, start=kernels.start(), gravity=OBLIQUE)
    for found in (kernels.inverse_dynamics(u, du, ddu, gravity=OBLIQUE), out, given_start):
        np.testing.assert_allclose(found, expected, rtol=1e-12)
    batch = np.tile(u, (2, 1)), np.tile(du, (2, 1)), np.tile(ddu, (2, 1))
    both = kernels.inverse_dynamics(*batch, gravity=np.array([machine.loads.gravity, OBLIQUE]))
    np.testing.assert_allclose(both[1], expected, rtol=1e-12)
    np.testing.assert_allclose(both[0], kernels.inverse_dynamics(u, du, ddu), rtol=1e-12)
    with pytest.raises(InputError, match="gravity holds values that are not finite"):
        kernels.inverse_dynamics(u, du, ddu, gravity=[0.0, np.nan, -9.81])
    with pytest.raises(InputError, match="gravity has shape"):
        kernels.inverse_dynamics(u, du, ddu, gravity=[0.0, 0.0])


def test_the_first_joint_along_gravity_needs_no_angle() -> None:
    machine = robot("forging_chu2020")
    pattern, _ = machine._dynamics.pack(machine.loads)
    trace = programs.inverse_dynamics(pattern).kernel(machine._model.program_model, "tau").trace
    operations = {trace.graph.nodes[index][0] for index in trace.live}
    assert not operations & {"sin", "cos"}
