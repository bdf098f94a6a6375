"""MuJoCo computes what this library does from its MJCF, but for the softness of its loops."""

from __future__ import annotations

import textwrap

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, shipped_robots
from hybrid_dynamics_core.formats.mjcf.writer import to_mjcf
from hybrid_dynamics_core.formats.reader import parse_description
from tests.robots import random_states, random_vector, robot
from tests.sampling import swept

mujoco = pytest.importorskip("mujoco")


class Model:
    """A robot in MuJoCo, coordinates in the order of this library."""

    def __init__(self, machine: Robot) -> None:
        self.machine = machine
        self.model = mujoco.MjModel.from_xml_string(to_mjcf(machine))
        self.data = mujoco.MjData(self.model)
        self.index = np.array([self.model.joint(name).dofadr[0] for name in machine.coordinates])

    def hard(self, s: np.ndarray, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations at rest: from MuJoCo's matrices with rigid loops, and MuJoCo's."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self.index], self.data.ctrl[:] = s, tau
        mujoco.mj_forward(self.model, self.data)
        n = self.model.nv
        mass = np.zeros((n, n))
        mujoco.mj_fullM(self.model, self.data, mass)
        rows = self.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        J = np.array(self.data.efc_J).reshape(-1, n)[rows]
        force = self.data.qfrc_actuator + self.data.qfrc_passive - self.data.qfrc_bias
        kkt = np.block([[mass, J.T], [J, np.zeros((len(J), len(J)))]])
        solved = np.linalg.lstsq(kkt, np.concatenate([force, np.zeros(len(J))]), rcond=1e-13)[0]
        return solved[:n][self.index], np.array(self.data.qacc)[self.index]


@pytest.mark.parametrize("name", swept(shipped_robots()))
class TestEveryRobot:
    def test_the_model_is_the_same(self, name: str) -> None:
        machine = robot(name)
        tau = machine.inverse_dynamics(random_states(name)[0], random_vector(machine, 1))
        state = machine.close(random_states(name)[0].u)
        expected = machine.accelerations(state, machine.forward_dynamics(state, tau))
        rigid, soft = Model(machine).hard(state.s, tau)
        size = np.abs(expected).max()
        assert (
            np.abs(rigid - expected).max() < 1e-5 * size
        )  # bodies without mass have 1e-9 kg, and least squares
        assert (
            np.abs(soft - expected).max() < 0.2 * size
        )  # MuJoCo's loops give way: 1e-4 of their inertia, as it guesses

    def test_a_held_pose_stays(self, name: str) -> None:
        """To 1e-6 [rad or m] in a tenth of a second: later, an upright arm falls from rounding."""
        m = Model(robot(name))
        mujoco.mj_resetDataKeyframe(m.model, m.data, 0)
        start = m.data.qpos.copy()
        assert start[m.index] == pytest.approx(robot(name).close(robot(name).reference).s)
        for _ in range(round(0.1 / m.model.opt.timestep)):
            mujoco.mj_step(m.model, m.data)
        assert m.data.time == pytest.approx(0.1)
        assert np.abs(m.data.qpos - start).max() < 1e-6


def test_effects_of_joints_are_the_same_in_mujoco() -> None:
    """A pendulum with spring, preload, rotor and damping has the same acceleration and force."""
    text = """
        format: 1
        name: pendulum
        links: {base: {}, bob: {mass: 2, com: [0.5, 0, 0], inertia: {rod: {axis: x, length: 1}}}}
        joints:
          q:
            type: revolute
            parent: base
            child: bob
            origin: {rpy: [pi/2, 0, 0]}
            axis: z
            friction: {viscous: 0.3}
            drive: {rotor_inertia: 0.01, gear_ratio: 10}
            spring: {stiffness: 4, rest: 0.2, preload: 1.5}
        loops: {}
        active: [q]
        end_effector: {link: bob, xyz: [1, 0, 0]}
    """
    machine = Robot(parse_description(textwrap.dedent(text)))
    state = machine.close([0.4], [0.7])
    m = Model(machine)
    m.data.qpos[:], m.data.qvel[:], m.data.ctrl[:] = 0.4, 0.7, 5.0
    mujoco.mj_forward(m.model, m.data)
    assert m.data.qacc == pytest.approx(machine.forward_dynamics(state, [5.0]), rel=1e-9)
