"""Inverse kinematics on chosen assembly modes, and targets that only a singular place reaches."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, IKStatus, InputError, Pose, Robot
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.kinematics.ik_problem import POSE_ROWS, POSITION_ROWS, build_problem
from tests.robots import robot
from tests.sampling import swept

TILT = np.array(
    [[1.0, 0.0, 0.0], [0.0, np.cos(0.3), -np.sin(0.3)], [0.0, np.sin(0.3), np.cos(0.3)]]
)


@pytest.mark.parametrize("name", swept(["five_bar", "forging_chu2020", "delta", "gough"]))
def test_a_target_is_reached_on_the_modes_of_a_given_state(name: str) -> None:
    machine = robot(name)
    for mode in machine.assembly_modes(machine.reference)[:4]:
        there = machine.close(machine.reference + 0.01, near=mode.state)
        target = machine.forward_kinematics(there).position
        found = machine.inverse_kinematics(target, near=mode.state)
        assert found.status is IKStatus.SOLVED, found.message
        assert found.state is not None
        assert dict(found.branch) == dict(mode.branch)
        assert np.allclose(machine.forward_kinematics(found.state).position, target, atol=1e-8)


@pytest.mark.parametrize("most", [1, 2, 3])
def test_one_start_descends_as_it_does_among_several(forging: Robot, most: int) -> None:
    """Both take the steps that are allowed, before rounding decides when they end."""
    target = forging.forward_kinematics(forging.close(forging.reference + 0.1))
    start = forging.reference - 0.05
    problem = build_problem(forging, target, POSITION_ROWS, start, None)
    alone = problem.descend(start[None], most)
    among = problem.descend(np.array([start, start]), most)
    assert alone.u[0] == pytest.approx(among.u[0], abs=1e-12)
    assert alone.iterations == among.iterations == most


def test_the_other_mode_has_another_reach(forging: Robot) -> None:
    own = forging.close(forging.reference)
    other = next(
        m.state
        for m in forging.assembly_modes(forging.reference)
        if dict(m.branch) != dict(own.branch)
    )
    target = forging.forward_kinematics(other).position
    found = forging.inverse_kinematics(target, near=other)
    assert found.u == pytest.approx(other.u, abs=1e-6)


@pytest.mark.parametrize("before", [1e-8, 1e-9])
def test_a_target_at_a_toggle_point_is_told_as_singular(forging: Robot, before: float) -> None:
    """That near to its toggle the loop closes, but what the cylinder says of the angle is lost in
    rounding.
    """
    u = np.array(forging.reference)
    u[1] = forging.closing_range[1, 1] - before
    found = forging.inverse_kinematics(forging.forward_kinematics(forging.close(u)).position)
    assert found.status is IKStatus.SINGULAR
    assert "theta_1" in found.message
    assert 1e-9 < found.residual < 1e-3


@pytest.mark.parametrize(("joint", "value"), [(0, np.pi), (1, 0.05), (1, 1.15), (2, 1.4), (3, 1.0)])
def test_the_very_limit_of_a_joint_is_reached(joint: int, value: float) -> None:
    machine = robot("excavator")
    u = np.array(machine.reference)
    u[joint] = value
    pose = machine.forward_kinematics(machine.close(u))
    for target in (pose, pose.position):
        found = machine.inverse_kinematics(target)
        assert found.status is IKStatus.SOLVED, found.message
        assert (machine.limits[:, 0] <= found.u).all()
        assert (found.u <= machine.limits[:, 1]).all()


def rest(name: str) -> ClosedState:
    return robot(name).close(robot(name).reference)


NOT_NEAR: dict[str, tuple[Callable[[Robot], Any], str]] = {
    "an array": (lambda machine: machine.reference, "got ndarray"),
    "a batch": (
        lambda machine: machine.close(np.stack([machine.reference] * 2)),
        "got a batch of 2",
    ),
    "of another robot": (lambda _: rest("five_bar"), "got a state of another robot"),
    "not closed": (
        lambda machine: machine.close(np.add(machine.reference, [0.0, 0.9, 0.0, 0.0]), check=False),
        "got one whose loops are not closed",
    ),
}


@pytest.mark.parametrize("case", NOT_NEAR)
def test_near_is_one_closed_state_of_the_robot_or_is_refused(forging: Robot, case: str) -> None:
    make, told = NOT_NEAR[case]
    at = forging.forward_kinematics(forging.close(forging.reference)).position
    with pytest.raises(
        InputError, match=f"near: one closed state of this robot is expected.*{told}"
    ):
        forging.inverse_kinematics(at, near=make(forging))


@pytest.mark.parametrize(
    ("name", "distances"),
    swept(
        [("five_bar", (1e3, 1e9, 1e99)), ("gough", (1e9,)), ("staicu2015", (1e99,))],
        ["five_bar", "staicu2015"],
    ),
)
def test_however_far_a_target_is_it_is_told_as_out_of_reach(
    name: str, distances: tuple[float, ...]
) -> None:
    """The legs of staicu2015 have no limits: that nothing was found there is no proof."""
    machine = robot(name)
    turned = machine.forward_kinematics(rest(name)).rotation
    for far in distances:
        status = machine.inverse_kinematics([far, 0.0, 0.0]).status
        is_bounded = np.isfinite(machine.limits).any()
        assert status is (IKStatus.OUT_OF_REACH if is_bounded else IKStatus.NOT_FOUND)
    for far in (1e160, -1e200, 1e308):
        for target in ([0.0, far, 0.0], Pose(np.array([0.0, far, 0.0]), turned)):
            with pytest.raises(
                InputError, match=r"target: y is -?1e\+\d+ m: out of reach, and too far away"
            ):
                machine.inverse_kinematics(target)


def test_what_is_left_to_a_target_is_told_in_metres_and_radians() -> None:
    """Half a turn about x cannot be made by a planar robot.

    The place is reached, the turn is left whole.
    """
    five_bar = robot("five_bar")
    here = five_bar.forward_kinematics(five_bar.close(five_bar.reference))
    flipped = Pose(here.position, np.diag([1.0, -1.0, -1.0]) @ here.rotation)
    result = five_bar.inverse_kinematics(flipped)
    assert result.state is not None
    found = five_bar.forward_kinematics(result.state)
    angle = np.arccos((np.trace(flipped.rotation @ found.rotation.T) - 1.0) / 2.0)
    assert result.position_error == pytest.approx(
        np.linalg.norm(found.position - flipped.position), abs=1e-12
    )
    assert result.angle_error == pytest.approx(
        angle, abs=1e-6
    )  # arccos near pi loses half of the digits
    assert result.message.startswith(
        "out of reach: the nearest found is "
    )  # rounding is told as 0 m
    assert f" m and {result.angle_error:.3g} rad (180 deg) away" in result.message
    length = float(np.linalg.norm(here.position))
    together = np.hypot(result.position_error, length * result.angle_error)
    assert result.residual == pytest.approx(together, rel=1e-9)


def test_only_what_counts_is_told() -> None:
    five_bar = robot("five_bar")
    place = five_bar.inverse_kinematics([9.0, 0.0, 0.0])
    assert place.position_error == place.residual > 1.0
    assert np.isnan(place.angle_error)
    assert f"the nearest found is {place.residual:.3g} m away" in place.message
    pose = Pose(np.zeros(3), np.diag([1.0, -1.0, -1.0]))
    turn = five_bar.inverse_kinematics(pose, mask=[False] * 3 + [True] * 3)
    assert np.isnan(turn.position_error)
    assert turn.angle_error == pytest.approx(np.pi, abs=1e-6)


def test_a_coordinate_that_no_joint_moves_is_named() -> None:
    five_bar = robot("five_bar")
    here = five_bar.forward_kinematics(five_bar.close(five_bar.reference)).position
    result = five_bar.inverse_kinematics(here + np.array([0.0, 0.0, 0.1]))
    assert result.status is IKStatus.OUT_OF_REACH
    assert result.message.endswith("no active joint moves z: the rest is reached")
    far = five_bar.inverse_kinematics([5.0, 0.3, 0.0])
    plane = five_bar.inverse_kinematics(
        [5.0, 0.3, 0.0], mask=[True, True, False, False, False, False]
    )
    assert far.message.endswith(
        f"no active joint moves z: of the rest {plane.residual:.3g} m are left"
    )
    assert "joint" not in plane.message  # it is too far, and that is all


def test_whether_the_position_alone_is_the_reason_is_told() -> None:
    forging = robot("forging_chu2020")
    here = forging.forward_kinematics(forging.close(forging.reference))
    tilt = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    turned = forging.inverse_kinematics(Pose(here.position, tilt @ here.rotation))
    assert (
        "the position alone can be reached; 4 active joints cannot meet every target of 6"
        in turned.message
    )
    far = np.array([9.0, 0.0, 1.0])
    alone = forging.inverse_kinematics(far)
    both = forging.inverse_kinematics(Pose(far, tilt @ here.rotation))
    assert both.message.endswith(f"the position alone stays {alone.residual:.3g} m away too")


def test_a_limit_is_told_with_the_value_that_would_be_needed() -> None:
    gough = robot("gough")
    result = gough.inverse_kinematics(Pose(np.array([0.0, 0.0, 2.0]), np.eye(3)))
    assert result.status is IKStatus.LIMIT
    foot, head = (
        (r * np.cos(a), r * np.sin(a)) for r, a in ((0.60, -0.2), (0.40, 0.25 - np.pi / 3))
    )  # of leg A, in the file
    flat = np.hypot(foot[0] - head[0], foot[1] - head[1])
    needed = np.hypot(flat, 2.0 - 0.015) - np.hypot(
        flat, 0.75
    )  # the tool is 0.015 m above the platform's joints
    told = [f"lambda_{leg} ({needed:.4g} m, limit 0.14 m)" for leg in "ABCDEF"]
    assert result.message.startswith(f"reached only beyond the limits of {', '.join(told)};")


@pytest.mark.parametrize(
    ("name", "why"),
    [("delta", "no active joint moves the rotation about x"), ("ankle", "2 active")],
)
def test_a_platform_of_fewer_freedoms_is_not_kept_back_by_limits(name: str, why: str) -> None:
    """The closed form places such a platform as far as it can be placed.

    That is no solution beyond the limits.
    """
    machine = robot(name)
    here = machine.forward_kinematics(machine.close(machine.reference))
    result = machine.inverse_kinematics(Pose(here.position, TILT @ here.rotation))
    assert result.status is IKStatus.OUT_OF_REACH
    assert why in result.message


def test_one_coordinate_that_no_joint_moves_is_named() -> None:
    """Of a target of one coordinate too, where nothing but rounding is left of the Jacobian."""
    delta = robot("delta")
    here = delta.forward_kinematics(delta.close(delta.reference))
    result = delta.inverse_kinematics(
        Pose(here.position, TILT @ here.rotation), mask=[k == 3 for k in range(6)]
    )
    assert result.message.endswith(" away; no active joint moves the rotation about x")


@pytest.mark.parametrize(
    ("name", "axis"), [("excavator", 3), ("forging_chu2020", 4), ("type_c", 3)]
)
def test_one_rotation_alone_is_reached_by_turning_about_another(name: str, axis: int) -> None:
    """A column that turns about z changes which way the pitch joints turn, though it turns about
    neither x nor y.
    """
    machine = robot(name)
    low, high = np.where(np.isfinite(machine.limits), machine.limits, [-np.pi, np.pi]).T
    for share in (0.2, 0.4, 0.6, 0.8):
        state = machine.close(low + share * (high - low))
        mask = [k == axis for k in range(6)]
        found = machine.inverse_kinematics(machine.forward_kinematics(state), mask=mask)
        assert found.status is IKStatus.SOLVED, found.message


@pytest.mark.parametrize("name", ["five_bar", "palletizer", "type_d", "delta"])
def test_a_place_that_only_lies_beyond_a_limit_is_told_with_values_that_reach_it(name: str) -> None:
    machine, rng = robot(name), np.random.default_rng(1)
    ends, limits = machine.closing_range, machine.limits
    lower, upper = (
        np.where(np.isfinite(ends[:, k]), ends[:, k], limits[:, k] + [-0.5, 0.5][k]) for k in (0, 1)
    )
    told = 0
    while told < 4:
        u = rng.uniform(lower, upper)
        state = machine.close(u, check=False)
        if (
            state.status != 0
            or state.singularity < 0.02
            or ((limits[:, 0] <= u) & (u <= limits[:, 1])).all()
        ):
            continue
        result = machine.inverse_kinematics(machine.forward_kinematics(state).position)
        assert result.status in (
            IKStatus.LIMIT,
            IKStatus.SOLVED,
        ), result.message  # another way may be within them
        if result.status is IKStatus.LIMIT:
            told += 1
            for joint, value, limit in re.findall(
                r"(\w+) \((\S+) \w+, limit (\S+) \w+\)", result.message
            ):
                k = machine.active.index(joint)
                side = 0 if float(value) < float(limit) else 1
                assert float(limit) == pytest.approx(
                    limits[k, side], rel=1e-3
                )  # four digits are told


def test_a_pose_of_few_digits_is_reached_within_a_tolerance_and_told_as_it_is_without(
    forging: Robot,
) -> None:
    """Four active joints meet a pose of six coordinates no better than its digits."""
    place = forging.forward_kinematics(
        forging.close(np.add(forging.reference, [0.2, 0.03, 0.02, 0.4]))
    )
    typed = Pose.from_quaternion(np.round(place.position, 6), np.round(place.quaternion, 6))
    result = forging.inverse_kinematics(typed)
    assert result.status is IKStatus.NOT_FOUND
    assert 1e-9 < result.residual < 1e-5
    assert (
        f"the nearest found is {result.position_error:.3g} m and {result.angle_error:.3g} rad"
        in result.message
    )
    assert forging.inverse_kinematics(typed, tolerance=1e-5).status is IKStatus.SOLVED
    for wrong in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match=r"tolerance: .*expected a length above zero"):
            forging.inverse_kinematics(typed, tolerance=wrong)


@pytest.mark.parametrize("rows", [POSITION_ROWS, POSE_ROWS, (0, 2, 5)])
@pytest.mark.parametrize("name", ["forging_chu2020", "excavator", "delta"])
def test_one_start_ends_where_it_ends_among_many(name: str, rows: tuple[int, ...]) -> None:
    machine, rng = robot(name), np.random.default_rng(7)
    lower, upper = machine.limits.T
    half = np.minimum(0.4, 0.3 * (upper - lower))
    for _ in range(4):
        seed, goal = machine.reference + half * rng.uniform(-1.0, 1.0, (2, len(half)))
        try:
            target = machine.forward_kinematics(machine.close(np.clip(goal, lower, upper)))
        except StateError:
            continue
        problem = build_problem(machine, target, rows, seed, None)
        one = problem.descend(seed[None])
        many = problem.descend(np.array([seed, seed]))
        assert problem.solved(one) == problem.solved(many)[0]
        assert one.settled == many.settled[0]
        np.testing.assert_allclose(one.residual, many.residual[:1], atol=1e-9)
        if len(rows) >= len(machine.active):
            np.testing.assert_allclose(one.u, many.u[:1], atol=1e-6)
