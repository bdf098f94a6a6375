"""Optional inputs of limits, capability, stiffness, inverse kinematics, workspaces and proofs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from hybrid_dynamics_core import ClosedState, IKStatus, Payload, Robot, load
from hybrid_dynamics_core.certified.boxes.cells import CellKind
from hybrid_dynamics_core.stiffness import Elasticity
from tests.laws.test_loads import TOOL, with_payload_in_its_link
from tests.laws.test_redundant_drives import four_bar as two_motors
from tests.limits.machines import crane
from tests.limits.test_retime import cart
from tests.mechanisms import changed, mechanism
from tests.robots import random_states, random_vector, robot

from .ask import ROUNDING, Ask, law, near
from .of_motion import moving, other_mode

AT = [0.3, 0.2]  # of the crane [m]
ALONG = np.array([0.6, 0.0, -0.8])  # in its plane
OFF_PLANE = np.array([0.0, 0.1, 0.0])  # of the cranks [m]
SEARCH = 1e-6  # of what a search finds
PLANE = [True, False, True, False, False, False]


def lifting() -> tuple[Robot, ClosedState]:
    """The crane, which moves."""
    machine = crane()
    return machine, machine.close(AT, [0.02, -0.03])


def most(machine: Robot, state: ClosedState, efforts: Mapping[str, float], frame: str) -> float:
    """The largest force along ALONG: all efforts stay within limits; one drive for each freedom."""
    held = machine.inverse_dynamics(state, np.zeros(2))
    per_newton = machine.jacobian(state, frame)[:3].T @ ALONG
    moving = per_newton != 0.0
    bounds = np.array([efforts[name] for name in machine.active])
    room = bounds - np.sign(per_newton) * held
    return float((room[moving] / np.abs(per_newton[moving])).min())


@law("capability.efforts", "capability.frame", "capability.rates", "capability.loads")
def limits_and_loads_decide_what_a_crane_can(ask: Ask) -> None:
    machine, state = lifting()
    efforts = {"lift_cylinder": 3e4, "boom_cylinder": 4e4}
    rates = {"lift_cylinder": 0.05, "boom_cylinder": 0.03}
    frame = "boom"

    def force(able: Any) -> float:
        return float(able.largest_force(ALONG).value)

    able = ask(machine, "capability", state, of=force, efforts=efforts, frame=frame)
    assert near(force(able), most(machine, state, efforts, frame))
    quick = ask(machine, "capability", state, of=speed, rates=rates)
    jacobian = machine.jacobian(state)[:3].T @ ALONG
    assert near(speed(quick), np.abs(jacobian) @ [rates[name] for name in machine.active])
    loads = machine.loads.with_payload(TOOL)
    loaded = ask(machine, "capability", state, of=force, loads=loads)
    other = with_payload_in_its_link(machine)
    assert near(force(loaded), force(other.capability(other.close(state.u, state.du))))


def duration(motion: Any) -> float:
    return float(motion.duration)


def speed(able: Any) -> float:
    """The largest speed of the end effector along ALONG."""
    flat = ALONG[[0, 2]]
    return float(able.speeds(("x", "z")).support(flat))


@law("limit_margins.ddu", "limit_margins.tau", "limit_margins.loads")
def margins_are_those_of_the_efforts(ask: Ask) -> None:
    machine, state = lifting()
    ddu = random_vector(machine, 8)
    loads = machine.loads.with_payload(TOOL)
    pushed = ask(machine, "limit_margins", state, ddu=ddu, loads=loads)
    tau = machine.inverse_dynamics(state, ddu, loads)
    told = ask(machine, "limit_margins", state, tau=tau)
    other = with_payload_in_its_link(machine)
    assert near(pushed.values, told.values)
    assert near(pushed.values, other.limit_margins(other.close(state.u, state.du), ddu).values)
    for name, cylinder in machine.hydraulics(state, tau).items():
        kinds = [(row.name, row.kind) for row in told.rows]
        value = told.values[kinds.index((name, "pressure"))]
        assert near(value, max(cylinder.cap_pressure, cylinder.rod_pressure))


PATH = [[0.1, 0.1], [0.3, 0.4]]


@law("retime.loads", "retime.share", "retime.stations")
def heavier_and_gentler_motions_are_slower(ask: Ask) -> None:
    machine = crane()
    loads = machine.loads.with_payload(TOOL)

    given = {"loads": loads, "share": 0.6, "stations": 60}
    motion = ask(machine, "retime", PATH, of=duration, **given)
    other = with_payload_in_its_link(machine)
    assert near(motion.times, other.retime(PATH, stations=60, share=0.6).times, SEARCH)
    assert len(motion.s) == 61
    u, du, ddu = motion(np.linspace(0.0, motion.duration, 301))
    margins = other.limit_margins(other.close(u, du), ddu)
    limited = [row.kind != "position" for row in margins.rows]
    assert margins.shares[:, limited].min() > 0.4 - 1e-3


@law("retime.near")
def a_motion_stays_on_its_mode(ask: Ask) -> None:
    machine = limited_cranks()
    mode = other_mode(machine)
    path = machine.reference + np.array([[0.0, 0.0], [0.2, -0.1]])
    motion = ask(machine, "retime", path, of=duration, near=mode.state, stations=40)
    u, du, ddu = motion(np.linspace(0.0, motion.duration, 200))
    tau = machine.inverse_dynamics(machine.close(u, du, branch=mode.branch), ddu)
    assert 0.98 * LIMIT < np.abs(tau).max() < LIMIT * (1.0 + 1e-3)


LIMIT = 60.0  # [N m]


def limited_cranks() -> Robot:
    """Two cranks whose motors are limited."""
    machine = mechanism("two_cranks")
    joints = dict(machine.description.joints)
    for name in machine.active:
        joints[name] = replace(joints[name], effort_limit=LIMIT)
    return changed(machine, joints=MappingProxyType(joints))


@law("point_to_point.loads", "point_to_point.share")
def a_heavier_cart_is_slower(ask: Ask) -> None:
    """By hand, where the jerk alone and the force alone would allow more."""
    machine = cart("effort_limit: 6")
    loads = machine.loads.with_payload(TOOL)
    given = {"loads": loads, "share": 0.6}
    motion = ask(machine, "point_to_point", [0.0], [1.5], 1e3, of=duration, **given)
    push = 0.6 * 6.0 / (2.0 + TOOL.mass)
    assert near(motion.duration, 2.0 * np.sqrt(1.5 / push), 1e-2)
    _, _, ddu = motion(np.linspace(0.0, motion.duration, 999))
    assert 0.99 * push < np.abs(ddu).max() < push


@law("distribute.preload", "distribute.weights")
def forces_are_nearest_to_the_preload(ask: Ask) -> None:
    """By Lagrange's multiplier; far from limits."""
    machine = two_motors()
    state = machine.close(machine.reference)
    rates = state.R[[machine.coordinates.index(name) for name in ("a", "b")], 0]
    tau, preload, weights = 5.0, np.array([1.0, -2.0]), np.array([1.0, 3.0])
    named = {"preload": dict(zip("ab", preload, strict=True)), "weights": {"a": 1.0, "b": 3.0}}
    shared = ask(machine, "distribute", state, [tau], of=lambda one: one.forces, **named)
    missing = tau - rates @ preload
    expected = preload + weights**2 * rates * missing / (weights**2 @ rates**2)
    assert near([shared.forces["a"], shared.forces["b"]], expected)


@law("stiffness.elasticity", "stiffness.frame")
def drives_yield_as_their_frame_moves(ask: Ask) -> None:
    """Compliance J K^-1 J^T of drives alone."""
    machine, state = moving()
    springs = {name: 1e5 * (k + 1.0) for k, name in enumerate(machine.active)}
    frame = machine.frames[0] if machine.frames[0] != "end_effector" else machine.frames[1]
    given = {"elasticity": Elasticity(springs), "frame": frame}
    standing = machine.close(state.u)
    elastic = ask(machine, "stiffness", standing, of=lambda one: one.compliance, **given)
    jacobian = machine.jacobian(standing, frame)
    expected = jacobian / np.array(list(springs.values())) @ jacobian.T
    assert near(elastic.compliance / np.abs(expected).max(), expected / np.abs(expected).max())


@law("inverse_kinematics.seed", "inverse_kinematics.near", "inverse_kinematics.mask")
def searches_begin_and_stay_where_told(ask: Ask) -> None:
    machine = mechanism("two_cranks")
    mode = other_mode(machine)
    goal = machine.close(machine.reference + np.array([0.1, -0.05]), branch=mode.branch)
    place = machine.forward_kinematics(goal).position
    given = {"near": mode.state, "mask": PLANE}
    found = ask(machine, "inverse_kinematics", place + OFF_PLANE, of=lambda one: one.u, **given)
    assert found.status is IKStatus.SOLVED
    reached = machine.forward_kinematics(machine.close(found.u, branch=mode.branch)).position
    assert near(reached[[0, 2]], place[[0, 2]], SEARCH)
    arm, state = robot("serial"), random_states("serial")[0]
    target = arm.forward_kinematics(state).position
    seed = state.u + 0.3
    nearby = ask(arm, "inverse_kinematics", target, of=lambda one: one.u, seed=seed)
    assert near(arm.forward_kinematics(arm.close(nearby.u)).position, target, SEARCH)
    usual = arm.inverse_kinematics(target).u
    assert np.linalg.norm(nearby.u - seed) < np.linalg.norm(usual - seed)


@law("inverse_kinematics.all_solutions", "inverse_kinematics.tolerance")
def all_answers_reach_the_target(ask: Ask) -> None:
    machine = mechanism("two_cranks")
    target = machine.forward_kinematics(machine.close(machine.reference + 0.1)).position
    found = ask(
        machine, "inverse_kinematics", target, of=lambda one: len(one.solutions), all_solutions=True
    )
    assert len(found.solutions) > 1
    for u in found.solutions:
        assert near(machine.forward_kinematics(machine.close(u)).position, target, SEARCH)
    far = target + 1e-3 * OFF_PLANE
    loose = ask(machine, "inverse_kinematics", far, of=lambda one: one.status, tolerance=1e-3)
    assert loose.status is IKStatus.SOLVED
    assert 0.9e-4 < loose.residual < 1e-3


@law("workspace.count", "workspace.frame", "workspace.ranges", "workspace.held")
def samples_are_poses_within_their_ranges(ask: Ask) -> None:
    machine = robot("serial")
    given = {"ranges": {"a": (0.1, 0.4)}, "held": {"c": 0.15}, "frame": "l2", "count": 200}
    found = ask(machine, "workspace", of=lambda one: one.samples, **given)
    samples = found.samples
    assert found.count == 200
    assert ((samples.u[:, 0] >= 0.1) & (samples.u[:, 0] <= 0.4)).all()
    assert (samples.u[:, 2] == 0.15).all()
    assert near(
        samples.position, machine.forward_kinematics(machine.close(samples.u), "l2").position
    )


@law("certify.ddu", "certify.radius")
def proofs_hold_all_of_a_box(ask: Ask) -> None:
    machine = load("five_bar")
    ddu = random_vector(machine, 9)
    radius = 1e-4
    state = machine.close(machine.reference)
    proof = ask(machine, "certify", state, ddu=ddu, radius=radius)
    assert proof
    corners = machine.reference + radius * np.array([[1, 1, -1], [-1, 1, 1], [0, 0, 0]])
    for u in corners:
        there = machine.close(u)
        tau = machine.inverse_dynamics(there, ddu)
        assert ((proof.s_lower <= there.s) & (there.s <= proof.s_upper)).all()
        assert ((proof.tau_lower <= tau) & (tau <= proof.tau_upper)).all()


@law("certify_cells.ranges", "certify_cells.depth", "certify_cells.frame")
def cells_hold_the_places_of_a_frame(ask: Ask) -> None:
    machine = load("five_bar")
    middle = machine.reference
    ranges = {n: (middle[k] - 0.3, middle[k] + 0.3) for k, n in enumerate(machine.active[:2])}
    given = {"ranges": ranges, "depth": 5, "frame": "bar_L"}
    cells = ask(machine, "certify_cells", of=lambda one: (one.lower, one.position_lower), **given)
    assert len(cells.kind) <= 2**5
    assert near((cells.lower.min(axis=0) + cells.upper.max(axis=0)) / 2.0, middle)
    closed = cells.kind == CellKind.CLOSED
    assert closed.any()
    rows = cells.lower + cells.upper, cells.position_lower, cells.position_upper
    for twice, low, high in zip(*(row[closed] for row in rows), strict=True):
        state = machine.close(0.5 * twice)
        place = machine.forward_kinematics(state, "bar_L").position
        assert ((low - ROUNDING <= place) & (place <= high + ROUNDING)).all()


def mass_of_tool(machine: Robot) -> float:
    return machine.description.links["tool"].mass


@law("with_parameters.values", "free.given")
def numbers_by_path_and_other_coordinates(ask: Ask) -> None:
    machine, more = load("five_bar"), 1.3
    state = machine.close(machine.reference + np.array([0.1, -0.2, 0.3]))
    ddu = random_vector(machine, 10)
    values = {"links.tool.mass": 0.2 + more}
    other = ask(machine, "with_parameters", of=mass_of_tool, values=values)
    side = more * (3.0 * 0.015**2 + 0.06**2) / 12.0
    inertia = np.diag([side, side, more * 0.015**2 / 2.0])
    body = Payload(more, [0.0, 0.0, -0.03], inertia)
    tau = machine.inverse_dynamics(state, ddu, machine.loads.with_payload(body, "tool"))
    assert near(other.inverse_dynamics(other.close(state.u), ddu), tau)
    given = ("p_L", "p_R", "q_T")
    family = ask(machine, "free", "links.tool.mass", of=lambda one: one.coordinates, given=given)
    places = [machine.coordinates.index(name) for name in given]
    R = state.R[places]
    along = family.inverse_dynamics(state.s[places], [0.2 + more], ddu=R @ ddu)["tau"]
    assert near(R.T @ along, tau)
