"""Optional inputs of closure, kinematics and dynamics."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from hybrid_dynamics_core import ClosedState, ClosureStatus, Loads, Robot
from hybrid_dynamics_core.closed_state.assembly_modes import AssemblyMode
from hybrid_dynamics_core.dynamics.parameters import Parameters
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.ground.arrays import frozen
from tests.laws.test_loads import TOOL, with_payload_in_its_link
from tests.laws.test_multi_dof import random_pose
from tests.mechanisms import changed, mechanism
from tests.robots import random_states, random_vector, robot

from .ask import Ask, law, near

GRAVITY = (1.0, -2.0, -9.0)
BALL = "hip"
TURNTABLE = "slider_crank"  # a loop whose plane turns, so that no axis is along the base's


def moving() -> tuple[Robot, ClosedState]:
    return robot(TURNTABLE), random_states(TURNTABLE)[0]


def heavy(machine: Robot) -> tuple[Loads, Robot]:
    """A payload and another gravity as loads, and as numbers of the description."""
    loads = machine.loads.with_payload(TOOL).with_gravity(GRAVITY)
    return loads, changed(with_payload_in_its_link(machine), gravity=frozen(GRAVITY))


ON_STATES = ("minimal_form", "coriolis_matrix", "energy", "centroidal")
WITH_DDU = ("inverse_dynamics", "inverse_dynamics_derivatives", "reactions", "spanning_terms")
WITH_TAU = ("forward_dynamics", "forward_dynamics_derivatives")


@law(*(f"{name}.loads" for name in (*ON_STATES, *WITH_DDU, *WITH_TAU, "motion_near")))
def loads_are_as_in_the_description(ask: Ask) -> None:
    machine, state = moving()
    loads, other = heavy(machine)
    there = other.close(state.u, state.du)
    vector = random_vector(machine, 1)
    for name in (*ON_STATES, *WITH_DDU, *WITH_TAU):
        arguments = () if name in ON_STATES else (vector,)
        answer = ask(machine, name, state, *arguments, loads=loads)
        assert near(answer, getattr(other, name)(there, *arguments)), name
    point = (state.u, state.du, vector)
    motion = ask(machine, "motion_near", state, of=lambda run: run(*point), loads=loads)
    assert near(motion(*point), other.motion_near(there)(*point))


@law("passive_forces.loads")
def a_wrench_works_along_the_rates(ask: Ask) -> None:
    machine, state = moving()
    wrench = np.array([3.0, -2.0, 5.0, 0.4, -0.3, 0.2])
    bare = machine.passive_forces(state)
    tau = ask(machine, "passive_forces", state, loads=machine.loads.with_wrench(wrench))
    assert near(tau - bare, -machine.jacobian(state).T @ wrench)


@law("regressor.parameters", "regressor.loads")
def columns_of_the_regressor(ask: Ask) -> None:
    """Y times the values are the efforts, those of friction among them, in another gravity."""
    machine, state = moving()
    ddu = random_vector(machine, 2)
    joints = machine.coordinates
    some = Parameters(tuple(machine.description.links), viscous=joints)
    viscous = np.arange(1.0, len(joints) + 1.0)
    loads = machine.loads.with_gravity(GRAVITY).with_effects(viscous=viscous)
    matrix = ask(machine, "regressor", state, ddu, parameters=some, loads=loads)
    values = some.values(machine.description, loads.effects)
    assert near(matrix @ values, machine.inverse_dynamics(state, ddu, loads))


@law("reactions.ddu")
def the_foundation_accelerates_the_centre_of_mass(ask: Ask) -> None:
    machine, state = moving()
    ddu = random_vector(machine, 3)
    force = ask(machine, "reactions", state, ddu=ddu).base[:3]
    centre = machine.centroidal(state)
    change = centre.mass * centre.com_jacobian @ ddu
    assert near(force - machine.reactions(state).base[:3], change)


@law("spanning_terms.ddu")
def multipliers_balance_the_tree(ask: Ask) -> None:
    """The DAE of Chu (2020), Eq. 10, at the passive coordinates, where nothing drives."""
    machine, state = moving()
    ddu = random_vector(machine, 4)
    terms = ask(machine, "spanning_terms", state, ddu=ddu)
    forces = terms.M @ machine.accelerations(state, ddu) + terms.C @ state.ds + terms.g
    forces = forces + terms.extra + terms.J.T @ terms.multipliers
    driven = [name in machine.active for name in machine.coordinates]
    assert near(forces[driven], machine.inverse_dynamics(state, ddu))
    assert near(forces[~np.array(driven)], np.zeros(driven.count(False)))


@law("close.du", "jacobian.frame", "forward_kinematics.frame")
def frames_move_as_their_jacobians_say(ask: Ask) -> None:
    machine, state = moving()
    frame, step = machine.frames[-1], 1e-6  # its square is the error
    state = ask(machine, "close", state.u, du=state.du)
    jacobian = ask(machine, "jacobian", state, frame=frame)
    ends = [machine.close(state.u + side * step * state.du) for side in (-1.0, 1.0)]
    first, last = (ask(machine, "forward_kinematics", end, frame=frame) for end in ends)
    velocity = (last.position - first.position) / (2.0 * step)
    spin = (last.rotation - first.rotation) @ first.rotation.T / (2.0 * step)
    turning = [spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]
    assert near(jacobian @ state.du, [*velocity, *(0.5 * np.array(turning))], 1e-7)
    assert near(state.ds, (ends[1].s - ends[0].s) / (2.0 * step), 1e-7)


@law("close.check", "close.branch", "close.near")
def modes_are_kept_and_named(ask: Ask) -> None:
    machine = mechanism("two_cranks")
    u, ahead = machine.reference, machine.reference + 0.01
    mode = other_mode(machine)
    state = ask(machine, "close", u, branch=mode.branch)
    assert near(state.s, mode.state.s)
    followed = ask(machine, "close", ahead, of=lambda one: one.s, near=state)
    assert near(followed.s, machine.close(ahead, branch=mode.branch).s)
    far = ask(machine, "close", [np.pi, 0.0], of=lambda one: one.status, check=False)
    assert far.status is ClosureStatus.UNREACHABLE
    assert np.isnan(far.s).any()


def other_mode(machine: Robot) -> AssemblyMode:
    """One that is not the robot's own."""
    own = machine.close(machine.reference).branch
    return next(one for one in machine.assembly_modes(machine.reference) if one.branch != own)


@law("close_path.du", "close_path.near")
def a_path_is_closed_state_by_state(ask: Ask) -> None:
    machine = mechanism("two_cranks")
    u = machine.reference + np.linspace(0.0, 0.2, 5)[:, None]
    mode = other_mode(machine)
    rates = np.tile([0.3, -0.2], (5, 1))
    path = ask(machine, "close_path", u, du=rates, near=mode.state)
    alone = machine.close(u, rates, branch=mode.branch)
    assert near(path.s, alone.s)
    assert near(path.ds, alone.ds)


@law("close_path.through_change_points")
def a_parallelogram_passes_its_fold(ask: Ask) -> None:
    """Unnamed, it turns on as a parallelogram: the rocker as the crank."""
    machine = four_bar(0.1, 0.3, 0.1)
    u = np.zeros((2, 4))
    u[:, 0] = 0.5, -0.5
    path = ask(machine, "close_path", u, of=lambda one: one.s, through_change_points=True)
    places = [machine.coordinates.index(name) for name in "abc"]
    assert near(path.s[-1][places], [-0.5, 0.5, -0.5])


def four_bar(crank: float, coupler: float, rocker: float) -> Robot:
    """Bars [m] on a ground of 0.3 m, and an arm on a ball joint."""
    turning = {"type": "revolute", "axis": "z"}
    ends = {"coupler": [coupler, 0, 0], "rocker": [rocker, 0, 0]}
    text = {
        "format": 1,
        "name": "bars",
        "links": {"crank": {}, "coupler": {}, "rocker": {}, "arm": {}},
        "joints": {
            "a": {**turning, "parent": "base", "child": "crank"},
            "b": {
                **turning,
                "parent": "crank",
                "child": "coupler",
                "origin": {"xyz": [crank, 0, 0]},
            },
            "c": {**turning, "parent": "base", "child": "rocker", "origin": {"xyz": [0.3, 0, 0]}},
            BALL: {"type": "ball", "parent": "base", "child": "arm"},
        },
        "closures": {"pin": {"kind": "planar", "between": ends}},
        "active": ["a", BALL],
        "end_effector": {"link": "coupler"},
        "reference": {"a": 1.0, "b": -1.0, "c": 1.0},
    }
    return Robot(parse_description(yaml.safe_dump(text)))


@law("close_given.rates", "close_given.accelerations", "close_given.near")
def given_coordinates_are_those_of_the_motion(ask: Ask) -> None:
    machine, state = moving()
    ddu = random_vector(machine, 5)
    dds = machine.accelerations(state, ddu)
    names = machine.coordinates[0], machine.coordinates[-1]
    places = [machine.coordinates.index(name) for name in names]
    values, rates, pushes = (
        dict(zip(names, vector[places], strict=True)) for vector in (state.s, state.ds, dds)
    )
    back = ask(machine, "close_given", values, rates=rates, accelerations=pushes)
    assert near([back.u, back.du, back.dds], [state.u, state.du, dds])
    cranks = mechanism("two_cranks")
    mode = other_mode(cranks)
    named = dict(zip(cranks.coordinates, mode.state.s, strict=True))
    pair = {name: named[name] + 0.01 for name in ("a", "b")}
    moved = ask(cranks, "close_given", pair, of=lambda one: one.s, near=mode.state)
    assert near(moved.s, cranks.close(moved.u, branch=mode.branch).s)
    assert near([moved.s[cranks.coordinates.index(name)] for name in pair], pair)


@law("close_at_poses.twists", "close_at_poses.u", "close_at_poses.du", "close_at_poses.near")
def joints_are_at_their_poses(ask: Ask) -> None:
    machine = four_bar(0.1, 0.25, 0.2)
    rng = np.random.default_rng(6)
    pose, twist = random_pose(rng), rng.normal(size=3)
    u, du = [0.7, 0.0, 0.0, 0.0], [-0.4, 0.0, 0.0, 0.0]
    given: dict[str, Any] = {
        "twists": {BALL: twist},
        "u": u,
        "du": du,
        "near": other_mode(machine).state,
    }
    state = ask(machine, "close_at_poses", {BALL: pose}, **given)
    assert near(machine.joint_pose(state, BALL).rotation, pose.rotation)
    assert near(machine.joint_twist(state, BALL), twist)
    assert near([state.u[0], state.du[0]], [0.7, -0.4])
    assert near(state.s, machine.close(state.u, branch=state.branch).s)


@law("recentred.leave")
def another_chart_shows_the_same_pose(ask: Ask) -> None:
    machine = four_bar(0.1, 0.25, 0.2)
    rng = np.random.default_rng(7)
    state = machine.close_at_poses({BALL: random_pose(rng)}, {BALL: rng.normal(size=3)})
    other = ask(machine, "recentred", state, leave=0.0)
    assert near(machine.joint_pose(other, BALL).rotation, machine.joint_pose(state, BALL).rotation)
    assert near(machine.joint_twist(other, BALL), machine.joint_twist(state, BALL))
