"""Reactions against the balance of every single link, with the motion taken from Pinocchio."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import ClosedState, Loads, Payload, Reactions, Robot
from tests.agreement.pinocchio_model import PinocchioRobot
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept

WRENCH = np.array([40.0, -30.0, 20.0, 3.0, -2.0, 5.0])


@cache
def oracle(name: str) -> PinocchioRobot:
    machine = robot(name)
    return PinocchioRobot(machine.description, machine.coordinates)


def inertia_wrenches(
    theirs: PinocchioRobot, s: np.ndarray, ds: np.ndarray, dds: np.ndarray
) -> dict[str, tuple]:
    """By link: origin, and the force and moment about it that its motion needs.

    They are in base axes, without gravity.
    """
    model = theirs.model
    data = theirs.data
    pin.forwardKinematics(model, data, theirs.order(s), theirs.order(ds), theirs.order(dds))
    result = {}
    for link, (index, _) in theirs.frames.items():
        if index == 0:
            continue
        inertia = model.inertias[index]
        v = data.v[index]
        force = inertia * data.a[index] + v.cross(inertia * v)
        pose = data.oMi[index]
        linear = pose.rotation @ force.linear
        result[link] = (pose.translation, linear, pose.rotation @ force.angular)
    return result


def acting(
    machine: Robot,
    state: ClosedState,
    reactions: Reactions,
    loads: Loads,
    link: str,
    origin: np.ndarray,
) -> tuple:
    """Sum of forces on a link and of moments about its origin.

    They come from joints, pins, weight and applied wrenches.
    """
    pose = machine.forward_kinematics(state, link)
    body = machine.description.links[link]
    centre = pose.position + pose.rotation @ body.com
    acts = [(body.mass * loads.gravity, np.zeros(3), centre)]
    for sign, of_joint, of_pin in ((1.0, 1, 0), (-1.0, 0, 1)):
        touching = [j for j in reactions.joints.values() if j.links[of_joint] == link]
        touching += [p for p in reactions.pins.values() if p.links[of_pin] == link]
        acts += [(sign * r.force, sign * r.moment, r.place) for r in touching]
    for frame, wrench in loads.wrenches.items():
        if machine._model.frame(frame).link == link:
            place = machine.forward_kinematics(state, frame).position
            acts.append((wrench.values[:3], wrench.values[3:], place))
    force = sum(f for f, _, _ in acts)
    moment = sum(m + np.cross(place - origin, f) for f, m, place in acts)
    return force, moment


def imbalance(
    machine: Robot, theirs: PinocchioRobot, state: ClosedState, ddu: np.ndarray, loads: Loads
) -> float:
    """Largest force or moment missing on a link, relative to the largest of a joint or pin."""
    reactions = machine.reactions(state, ddu, loads)
    needs = inertia_wrenches(theirs, state.s, state.ds, machine.accelerations(state, ddu))
    size = largest_force(reactions)
    worst = 0.0
    for link, (origin, force, moment) in needs.items():
        f, m = acting(machine, state, reactions, loads, link, origin)
        worst = max(worst, np.abs(f - force).max(), np.abs(m - moment).max())
    return float(worst / size)


def largest_force(reactions: Reactions) -> float:
    """The largest force of a joint or pin."""
    every = (*reactions.joints.values(), *reactions.pins.values())
    return max(np.abs(reaction.force).max() for reaction in every)


def velocity_at(
    machine: Robot, state: ClosedState, link: str, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity of a place that moves with a link, and the link's angular velocity."""
    if link == "base":
        return np.zeros(3), np.zeros(3)
    twist = machine.jacobian(state, link) @ state.du
    arm = place - machine.forward_kinematics(state, link).position
    return twist[:3] + np.cross(twist[3:], arm), twist[3:]


def work_of_pins(machine: Robot, state: ClosedState, reactions: Reactions) -> float:
    """Largest power of a pin, relative to its force and moment.

    It is force times difference of the two links' velocities, and moment times that of their
    angular velocities.
    """
    worst = 0.0
    for pin_ in reactions.pins.values():
        va, wa = velocity_at(machine, state, pin_.links[0], pin_.place)
        vb, wb = velocity_at(machine, state, pin_.links[1], pin_.place)
        work = abs(pin_.force @ (va - vb) + pin_.moment @ (wa - wb))
        size = np.abs(pin_.force).max() + np.abs(pin_.moment).max()
        worst = max(worst, work / max(size, 1.0))
    return float(worst)


def along_joints(machine: Robot, state: ClosedState, reactions: Reactions) -> np.ndarray:
    """The part of each joint's wrench along its axis, in the order of s."""
    along = np.zeros(len(state.s))
    for body in machine._model.tree.bodies:
        reaction = reactions.joints[body.joint]
        axis = machine.forward_kinematics(state, body.name).rotation @ body.axis
        effort = reaction.force
        if body.type == "revolute":
            effort = reaction.moment
        along[body.coordinate] = axis @ effort
    return along


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_every_link_is_in_balance(name: str) -> None:
    """Newton and Euler on each free body."""
    machine = robot(name)
    loads = machine.loads.with_wrench(WRENCH).with_wrench(-0.5 * WRENCH, machine.frames[-1])
    for k, state in enumerate(random_states(name)):
        ddu = random_vector(machine, k)
        assert imbalance(machine, oracle(name), state, ddu, loads) < 1e-10


@examples(5)
@given(case=robots(), seed=STATES)
@pytest.mark.sweep(sample="test_every_link_is_in_balance")
def test_reactions_of_random_robots_balance_every_link_do_no_work_and_leave_passive_joints_free(
    case: Case, seed: int
) -> None:
    machine = case.robot
    state = machine.close(case.somewhere(seed)[: case.n], case.rates(seed))
    theirs = PinocchioRobot(case.description, machine.coordinates)
    loads = machine.loads.with_wrench(WRENCH).with_wrench(-0.5 * WRENCH, machine.frames[-1])
    # Pins of a loop in which a force hardly works have its share of their digits.
    ddu = case.rates(seed + 1)
    reactions = machine.reactions(state, ddu, loads)
    assume(min((float(pin.share) for pin in reactions.pins.values()), default=1.0) > 1e-4)
    assert imbalance(machine, theirs, state, ddu, loads) < 1e-8
    assert work_of_pins(machine, state, reactions) < 1e-9
    # passive joints turn freely: that is what settles the forces of the pins
    needed = np.append(machine.inverse_dynamics(state, ddu, loads), np.zeros(len(state.s) - case.n))
    size = largest_force(reactions)
    assert np.abs(along_joints(machine, state, reactions) - needed).max() < 1e-8 * size


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_joints_without_drives_turn_freely(name: str) -> None:
    """Along their axes the wrenches of active joints are tau, those of passive joints nothing."""
    machine = robot(name)
    for k, state in enumerate(random_states(name)):
        ddu = random_vector(machine, k)
        reactions = machine.reactions(state, ddu)
        tau = machine.inverse_dynamics(state, ddu)
        along = along_joints(machine, state, reactions)
        size = max(np.abs(r.force).max() for r in reactions.joints.values())
        assert scaled(reactions.tau - tau, tau) < 1e-12
        assert np.abs(along[: state.n] - tau).max() < 1e-11 * size
        assert np.abs(along[state.n :]).max(initial=0.0) < 1e-11 * size


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_reactions_do_no_work(name: str) -> None:
    machine = robot(name)
    for k, state in enumerate(random_states(name)):
        reactions = machine.reactions(state, random_vector(machine, k))
        assert work_of_pins(machine, state, reactions) < 1e-9


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_foundation_bears_weight_and_inertia(name: str) -> None:
    machine = robot(name)
    for k, state in enumerate(random_states(name)):
        ddu = random_vector(machine, k)
        needs = inertia_wrenches(oracle(name), state.s, state.ds, machine.accelerations(state, ddu))
        force = np.zeros(3)
        moment = np.zeros(3)
        for link, (origin, f, m) in needs.items():
            body = machine.description.links[link]
            pose = machine.forward_kinematics(state, link)
            centre = pose.position + pose.rotation @ body.com
            weight = body.mass * machine.loads.gravity
            force += f - weight
            moment += m + np.cross(origin, f) - np.cross(centre, weight)
        base = machine.reactions(state, ddu).base
        assert scaled(base - [*force, *moment], base) < 1e-11


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_a_batch_is_its_states(name: str) -> None:
    machine = robot(name)
    states = random_states(name)
    batch = machine.close(np.array([s.u for s in states]), np.array([s.du for s in states]))
    loads = machine.loads.with_payload(Payload(3.0, [0.1, 0, 0]))
    batched = machine.reactions(batch, loads=loads)
    for k, state in enumerate(states):
        single = machine.reactions(state, loads=loads)
        for key, reaction in single.pins.items():
            force = batched.pins[key].force[k]
            assert force == pytest.approx(reaction.force, rel=1e-8, abs=1e-9)
        for key, reaction in single.joints.items():
            moment = batched.joints[key].moment[k]
            assert moment == pytest.approx(reaction.moment, rel=1e-8, abs=1e-8)
