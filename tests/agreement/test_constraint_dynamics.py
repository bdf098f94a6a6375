"""The equations of motion of two other engines, on shipped robots, mechanisms and random robots.

Forward dynamics is compared with Pinocchio's constraintDynamics, which solves the tree with its
closures as contacts. Inverse dynamics and M-bar are compared with Pinocchio's rnea and crba, and
with MuJoCo's inverse dynamics of the tree. These are projected with the R of the engine's own
constraint Jacobian. (MuJoCo's qfrc_inverse of a closed mechanism is not the actuators'.)
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import ClosedState, Robot
from tests.agreement.mujoco_model import MujocoRobot
from tests.agreement.pinocchio_model import PinocchioRobot
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept

AGREE = 1e-8  # both engines close to 1e-12 or so; R loses up to four digits at margins of 0.01
CLOSED = tuple(name for name in ROBOTS if name != "serial")
ENGINES = pytest.mark.parametrize(
    "engine", [PinocchioRobot, MujocoRobot], ids=["Pinocchio", "MuJoCo"]
)


@cache
def model(engine: type, name: str) -> PinocchioRobot | MujocoRobot:
    return engine(robot(name).description, robot(name).coordinates)


def forward_error(machine: Robot, theirs: PinocchioRobot, state: ClosedState, seed: int) -> float:
    """Difference of all accelerations s'' relative to the largest."""
    tau = random_vector(machine, seed, 30.0)
    along = np.concatenate([tau, np.zeros(len(state.s) - state.n)])
    dds = machine.accelerations(state, machine.forward_dynamics(state, tau))
    return scaled(theirs.constraint_dynamics(state.s, state.ds, along) - dds, dds)


@pytest.mark.parametrize("name", swept(CLOSED))
def test_forward_dynamics_is_that_of_the_constrained_tree(name: str) -> None:
    for k, state in enumerate(random_states(name)):
        assert forward_error(robot(name), model(PinocchioRobot, name), state, k) < AGREE


@examples(15)
@given(case=robots(), seed=STATES)
def test_forward_dynamics_of_random_robots_is_that_of_the_constrained_tree(
    case: Case, seed: int
) -> None:
    assume(case.description.closures)
    state = case.robot.close(case.somewhere(seed)[: case.n], case.rates(seed))
    theirs = PinocchioRobot(case.description, case.robot.coordinates)
    assert forward_error(case.robot, theirs, state, seed) < AGREE


@ENGINES
@pytest.mark.parametrize("name", swept(ROBOTS))
def test_inverse_dynamics_is_the_trees_projected(name: str, engine: type) -> None:
    machine, theirs = robot(name), model(engine, name)
    for k, state in enumerate(random_states(name)):
        ddu = random_vector(machine, k)
        forces = theirs.tree_forces(state.s, state.ds, machine.accelerations(state, ddu))
        tau = theirs.velocity_map(state.s, state.n).T @ forces
        size = np.abs(state.R).T @ np.abs(forces)  # what cancels in R^T f
        assert scaled(machine.inverse_dynamics(state, ddu) - tau, size) < AGREE


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_mass_matrix_is_the_trees_projected(name: str) -> None:
    machine, theirs = robot(name), model(PinocchioRobot, name)
    for state in random_states(name):
        R = theirs.velocity_map(state.s, state.n)
        mass = R.T @ theirs.crba(state.s) @ R
        assert scaled(machine.minimal_form(state)[0] - mass, mass) < AGREE
