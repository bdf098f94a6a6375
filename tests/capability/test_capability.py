"""Capability: against linear programs, by hand, and at the limits themselves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from hybrid_dynamics_core import InputError, Payload, load
from hybrid_dynamics_core.capability.box_image import UnlimitedError, solutions
from hybrid_dynamics_core.capability.polytope import hull
from hybrid_dynamics_core.identification import random_motion
from tests.sampling import examples, swept

ROBOTS = ("excavator", "ankle", "forging_chu2020", "palletizer", "five_bar", "delta", "gough")
PLANE = {"ankle": ("rx", "ry"), "five_bar": ("x", "y"), "excavator": ("x", "z")}
SAME = 1e-9  # of the largest value, as linear programs give it


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


def limited(robot, state, rng):
    """Capability of a robot all of whose drives have limits that hold it."""
    held = robot.inverse_dynamics(state, np.zeros(len(robot.active)))
    scale = np.abs(held).max() + 10.0
    efforts = {name: scale * rng.uniform(1.5, 4.0) for name in robot.all_drives}
    rates = {name: rng.uniform(0.1, 1.0) for name in robot.active}
    return robot.capability(state, efforts=efforts, rates=rates)


def largest(objective, A, K, r, bounds):
    """Largest objective @ y with A x = r + K y, by a linear program."""
    m, k = A.shape[1], K.shape[1]
    size = np.array([high for _, high in bounds])
    rows = np.abs(A * size).max(axis=1)
    matrix = np.hstack([A * size, -K]) / rows[:, None]
    scaled = [(low / high, 1.0) for low, high in bounds] + [(None, None)] * k
    cost = np.concatenate([np.zeros(m), -objective])
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    result = linprog(cost, A_eq=matrix, b_eq=r / rows, bounds=scaled, options=options)
    assert result.status == 0, result.message
    return -result.fun


def check_forces(robot, state, capability, rng, axes):
    rows = ["x", "y", "z", "rx", "ry", "rz"]
    jacobian = robot.jacobian(state)[[rows.index(name) for name in axes]]
    A = robot.drive_rates(state).T
    needed = robot.inverse_dynamics(state, np.zeros(len(robot.active)))
    bounds = [capability.limits[name] for name in capability.drives]
    polytope = capability.forces(axes)
    corners = polytope.normals @ polytope.vertices.T
    size = np.abs(polytope.vertices).max()
    assert corners.max(axis=1) == pytest.approx(polytope.offsets, abs=SAME * size)
    for _ in range(2):
        direction = rng.normal(size=len(axes))
        program = largest(direction, A, jacobian.T, needed, bounds)
        assert polytope.support(direction) == pytest.approx(program, abs=SAME * size)
        if set(axes) <= set("xyz"):
            along = np.zeros(3)
            along[["xyz".index(name) for name in axes]] = direction
            unit = along / np.linalg.norm(along)
            force = capability.largest_force(along)
            K = (robot.jacobian(state)[:3].T @ unit)[:, None]
            program = largest(np.ones(1), A, K, needed, bounds)
            assert force.value == pytest.approx(program, abs=SAME * size)
            assert force.limited_by
            inside = np.array([unit["xyz".index(name)] for name in axes]) * force.value
            assert polytope.contains(inside, 1e-6 * size)
            assert not polytope.contains(1.001 * inside, 0.0)


def check_motion(robot, state, capability, rng, axes):
    rows = ["x", "y", "z", "rx", "ry", "rz"]
    jacobian = robot.jacobian(state)[[rows.index(name) for name in axes]]
    direction = rng.normal(size=len(axes))
    A = robot.drive_rates(state).T
    M, _, _ = robot.minimal_form(state)
    needed = robot.inverse_dynamics(state, np.zeros(len(robot.active)))
    bounds = [capability.limits[name] for name in capability.drives]
    polytope = capability.accelerations(axes)
    program = largest(jacobian.T @ direction, A, M, needed, bounds)
    size = np.abs(polytope.vertices).max() * np.linalg.norm(direction)
    assert polytope.support(direction) == pytest.approx(program, abs=10 * SAME * size)
    speeds = capability.speeds(axes)
    expected = np.abs(jacobian.T @ direction) @ [capability.rates[n] for n in robot.active]
    assert speeds.support(direction) == pytest.approx(expected, rel=SAME)


def check_at(name, count, seed):
    robot = load(name)
    rng = np.random.default_rng(seed)
    state, _ = random_motion(robot, count, seed, 0.0, 0.0)
    axes = PLANE.get(name, ("x", "y", "z"))
    for k in range(count):
        one = robot.close(state.u[k])
        capability = limited(robot, one, rng)
        check_forces(robot, one, capability, rng, axes)
        check_motion(robot, one, capability, rng, axes)


@pytest.mark.parametrize("name", swept(ROBOTS, ("excavator", "ankle", "delta")))
def test_polytopes_and_largest_forces_are_those_of_linear_programs(name):
    check_at(name, 3, 5)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name,
            marks=pytest.mark.sweep(
                sample="test_polytopes_and_largest_forces_are_those_of_linear_programs"
            ),
        )
        for name in ("excavator", "ankle", "delta", "palletizer")
    ],
)
def test_a_thousand_states_are_those_of_linear_programs(name):
    check_at(name, 250, 6)


LIFT = """
format: 1
name: lift
links: {base: {}, table: {mass: 200}}
joints: {z: {type: prismatic, parent: base, child: table, origin: {rpy: [0, -pi/2, 0]}, axis: x,
  limits: [0, 2]}}
actuators: {z: {kind: hydraulic_cylinder, bore: 0.1, rod: 0.06, stroke: [0, 2],
  supply_pressure: 15e6, return_pressure: 1e6}}
active: [z]
end_effector: {link: table, xyz: [0, 0, 0]}
"""


def test_one_cylinder_by_hand(tmp_path):
    path = tmp_path / "lift.yaml"
    path.write_text(LIFT, encoding="utf-8")
    lift = load(path)
    up = lift.capability(lift.close([1.0]))
    g = float(np.linalg.norm(lift.loads.gravity))
    cap, rod = np.pi / 4 * 0.1**2, np.pi / 4 * (0.1**2 - 0.06**2)
    push, pull = 15e6 * cap - 1e6 * rod, 15e6 * rod - 1e6 * cap
    assert up.largest_force([0, 0, 1]).value == pytest.approx(push - 200 * g, rel=1e-12)
    assert up.largest_force([0, 0, -1]).value == pytest.approx(pull + 200 * g, rel=1e-12)
    assert up.lifted_mass().value == pytest.approx(push / g - 200, rel=1e-12)
    assert up.lifted_mass().limited_by == ("z",)
    assert up.accelerations("z").vertices.ravel() == pytest.approx(
        [-(pull + 200 * g) / 200, (push - 200 * g) / 200], rel=1e-12
    )
    assert up.breakout("z").value == pytest.approx(push - 200 * g, rel=1e-12)
    assert up.breakout("z", retracting=True).value == pytest.approx(pull + 200 * g, rel=1e-12)
    assert up.largest_force([1, 0, 0]).value == np.inf


def test_a_lifted_mass_is_at_the_limit_of_the_drive_that_is_named(excavator):
    state = excavator.close([0.3, 0.5, 0.9, 0.6])
    com = [-0.5, 0.3, 0.0]
    lifted = excavator.capability(state).lifted_mass(com)
    loads = excavator.loads.with_payload(Payload(lifted.value, com))
    held = excavator.inverse_dynamics(state, np.zeros(4), loads)
    k = excavator.active.index(lifted.limited_by[0])
    ends = excavator.effort_ranges[lifted.limited_by[0]]
    assert np.abs(np.array(ends) - held[k]).min() < 1e-6 * abs(held[k])
    assert held == pytest.approx(list(lifted.efforts.values()), rel=1e-9, abs=1e-3)


@examples(40)
@given(seed=st.integers(0, 100_000), n=st.integers(1, 3), more=st.integers(0, 2))
def test_any_drives_are_those_of_linear_programs(seed, n, more):
    """More drives than freedoms, and directions of any number."""
    rng = np.random.default_rng(seed)
    k = int(rng.integers(1, n + 1))
    m = n + more
    A = rng.normal(size=(n, m)) * 10.0 ** rng.uniform(-2, 2)
    K = rng.normal(size=(n, k))
    upper = rng.uniform(1.0, 50.0, m)
    lower = -rng.uniform(1.0, 50.0, m)
    r = A @ (0.5 * rng.uniform(lower, upper))
    points, forces = solutions(A, K, r, lower, upper).vertices()
    assert pytest.approx((r + points @ K.T).T, abs=1e-9 * np.abs(A).max() * 100) == A @ forces.T
    polytope = hull(points, ("x", "y", "z")[:k], [()] * len(points))
    size = np.abs(polytope.vertices).max()
    for _ in range(3):
        direction = rng.normal(size=k)
        bounds = list(zip(lower, upper, strict=True))
        program = largest(direction, A, K, r, bounds)
        support = polytope.support(direction)
        assert support == pytest.approx(program, abs=1e-8 * size * np.linalg.norm(direction))


def test_what_has_no_limit_is_named(excavator):
    state = excavator.close([0.0, 0.5, 0.9, 0.6])
    capability = excavator.capability(state)
    with pytest.raises(UnlimitedError, match="slew has no limit"):
        capability.forces(("x", "y", "z"))
    with pytest.raises(UnlimitedError, match="along x, z"):
        capability.speeds(("x", "z"))
    with pytest.raises(InputError, match="no axis 'up'"):
        capability.forces(("up",))
    with pytest.raises(InputError, match="no drive 'boom'"):
        excavator.capability(state, efforts={"boom": 1.0})
    with pytest.raises(InputError, match="not all zero"):
        capability.largest_force([0.0, 0.0, 0.0])
    moving = excavator.capability(excavator.close([0.0, 0.5, 0.9, 0.6], [0.1, 0.0, 0.0, 0.0]))
    with pytest.raises(InputError, match="without rates"):
        moving.accelerations(("x", "z"))
    weak = excavator.capability(state, efforts={"boom_cylinder": 10.0})
    assert weak.largest_force([0, 0, 1]).value < 0.0  # the ground has to hold it
    idle = excavator.capability(state, efforts=dict.fromkeys(excavator.all_drives, 0.0))
    assert idle.largest_force([0, 0, 1]).value == -np.inf
    assert idle.forces(("x", "z")).is_empty
