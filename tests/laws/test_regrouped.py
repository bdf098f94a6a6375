"""Inertial parameters moved between links, and common axes of links with parallel joints.

The forces along active joints stay the same. The oracle is the plain text on the described
parameters, in link axes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.dynamics.load_pattern import LoadPattern
from hybrid_dynamics_core.dynamics.loads import Loads
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kernels.run import Kernel
from hybrid_dynamics_core.kernels.trace import Results
from hybrid_dynamics_core.programs import inverse_dynamics
from hybrid_dynamics_core.programs.dynamics import Dynamics
from hybrid_dynamics_core.programs.model import AT_ACCELERATION, Inputs, Model, with_loads
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.laws.test_loads import heavy_loads
from tests.robots import ROBOTS, random_states, random_vector, robot
from tests.sampling import swept
from tests.spinning import far_away, reframed

GRAVITY = np.array([1.0, 2.0, -9.8])  # along no axis of any robot
# of the largest effort or inertia: parts of a sum may be far larger than the sum
ROUNDING = 1e-11


def kernel(machine: Robot, pattern: LoadPattern, *, minimal: bool) -> tuple[Kernel, Sequence[str]]:
    """Efforts and M-bar from regrouped or described parameters, without a compiler."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=minimal)
        tau = dynamics.inverse(list(x.ddu))
        return Results({"tau": tau, "M": dynamics.mass_matrix()}, dynamics.checks)

    program = with_loads(AT_ACCELERATION, run, pattern)
    model = machine._model.program_model

    def traced(*vectors: Sequence[float]) -> Results:
        return run(model, Inputs(**dict(zip(program.inputs, vectors, strict=True))))

    sizes = [program.size(model, name) for name in program.inputs]
    return Kernel(traced, sizes, backend="python"), program.inputs


def require_equal(machine: Robot, states: Sequence[ClosedState], loads: Loads) -> None:
    pattern, values = machine._dynamics.pack(loads.with_gravity(GRAVITY))
    plain, names = kernel(machine, pattern, minimal=False)
    regrouped, _ = kernel(machine, pattern, minimal=True)
    for k, state in enumerate(states):
        inputs = {"u": state.u, "du": state.du, "ddu": random_vector(machine, k)}
        inputs |= {"branch": state.signs, "guess": state.s, "gravity": GRAVITY, **values}
        arguments = [np.array(inputs[name], dtype=float) for name in names]
        expected, _ = plain(*arguments)
        actual, _ = regrouped(*arguments)
        for name in ("tau", "M"):
            size = np.abs(expected[name]).max(initial=1e-3)
            np.testing.assert_allclose(actual[name], expected[name], atol=ROUNDING * size, rtol=0.0)


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_shipped_robots_and_mechanisms(name: str) -> None:
    machine = robot(name)
    for loads in (machine.loads, heavy_loads(machine)):
        require_equal(machine, random_states(name, 3), loads)


EQUAL_BARS = """\
format: 1
name: equal_bars
base: base
links:
  base: {}
  crank: {mass: 2, com: [0.1, 0.02, 0], inertia: {xx: 0.01, yy: 0.02, zz: 0.03}}
  coupler: {mass: 3, com: [0.2, -0.05, 0], inertia: {xx: 0.02, yy: 0.05, zz: 0.06}}
  rocker: {mass: 1, com: [0.15, 0.01, 0], inertia: {xx: 0.01, yy: 0.01, zz: 0.02}}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z}
  b: {type: revolute, parent: crank, child: coupler, origin: {xyz: [0.3, 0, 0]}, axis: z}
  c: {type: revolute, parent: base, child: rocker, origin: {xyz: [0.5, 0, 0]}, axis: z}
closures:
  pin: {kind: planar, between: {coupler: [0.5, 0, 0], rocker: [0.3, 0, 0]}}
active: [a]
end_effector: {link: coupler}
reference: {a: 1.0, b: -1.0, c: 1.0}
"""


def test_bars_that_are_parallel_on_one_mode_only() -> None:
    """A parallelogram of equal bars, and the same bars crossed."""
    machine = Robot(parse_description(EQUAL_BARS, "equal_bars.yaml"))
    modes = machine.assembly_modes([0.8])
    assert len(modes) == 2
    require_equal(
        machine, [machine.close([0.7], [2.0], near=m.state) for m in modes], machine.loads
    )


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_every_assembly_mode(name: str) -> None:
    """Links that are parallel on one mode need not be so on another one."""
    machine = robot(name)
    states = []
    for mode in machine.assembly_modes(machine.reference):
        state = machine.close(machine.reference, random_vector(machine, 9), near=mode.state)
        states.append(state)
    require_equal(machine, states[:8], machine.loads)


@examples(12)
@given(robots(), STATES)
def test_random_robots_in_random_frames(case: Case, seed: int) -> None:
    state = case.robot.close(case.somewhere(seed)[: case.n], case.rates(seed))
    require_equal(case.robot, [state], case.robot.loads)
    machine = Robot(reframed(case.description, seed))
    require_equal(machine, [machine.close(state.u, state.du)], machine.loads)


def test_a_base_far_away() -> None:
    """Masses that go to the base leave nothing of its place."""
    machine = Robot(far_away(robot("excavator").description, 3, 5e5))
    state = machine.close(machine.reference, np.full(len(machine.active), 0.3))
    size = max(
        np.abs(body.about_origin).max() for body in machine._model.program_model.regrouped.bodies
    )
    assert size < 1e5  # [kg m^2]
    require_equal(robot("excavator"), random_states("excavator", 2), machine.loads)
    near = robot("excavator")
    efforts = near.inverse_dynamics(near.close(state.u, state.du), np.ones(state.n))
    np.testing.assert_allclose(
        machine.inverse_dynamics(state, np.ones(state.n)), efforts, rtol=1e-5
    )


@pytest.mark.parametrize(
    ("name", "parameters", "operations"),
    [("forging_chu2020", 19, 415), ("palletizer", 17, 85), ("excavator", 34, 965)],
)
def test_few_numbers_are_left(name: str, parameters: int, operations: int) -> None:
    """Whole bars vanish between their pins, and links of parallelograms need no axes."""
    model = robot(name)._model.program_model
    numbers = 0
    for body in model.regrouped.bodies:
        second = np.array(body.about_origin)[np.triu_indices(3)]
        numbers += np.count_nonzero([body.mass, *body.first_moment, *second])
    pattern, _ = robot(name)._dynamics.pack(robot(name).loads)
    trace = inverse_dynamics(pattern).kernel(model, "inverse dynamics").trace
    arithmetic = [trace.graph.nodes[i][0] for i in trace.live]
    count = sum(arithmetic.count(kind) for kind in ("add", "sub", "mul", "div", "neg"))
    assert (numbers <= parameters, count <= operations) == (True, True), (numbers, count)
