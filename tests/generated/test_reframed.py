"""A robot in other words is the same robot: nothing depends on origins, axes, zeros and units."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from tests.generated.case import Case
from tests.generated.reframed import reframed
from tests.generated.robots import STATES, examples, robots, scaled


@examples(40)
@given(robots(), STATES, st.integers(0, 10**6))
def test_distances_and_efforts_do_not_depend_on_frames(case: Case, seed: int, frames: int) -> None:
    description, zeros = reframed(case.description, frames)
    other = Robot(description)
    shift = np.array([zeros[name] for name in case.robot.coordinates])
    s, du = case.somewhere(seed), case.rates(seed)
    n = case.n
    state = case.robot.close(s[:n], du, near=case.robot.close(case.start[:n]))
    there = other.close(s[:n] - shift[:n], du, near=other.close(case.start[:n] - shift[:n]))
    margin = float(state.singularity)
    np.testing.assert_allclose(there.s + shift, state.s, atol=1e-9 / margin)
    np.testing.assert_allclose(there.distances, state.distances, atol=1e-9 / margin)
    efforts = case.robot.inverse_dynamics(state, du)
    scale = 1.0 + np.abs(efforts).max()
    np.testing.assert_allclose(other.inverse_dynamics(there, du), efforts, atol=1e-8 * scale)


@examples(40)
@given(robots(), STATES, st.sampled_from([1e-3, 0.1, 7.0, 1e3]))
def test_distances_do_not_depend_on_the_size(case: Case, seed: int, factor: float) -> None:
    other = Robot(scaled(case.description, factor))
    s = case.somewhere(seed)
    is_slide = [kind == "prismatic" for kind in case.robot.joint_types.values()]
    scales = np.where(is_slide, factor, 1.0)
    n = case.n
    state = case.robot.close(s[:n], near=case.robot.close(case.start[:n]))
    start = other.close((scales * case.start)[:n])
    # a straight way of many steps: a step is bounded in metres
    way = np.linspace(start.u, scales[:n] * s[:n], 40)
    there = other.close_path(way, near=start).rows(-1)
    np.testing.assert_allclose(there.distances, state.distances, atol=1e-9 / state.singularity)
