"""Random robots in three engines: this library, Pinocchio and MuJoCo close, move and push alike.

Robots keep a margin (smallest singular value of the passive Jacobian, m or rad) of 0.01 at least:
an engine that closes to rounding has coordinates good to 1e-13 / margin and R good to 1e-13 /
margin^2, below the 1e-8 asked for.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given

from tests.agreement.mujoco_model import MujocoRobot
from tests.agreement.pinocchio_model import PinocchioRobot
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots

AGREE = 1e-8
ENGINES = pytest.mark.parametrize(
    "engine", [PinocchioRobot, MujocoRobot], ids=["Pinocchio", "MuJoCo"]
)


def some_links(case: Case) -> list[str]:
    """Every few links: a pose is a program of its own, and takes its time to build."""
    links = list(case.description.links)
    return links[:: max(1, len(links) // 3)]


@ENGINES
@examples(15)
@given(case=robots(), seed=STATES)
def test_closed_configurations_agree(engine: type, case: Case, seed: int) -> None:
    """The engine's Newton on its constraints, from a start off by up to a tenth of the margin."""
    s = case.somewhere(seed)
    state = case.robot.close(s[: case.n])
    other = engine(case.description, case.robot.coordinates)
    gap, _ = other.gaps(state.s)
    assert len(gap) >= 2 * len(case.description.closures)  # the engine has them all
    assert np.abs(gap).max(initial=0.0) < 1e-11
    start = state.s.copy()
    offset = 0.1 * case.space.margin(s, range(case.n))
    start[case.n :] += offset * np.cos(np.arange(len(s) - case.n))
    assert other.close(start, case.n) == pytest.approx(state.s, abs=AGREE)
    for link in some_links(case):
        rotation, origin = other.pose(state.s, link)
        pose = case.robot.forward_kinematics(state, frame=link)
        assert pose.position == pytest.approx(origin, abs=AGREE)
        assert pose.rotation == pytest.approx(rotation, abs=AGREE)


@ENGINES
@examples(12)
@given(case=robots(), seed=STATES)
def test_constrained_jacobians_and_velocities_agree(engine: type, case: Case, seed: int) -> None:
    s, du = case.somewhere(seed), case.rates(seed)
    state = case.robot.close(s[: case.n], du)
    other = engine(case.description, case.robot.coordinates)
    size = max(1.0, float(np.abs(state.R).max()))
    theirs = other.velocity_map(state.s, case.n)
    assert np.abs(state.R - theirs).max() < AGREE * size
    for link in some_links(case):
        linear, angular = other.velocity(state.s, theirs @ du, link)
        twist = case.robot.jacobian(state, frame=link) @ du
        assert twist == pytest.approx(np.concatenate([linear, angular]), abs=AGREE * size)


@ENGINES
@examples(12)
@given(case=robots(), seed=STATES)
def test_efforts_are_the_tree_forces_projected(engine: type, case: Case, seed: int) -> None:
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    state = case.robot.close(s[: case.n], du)
    dds = case.robot.accelerations(state, ddu)
    other = engine(case.description, case.robot.coordinates)
    theirs = other.velocity_map(state.s, case.n).T @ other.tree_forces(state.s, state.ds, dds)
    tau = case.robot.inverse_dynamics(state, ddu)
    size = max(1.0, float(np.abs(state.R).max() * np.abs(dds).max()))
    assert tau == pytest.approx(theirs, abs=10 * AGREE * size)


@examples(9)
@given(robots(), STATES)
def test_closing_accelerations_are_pinocchios(case: Case, seed: int) -> None:
    """J s'' + J' s' = 0 for the points of all closures, with Pinocchio's accelerations."""
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    assume(case.description.closures)
    state = case.robot.close(s[: case.n], du)
    dds = case.robot.accelerations(state, ddu)
    other = PinocchioRobot(case.description, case.robot.coordinates)
    bias = other.bias(state.s, state.ds).reshape(-1, 3)
    for k, c in enumerate(case.description.closures):
        alone = PinocchioRobot(case.description, case.robot.coordinates)
        alone.closures = (c,)
        jacobian = alone.gaps(state.s)[1][:3]
        size = max(1.0, float(np.abs(dds).max()))
        assert np.abs(jacobian @ dds + bias[k]).max() <= 1e-9 * size
