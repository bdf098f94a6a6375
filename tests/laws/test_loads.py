"""Laws of what acts besides the actuators.

Payloads, wrenches, friction, rotors, springs, on every robot.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from hybrid_dynamics_core import Loads, Payload, Robot
from hybrid_dynamics_core.description.model import Link
from hybrid_dynamics_core.ground.arrays import frozen
from tests.mechanisms import changed
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept

TOOL = Payload(7.5, [0.05, -0.1, 0.2], [[0.3, 0.02, -0.01], [0.02, 0.25, 0.03], [-0.01, 0.03, 0.2]])
TIGHT = 1e-11  # rounding, relative to the terms that make the value up


def heavy_loads(machine: Robot, seed: int = 0) -> Loads:
    """Some of everything."""
    rng = np.random.default_rng(seed)
    n = len(machine.coordinates)
    tail = machine.frames[-1]
    return (
        machine.loads.with_payload(TOOL)
        .with_payload(Payload(40.0, [0.0, 0.1, -0.2]), tail)
        .with_wrench(rng.uniform(-50, 50, 6))
        .with_wrench(rng.uniform(-50, 50, 6), tail, "frame")
        .with_effects(
            viscous=rng.uniform(0, 5, n),
            coulomb=rng.uniform(0, 5, n),
            smoothing=np.full(n, 0.05),
            armature=rng.uniform(0, 3, n),
            stiffness=rng.uniform(0, 50, n),
            rest=rng.uniform(-1, 1, n),
            preload=rng.uniform(-10, 10, n),
        )
        .with_gravity([1.0, -2.0, -9.0])
    )


def with_payload_in_its_link(machine: Robot) -> Robot:
    """The robot whose description has the tool joined to the link that carries it."""
    frame = machine.description.frames["end_effector"]
    own = machine.description.links[frame.link]
    com = frame.translation + frame.rotation @ TOOL.com
    mass = own.mass + TOOL.mass
    middle = (own.mass * own.com + TOOL.mass * com) / mass
    inertia = own.inertia + frame.rotation @ TOOL.inertia @ frame.rotation.T
    for m, c in ((own.mass, own.com), (TOOL.mass, com)):
        d = c - middle
        inertia = inertia + m * (d @ d * np.eye(3) - np.outer(d, d))
    joined = Link(frame.link, mass, frozen(middle), frozen(inertia))
    links = {**machine.description.links, frame.link: joined}
    return changed(machine, links=MappingProxyType(links))


@pytest.mark.parametrize("name", swept(ROBOTS))
class TestLoads:
    def test_payload_is_part_of_its_link(self, name: str) -> None:
        """The same tau as from a description whose link has the payload's mass and inertia joined
        to its own.
        """
        machine, ddu = robot(name), random_vector(robot(name), 1)
        other = with_payload_in_its_link(machine)
        for state in random_states(name):
            tau = machine.inverse_dynamics(state, ddu, machine.loads.with_payload(TOOL))
            expected = other.inverse_dynamics(other.close(state.u, state.du), ddu)
            assert scaled(tau - expected, expected) < TIGHT

    def test_wrench_takes_its_work_off_the_actuators(self, name: str) -> None:
        """tau changes by -J^T w, whatever the motion."""
        machine, ddu = robot(name), random_vector(robot(name), 2)
        wrench = np.array([30.0, -20.0, 50.0, 4.0, -3.0, 2.0])
        for state in random_states(name):
            bare = machine.inverse_dynamics(state, ddu)
            for frame in ("end_effector", machine.frames[-1]):
                work = machine.jacobian(state, frame).T @ wrench
                tau = machine.inverse_dynamics(state, ddu, machine.loads.with_wrench(wrench, frame))
                assert scaled(tau - (bare - work), bare, work) < TIGHT
                rotation = machine.forward_kinematics(state, frame).rotation
                turned = np.concatenate([rotation.T @ wrench[:3], rotation.T @ wrench[3:]])
                same = machine.inverse_dynamics(
                    state, ddu, machine.loads.with_wrench(turned, frame, "frame")
                )
                assert scaled(same - tau, bare, work) < TIGHT

    def test_held_payload_is_a_force_at_its_centre(self, name: str) -> None:
        machine = robot(name)
        weight = Payload(12.0, [0.1, 0.2, 0.3])
        for state in random_states(name):
            still = machine.close(state.u, near=state)
            rotation = machine.forward_kinematics(still).rotation
            force = 12.0 * machine.loads.gravity
            moment = np.cross(rotation @ weight.com, force)
            zero = np.zeros(state.n)
            held = machine.inverse_dynamics(still, zero, machine.loads.with_payload(weight))
            pushed = machine.inverse_dynamics(
                still, zero, machine.loads.with_wrench([*force, *moment])
            )
            assert (
                scaled(held - pushed, held, machine.jacobian(still).T @ [*force, *moment]) < TIGHT
            )

    def test_joint_effects_are_projected_with_R(self, name: str) -> None:
        machine, ddu = robot(name), random_vector(robot(name), 3)
        loads = heavy_loads(machine)
        only = replace(machine.loads, effects=loads.effects)
        e = loads.effects
        for state in random_states(name):
            rate, push = state.ds, machine.accelerations(state, ddu)
            along = e.viscous * rate + e.coulomb * rate / np.sqrt(rate**2 + e.smoothing**2)
            along += e.armature * push + e.stiffness * (state.s - e.rest) + e.preload
            bare, tau = (
                machine.inverse_dynamics(state, ddu),
                machine.inverse_dynamics(state, ddu, only),
            )
            assert (
                scaled(tau - bare - state.R.T @ along, bare, np.abs(state.R.T) @ np.abs(along))
                < TIGHT
            )

    def test_minimal_form_and_forces_of_the_loads_make_up_tau(self, name: str) -> None:
        machine, ddu = robot(name), random_vector(robot(name), 4)
        loads = heavy_loads(machine)
        for state in random_states(name):
            mass, bias, gravity = machine.minimal_form(state, loads)
            rest = machine.passive_forces(state, loads)
            tau = machine.inverse_dynamics(state, ddu, loads)
            assert (
                scaled(mass @ ddu + bias + gravity + rest - tau, mass, bias, gravity, rest) < TIGHT
            )
            assert (
                scaled(machine.coriolis_matrix(state, loads) @ state.du - bias, bias, mass) < TIGHT
            )

    def test_forward_dynamics_with_everything(self, name: str) -> None:
        machine = robot(name)
        loads = heavy_loads(machine)
        tau = random_vector(machine, 5, 100.0)
        for state in random_states(name):
            ddu = machine.forward_dynamics(state, tau, loads)
            again = machine.inverse_dynamics(state, ddu, loads)
            assert scaled(again - tau, tau, machine.passive_forces(state, loads)) < 1e-9

    def test_values_change_without_another_trace(self, name: str) -> None:
        machine, state = robot(name), random_states(name)[0]
        ddu = random_vector(machine, 6)
        first = machine.inverse_dynamics(state, ddu, heavy_loads(machine, 1))
        known = set(machine._kernels.kernels)
        second = machine.inverse_dynamics(state, ddu, heavy_loads(machine, 2))
        assert set(machine._kernels.kernels) == known
        assert not np.allclose(first, second)

    def test_a_batch_with_a_wrench_for_each_row(self, name: str) -> None:
        machine, states = robot(name), random_states(name)
        rng = np.random.default_rng(3)
        batch = machine.close(np.array([s.u for s in states]), np.array([s.du for s in states]))
        wrenches, turning = rng.uniform(-9, 9, (2, len(states), 6))
        ddu = rng.uniform(-1, 1, batch.u.shape)
        loads = (
            heavy_loads(machine)
            .with_wrench(wrenches)
            .with_wrench(turning, machine.frames[-1], "frame")
        )
        tau = machine.inverse_dynamics(batch, ddu, loads)
        for k, state in enumerate(states):
            alone = loads.with_wrench(wrenches[k]).with_wrench(
                turning[k], machine.frames[-1], "frame"
            )
            assert scaled(tau[k] - machine.inverse_dynamics(state, ddu[k], alone), tau[k]) < 1e-10
