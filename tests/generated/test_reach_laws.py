"""Inverse kinematics on random robots: what a robot can reach is never called out of reach."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import differential_evolution

from hybrid_dynamics_core import IKStatus
from hybrid_dynamics_core.kinematics.farthest import farthest_reach
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples
from tests.turning import Turning, turning_linkages


@examples(6)
@given(class_three(max_links=4, max_loops=3), STATES)
def test_the_place_of_a_state_is_reached_or_not_found(case: Case, seed: int) -> None:
    robot = case.robot
    near = robot.close(case.start[: case.n])
    state = robot.close(case.somewhere(seed)[: case.n], near=near)
    pose = robot.forward_kinematics(state)
    assert np.linalg.norm(pose.position) <= farthest_reach(robot) * (1.0 + 1e-9)
    for target in (pose.position, pose):
        result = robot.inverse_kinematics(target, near=near)
        assert result.status is not IKStatus.OUT_OF_REACH, result.message
        if result.status is IKStatus.SOLVED:
            at = robot.forward_kinematics(result.state).position
            np.testing.assert_allclose(at, pose.position, atol=1e-8)
    assert robot.inverse_kinematics(pose.position, near=state).status is IKStatus.SOLVED


@examples(12)
@given(turning_linkages(), st.floats(-3.0, 3.0), st.floats(0.3, 3.0), st.integers(0, 9))
def test_the_nearest_place_is_that_of_a_global_search(
    linkage: Turning, angle: float, far: float, seed: int
) -> None:
    """Differential evolution over the crank, which knows nothing of gradients."""
    robot = linkage.robot(seed)
    start = robot.forward_kinematics(robot.close(robot.reference))
    away = far * np.array([np.cos(angle), np.sin(angle), 0.0])
    target = start.position + start.rotation @ away

    def distance(u: np.ndarray) -> float:
        place = robot.forward_kinematics(robot.close(u)).position
        return float(np.linalg.norm(place - target))

    bounds = [(-np.pi, np.pi)]
    best = differential_evolution(distance, bounds, seed=1, popsize=20, tol=1e-14, atol=1e-12)
    result = robot.inverse_kinematics(target)
    assume(best.fun > 1e-6)
    assert result.status is not IKStatus.SOLVED
    assert result.position_error <= best.fun + 1e-5
