"""Laws of closure, rates and accelerations, on robots and stacks nobody has seen.

Tolerances: an error e in the loop equations, of rounding size, moves the coordinates by e / margin,
where the margin is the smallest singular value of the passive Jacobian [m or rad], and R by about e
/ margin^2. Robots are built with a margin of at least 0.02, and states keep half of it, so these
bounds stay below 1e-8.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.checks.loop_types import check_loop_types
from hybrid_dynamics_core.description.document import Document
from hybrid_dynamics_core.formats.reader import parse_description
from tests.generated.assembly import turn, unit
from tests.generated.case import Case
from tests.generated.robots import STATES, as_text, examples, moved, robots, scaled, shuffled

ROUNDING = 1e-13  # of closures made of a dozen joints, with links of up to a few metres


def margin(case: Case, s: np.ndarray) -> float:
    """Smallest singular value of the passive Jacobian, at most 1."""
    return min(1.0, case.space.margin(s, range(case.n)))


def close_to(value: np.ndarray, expected: np.ndarray, tolerance: float | np.ndarray) -> bool:
    """Whether two arrays agree within an absolute tolerance."""
    return bool((np.abs(np.asarray(value) - np.asarray(expected)) <= tolerance).all())


def derivative(f: Callable[[float], np.ndarray], noise: float) -> tuple[np.ndarray, np.ndarray]:
    """d/dt f at 0 and its uncertainty.

    Central differences of two steps, extrapolated. Their difference is three times the error of the
    finer one, so a tenth of it bounds the error of the extrapolated value where the series
    converges; `noise` is the error of f.
    """
    h = 1e-4
    fine, coarse = ((f(step) - f(-step)) / (2.0 * step) for step in (h, 2.0 * h))
    return (4.0 * fine - coarse) / 3.0, 0.1 * np.abs(fine - coarse) + 2.0 * noise / h


@examples(18)
@given(robots(), STATES)
def test_every_closure_holds_in_space_by_the_poses_of_its_links(case: Case, seed: int) -> None:
    s = case.somewhere(seed)
    state = case.robot.close(s[: case.n])
    expected = case.space.poses(state.s)
    for c in case.description.closures:
        ends = []
        for link, point, rotation in (
            (c.link_a, c.point_a, c.rotation_a),
            (c.link_b, c.point_b, c.rotation_b),
        ):
            pose = case.robot.forward_kinematics(state, frame=link) if link != "base" else None
            r, p = (pose.rotation, pose.position) if pose else (np.eye(3), np.zeros(3))
            assert close_to(r, expected[link][0], ROUNDING)
            assert close_to(p, expected[link][1], ROUNDING)
            ends.append((p + r @ point, r @ rotation))
        (a, ra), (b, rb) = ends
        assert close_to(a, b, 10 * ROUNDING)
        axes = {"axis": [2], "frame": [0, 1, 2]}.get(c.kind, [])
        assert close_to(ra[:, axes], rb[:, axes], 10 * ROUNDING)
    assert state.residual < 10 * ROUNDING


@examples(30)
@given(robots())
def test_every_loop_forms_the_type_it_claims(case: Case) -> None:
    check_loop_types(Document({}, None, {}), case.description)


@examples(24)
@given(robots(), STATES)
def test_closure_is_newtons(case: Case, seed: int) -> None:
    """From the reference along a smooth way, in small steps, on equations in space.

    The same configuration.
    """
    s = case.somewhere(seed, size=0.9, floor=0.3)
    near = case.robot.close(case.start[: case.n])
    assert close_to(near.s, case.start, 1e-12 / margin(case, case.start))
    for start in (None, near):
        state = case.robot.close(s[: case.n], near=start)
        assert close_to(state.s, s, 1e-11 / margin(case, s))


@examples(12)
@given(robots(), STATES)
def test_rates_are_the_derivative_of_the_closure(case: Case, seed: int) -> None:
    s, du = case.somewhere(seed), case.rates(seed)
    u = s[: case.n]
    state = case.robot.close(u, du)
    error = ROUNDING / margin(case, s)
    numeric, tolerance = derivative(lambda t: case.robot.close(u + t * du, near=state).s, error)
    assert close_to(state.ds, numeric, tolerance + 1e-9)
    assert close_to(state.R @ du, state.ds, 1e-12 / margin(case, s) ** 2)


@examples(12)
@given(robots(), STATES)
def test_accelerations_are_the_derivative_of_the_rates(case: Case, seed: int) -> None:
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    u = s[: case.n]
    state = case.robot.close(u, du)

    def rates(t: float) -> np.ndarray:
        return case.robot.close(u + t * du + 0.5 * t * t * ddu, du + t * ddu, near=state).ds

    numeric, tolerance = derivative(rates, ROUNDING / margin(case, s) ** 2)
    assert close_to(case.robot.accelerations(state, ddu), numeric, tolerance + 1e-8)
    assert close_to(
        state.R @ ddu + state.bias,
        case.robot.accelerations(state, ddu),
        1e-11 / margin(case, s) ** 3,
    )


@examples(18)
@given(robots(), STATES)
def test_closures_do_no_work(case: Case, seed: int) -> None:
    """J_s R = 0 with every row that the loops have in space; R is theirs, by least squares."""
    s = case.somewhere(seed)
    state = case.robot.close(s[: case.n])
    _, jacobian = case.space.equations(state.s)
    assert np.abs(jacobian @ state.R).max(initial=0.0) < 1e-12 / margin(case, s)
    assert close_to(
        state.R, case.space.velocity_map(state.s, range(case.n)), 1e-11 / margin(case, s) ** 2
    )


@examples(9)
@given(robots(), STATES)
def test_jacobian_is_the_derivative_of_the_pose(case: Case, seed: int) -> None:
    s, du = case.somewhere(seed), case.rates(seed)
    robot, u = case.robot, s[: case.n]
    state = robot.close(u, du)
    here = robot.forward_kinematics(state)

    def pose(t: float) -> np.ndarray:
        there = robot.forward_kinematics(robot.close(u + t * du, near=state))
        spin = there.rotation @ here.rotation.T
        return np.array([*there.position, spin[2, 1], spin[0, 2], spin[1, 0]])

    numeric, tolerance = derivative(pose, ROUNDING / margin(case, s))
    assert close_to(robot.jacobian(state) @ du, numeric, tolerance + 1e-9)


@examples(12)
@given(robots(), STATES)
def test_order_in_the_file_does_not_matter(case: Case, seed: int) -> None:
    """Nor from which end a closure is told."""
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    other = Robot(shuffled(case.description, seed))
    assert other.active == case.robot.active
    one, two = (robot.close(s[: case.n], du) for robot in (case.robot, other))
    same = [other.coordinates.index(name) for name in case.robot.coordinates]
    m = margin(case, s)
    assert close_to(one.s, two.s[same], 1e-11 / m)
    assert close_to(one.ds, two.ds[same], 1e-11 / m**2)
    assert close_to(one.bias, two.bias[same], 1e-10 / m**3)
    a, b = (
        robot.inverse_dynamics(state, ddu) for robot, state in ((case.robot, one), (other, two))
    )
    assert close_to(a, b, 1e-11 / m**3 * max(1.0, np.abs(a).max()))


@examples(12)
@given(robots(), STATES)
def test_robot_mounted_elsewhere_with_its_gravity_needs_the_same_efforts(
    case: Case, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    rotation, offset = turn(unit(rng.normal(size=3)), rng.uniform(-3, 3)), rng.normal(size=3)
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    other = Robot(moved(case.description, rotation, offset))
    one, two = (robot.close(s[: case.n], du) for robot in (case.robot, other))
    m = margin(case, s)
    assert close_to(one.s, two.s, 1e-11 / m)
    a, b = (
        robot.inverse_dynamics(state, ddu) for robot, state in ((case.robot, one), (other, two))
    )
    assert close_to(a, b, 1e-11 / m**3 * max(1.0, np.abs(a).max()))
    here, there = case.robot.forward_kinematics(one), other.forward_kinematics(two)
    assert close_to(there.position, rotation @ here.position + offset, 1e-11 / m)
    assert close_to(there.rotation, rotation @ here.rotation, 1e-11 / m)


@examples(9)
@given(robots(), STATES, st.sampled_from([1e-3, 30.0]))
def test_size_does_not_change_angles_nor_the_distance_to_a_singularity(
    case: Case, seed: int, factor: float
) -> None:
    s = case.somewhere(seed)
    other = Robot(scaled(case.description, factor))
    turning = np.array([kind == "revolute" for kind in case.robot.joint_types.values()])
    size = np.where(turning, 1.0, factor)
    one, two = case.robot.close(s[: case.n]), other.close((size * s)[: case.n])
    m = margin(case, s)
    assert close_to(two.s / size, one.s, 1e-11 / m)
    assert close_to(two.distances, one.distances, 1e-10 / m**2)


@examples(12)
@given(robots(), STATES)
def test_robot_written_as_a_file_is_the_same(case: Case, seed: int) -> None:
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    other = Robot(parse_description(as_text(case.description), file="generated.yaml"))
    assert other.coordinates == case.robot.coordinates
    one, two = (robot.close(s[: case.n], du) for robot in (case.robot, other))
    m = margin(case, s)
    assert close_to(
        one.s, two.s, 1e-10 / m
    )  # angles of rotations are written with 1e-16, near +-90 degrees less
    a, b = (
        robot.inverse_dynamics(state, ddu) for robot, state in ((case.robot, one), (other, two))
    )
    assert close_to(a, b, 1e-10 / m**3 * max(1.0, np.abs(a).max()))


@examples(12)
@given(robots(), STATES)
def test_a_state_in_a_batch_is_the_state_alone(case: Case, seed: int) -> None:
    rows = np.array([case.somewhere(seed + k) for k in range(3)])
    u, du, ddu = (
        rows[:, : case.n],
        *(np.array([case.rates(seed + k) for k in ks]) for ks in ((0, 1, 2), (3, 4, 5))),
    )
    batch = case.robot.close(u, du)
    tau = case.robot.inverse_dynamics(batch, ddu)
    followed = case.robot.close(u, du, near=case.robot.close(case.start[: case.n]))
    for k in range(3):
        single = case.robot.close(u[k], du[k])
        m = margin(case, rows[k])
        assert close_to(batch.s[k], single.s, 1e-12 / m)
        assert close_to(followed.s[k], single.s, 1e-12 / m)
        assert close_to(batch.R[k], single.R, 1e-12 / m**2)
        alone = case.robot.inverse_dynamics(single, ddu[k])
        assert close_to(tau[k], alone, 1e-12 / m**3 * max(1.0, np.abs(alone).max()))
        assert batch.distances[k] == pytest.approx(single.distances, abs=1e-12 / m)
