"""Inverse kinematics on random robots: what a robot can reach is never called out of reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import differential_evolution

from hybrid_dynamics_core import IKStatus, Robot
from hybrid_dynamics_core.kinematics.farthest import farthest_reach
from tests.generated.assembly import BASE, Assembly, unit
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


@examples(10)
@given(st.integers(0, 10**6))
def test_within_limits_the_nearest_place_is_that_of_a_global_search(seed: int) -> None:
    """Random arms, whose limits keep most targets out of reach."""
    rng = np.random.default_rng(seed)
    robot = arm_in_limits(rng)
    start = robot.forward_kinematics(robot.close(robot.reference)).position
    target = start + rng.uniform(0.1, 1.2) * unit(rng.normal(size=3))

    def distance(u: np.ndarray) -> np.ndarray:
        places = robot.forward_kinematics(robot.close(np.atleast_2d(u.T))).position
        return np.linalg.norm(places - target, axis=-1)

    best = differential_evolution(
        distance, robot.limits.tolist(), seed=1, maxiter=60, updating="deferred", vectorized=True
    )
    result = robot.inverse_kinematics(target)
    assert result.position_error <= best.fun + 1e-5
    assert (robot.limits[:, 0] <= result.u).all()
    assert (result.u <= robot.limits[:, 1]).all()
    assert (result.status is IKStatus.SOLVED) == (result.position_error < 1e-8)


def arm_in_limits(rng: np.random.Generator) -> Robot:
    """An arm of two to five joints in space, with narrow limits."""
    a = Assembly(rng)
    link, place = BASE, np.zeros(3)
    for k in range(int(rng.integers(2, 6))):
        place = place + 0.4 * rng.normal(size=3)
        kind = rng.choice(["revolute", "revolute", "revolute", "prismatic"])
        link = a.hang(link, str(kind), unit(rng.normal(size=3)), place, name=f"l{k}")
    description = a.description(tuple(a.joints), link)
    joints = {}
    for name, joint in description.joints.items():
        below, above = rng.uniform(0.2, 2.5, 2) * (1.0 if joint.type == "revolute" else 0.2)
        value = description.reference[name]
        joints[name] = replace(joint, limits=(value - below, value + above))
    return Robot(replace(description, joints=joints))
