"""A robot in other words is the same robot: nothing depends on origins, axes, zeros and units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import ClosedState, DescriptionError, Robot
from hybrid_dynamics_core.closure.numeric_closure import gaps_and_jacobian
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.over_determined import KINDS, over_determined
from tests.generated.reframed import reframed, with_zeros
from tests.generated.robots import STATES, examples, robots, scaled


@examples(24)
@given(robots(), STATES, st.integers(0, 10**6))
def test_distances_and_efforts_do_not_depend_on_frames(case: Case, seed: int, frames: int) -> None:
    """Nor on the reference: the other robot has one elsewhere."""
    description, zeros = reframed(case.description, frames)
    shift = np.array([zeros[name] for name in case.robot.coordinates])
    elsewhere = case.somewhere(seed + 1) - shift
    reference = dict(zip(case.robot.coordinates, elsewhere.tolist(), strict=True))
    other = Robot(replace(description, reference=reference))
    s, du = case.somewhere(seed), case.rates(seed)
    n = case.n
    state = case.robot.close(s[:n], du, near=case.robot.close(case.start[:n]))
    start = other.close(case.start[:n] - shift[:n], near=other.close(elsewhere[:n]))
    there = other.close(s[:n] - shift[:n], du, near=start)
    margin = float(state.singularity)
    np.testing.assert_allclose(there.s + shift, state.s, atol=1e-9 / margin)
    np.testing.assert_allclose(there.distances, state.distances, atol=1e-9 / margin)
    efforts = case.robot.inverse_dynamics(state, du)
    scale = 1.0 + np.abs(efforts).max()
    np.testing.assert_allclose(other.inverse_dynamics(there, du), efforts, atol=1e-8 * scale)


@examples(16)
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


def named_modes(case: Case) -> Case:
    """The robot with the assembly modes of its reference named in the file."""
    branch = case.robot.close(case.start[: case.n]).branch
    closures = []
    for closure in case.description.closures:
        mode = closure.assembly
        if mode is None and closure.name in case.robot.mode_names:
            mode = branch[closure.name]
        closures.append(replace(closure, assembly=mode))
    return Case(case.label, replace(case.description, closures=tuple(closures)))


@examples(16)
@given(class_three(), st.integers(0, 10**6))
def test_without_a_reference_distances_do_not_depend_on_zeros(case: Case, zeros: int) -> None:
    """No reference is written: that which is taken has the driven joints at zero."""
    case = named_modes(case)
    rng = np.random.default_rng(zeros)
    others = []
    for _ in range(2):
        places = case.start + rng.uniform(-0.05, 0.05, len(case.start))
        zero = dict(zip(case.robot.coordinates, places.tolist(), strict=True))
        description = with_zeros(case.description, zero)
        try:
            others.append((Robot(replace(description, reference={})), places))
        except DescriptionError:  # it does not close with its driven joints at zero
            assume(False)
    states = []
    for other, places in others:
        state = other.close((case.start - places)[: case.n])
        states.append(state)
        # a Newton block may have taken another mode from zero
        assume(np.allclose(state.s + places, case.start, atol=1e-6))
    one, another = states
    atol = 1e-9 / float(one.singularity)
    np.testing.assert_allclose(one.distances, another.distances, atol=atol)
    here = case.robot.close(case.start[: case.n])
    np.testing.assert_allclose(one.distances, here.distances, atol=atol)


@examples(12)
@given(st.sampled_from(KINDS), STATES, st.integers(0, 10**6))
def test_over_determined_loops_have_one_distance(kind: str, seed: int, frames: int) -> None:
    """Which of their equations are independent depends on frames, and must not matter."""
    description = over_determined(kind, seed)
    robot = Robot(description)
    retold, zeros = reframed(description, frames)
    other = Robot(retold)
    shift = np.array([zeros[name] for name in robot.coordinates])
    u, du = robot.reference + 0.05, np.ones(1)
    state = robot.close(u, du, near=robot.close(robot.reference), check=False)
    assume(state.status == 0)
    there = other.close(u - shift[:1], du, near=other.close(robot.reference - shift[:1]))
    atol = 1e-9 / float(state.singularity)
    np.testing.assert_allclose(there.distances, state.distances, atol=atol)
    np.testing.assert_allclose(there.s + shift, state.s, atol=atol)
    np.testing.assert_allclose(there.ds, state.ds, atol=atol * np.abs(state.ds).max())
    np.testing.assert_allclose(state.distances, [least_squares_distance(robot, state)], atol=atol)


def least_squares_distance(robot: Robot, state: ClosedState) -> float:
    """The distance by the singular values of all equations together."""
    model = robot._model
    passive = range(1, len(state.s))
    _, rows = gaps_and_jacobian(model.tree, model.plan.loops, state.s, passive)
    sizes = np.linalg.svd(rows, compute_uv=False)
    return len(sizes) / float(np.linalg.norm(sizes) * np.linalg.norm(1.0 / sizes))
