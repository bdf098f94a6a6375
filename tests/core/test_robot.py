"""Inputs, refusals and evidence of the robot facade."""

from __future__ import annotations

import copy
import re

import numpy as np
import pytest

from hybrid_dynamics_core import (
    ClosureError,
    ClosureStatus,
    HybridDynamicsError,
    IKStatus,
    InputError,
    Pose,
    Robot,
    SingularityError,
)

U = [0.3, 0.15, 0.175, 0.4]


@pytest.mark.parametrize(
    ("u", "words"),
    [
        ([0.3, 0.15], r"shape \(2,\); expected \(4,\) or \(N, 4\) in the order q1, q12, q22, q4"),
        ([0.3, np.nan, 0.175, 0.4], "q12 is nan"),
        ([0.3, 0.15, np.inf, 0.4], "q22 is inf"),
        ([U, [0.3, 0.15, 0.175, np.nan]], "q4 in row 1 is nan"),
        (
            "0,0,0,0",
            r"u is text \('0,0,0,0'\); expected a list of numbers in the order q1, q12, q22, q4",
        ),
        (
            {"q1": 0},
            (
                "u is values by name; expected a list of numbers in the order q1, q12, q22, q4; .*"
                " for close_given"
            ),
        ),
        ([1j, 0, 0, 0], "not an array of numbers"),
        ([[U]], r"shape \(1, 1, 4\)"),
    ],
)
def test_bad_coordinates_are_refused(forging: Robot, u: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        forging.close(u)  # type: ignore[arg-type]


def test_bad_rates_and_accelerations_are_refused(forging: Robot) -> None:
    with pytest.raises(InputError, match="du: q1 is nan"):
        forging.close(U, [np.nan, 0, 0, 0])
    with pytest.raises(InputError, match=r"du has shape \(1, 4\); expected \(4,\)"):
        forging.close(U, [[0, 0, 0, 0]])
    state = forging.close(U)
    with pytest.raises(InputError, match=r"ddu has shape \(3,\)"):
        forging.inverse_dynamics(state, [0, 0, 0])
    with pytest.raises(InputError, match="expected a ClosedState"):
        forging.inverse_dynamics(U, [0, 0, 0, 0])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "index", "lower", "upper"), [("q12", 1, -0.1, 0.7), ("q22", 2, -0.1, 0.3)]
)
@pytest.mark.parametrize("side", [-1, 1])
def test_cylinder_out_of_reach_names_loop_value_and_range(
    forging: Robot, name: str, index: int, lower: float, upper: float, side: int
) -> None:
    """The ranges are q12 + L11 = L1 -+ (L2 - b2) and q22 + L21 = (L2 - c2) -+ b3, errata sheet."""
    u = np.array(U)
    u[index] = (upper if side > 0 else lower) + side * 0.001
    with pytest.raises(ClosureError) as caught:
        forging.close(u)
    error = caught.value
    assert (error.coordinate, error.value) == (name, u[index])
    assert error.loop == f"theta_{index}"
    assert error.allowed == pytest.approx((lower, upper), abs=1e-12)
    assert name in str(error)
    assert error.loop in str(error)
    assert f"{u[index]:.9g}" in str(error)


@pytest.mark.parametrize("u1", [-0.1, 0.7])
def test_toggle_point_is_singular(forging: Robot, u1: float) -> None:
    with pytest.raises(SingularityError) as caught:
        forging.close([0.0, u1, 0.1, 0.0])
    assert caught.value.loop == "theta_1"
    assert caught.value.distance < 1e-5


def test_limits_are_the_toggle_points(forging: Robot) -> None:
    assert forging.limits[1] == pytest.approx([-0.1, 0.7], abs=1e-12)
    assert forging.limits[2] == pytest.approx([-0.1, 0.3], abs=1e-12)
    assert np.isinf(forging.limits[[0, 3]]).all()


def test_no_answer_far_outside(forging: Robot) -> None:
    for value in (1e300, -1e300, 1e6):
        with pytest.raises(HybridDynamicsError):
            forging.close([0.0, value, 0.1, 0.0])


def test_batch_names_the_first_bad_row(forging: Robot) -> None:
    with pytest.raises(ClosureError, match="row 1: loop 'theta_2'") as caught:
        forging.close([U, [0, 0.1, 0.5, 0], [0, 0.9, 0.1, 0]])
    assert caught.value.index == 1


def test_unchecked_batch_marks_bad_rows(forging: Robot) -> None:
    state = toggle = (
        0.7 - 1e-13
    )  # the end of the stroke to rounding: beyond, the loop does not close
    state = forging.close([U, [0, 0.9, 0.1, 0], [0, toggle, 0.1, 0]], check=False)
    assert list(state.status) == [
        ClosureStatus.OK,
        ClosureStatus.UNREACHABLE,
        ClosureStatus.SINGULAR,
    ]
    assert np.isfinite(state.s[0]).all()
    tau = forging.inverse_dynamics(state, np.zeros((3, 4)))
    for array in (
        state.s,
        state.ds,
        state.R,
        tau,
        forging.jacobian(state),
        forging.minimal_form(state)[0],
    ):
        assert np.isnan(array[1:]).all()
        assert np.isfinite(array[0]).all()


def test_state_carries_its_evidence(forging: Robot) -> None:
    state = forging.close(U)
    assert state.residual < 1e-14
    assert dict(state.branch) == {
        "theta_1": "counterclockwise",
        "theta_2": "counterclockwise",
        "theta_3": "parallelogram",
        "theta_4": "parallelogram",
    }
    assert 0.0 < state.singularity <= 1.0
    assert state.singular_loop in ("theta_1", "theta_2")
    near = forging.close([0.3, 0.699, 0.175, 0.4])
    assert near.singular_loop == "theta_1"
    assert near.singularity < 0.2


def test_parallelograms_are_regular_at_their_change_point(forging: Robot) -> None:
    """ERRATA: as general four-bars J_z is singular at q2 + q3 = 90 degrees.

    As parallelograms it is not.
    """
    low, high = -0.09, 0.29
    for _ in range(60):  # bisect q22 for q2 + q3 = 90 degrees
        middle = 0.5 * (low + high)
        pitch = forging.close([0.0, 0.3, middle, 0.0]).z[:2].sum()
        low, high = (middle, high) if pitch > np.pi / 2 else (low, middle)
    found = forging.close([0.0, 0.3, low, 0.0], [0.0, 0.1, 0.1, 0.0])
    if abs(found.z[:2].sum() - np.pi / 2) > 1e-6:
        pytest.fail(f"the change point is not in range: q2 + q3 = {found.z[:2].sum()}")
    assert found.residual < 1e-14
    assert dict(zip(found.loops, found.distances, strict=True))["theta_4"] == 1.0
    assert np.isfinite(forging.inverse_dynamics(found, np.zeros(4))).all()


def test_frames(forging: Robot) -> None:
    state = forging.close(U)
    tip, link = forging.forward_kinematics(state), forging.forward_kinematics(state, frame="l4")
    assert tip.position == pytest.approx(link.position + link.rotation @ [0.2, 0, 0])
    assert tip.matrix[:3, 3] == pytest.approx(tip.position)
    with pytest.raises(InputError, match="no frame 'l99'"):
        forging.forward_kinematics(state, frame="l99")


class TestInverseKinematics:
    def test_pose(self, forging: Robot) -> None:
        pose = forging.forward_kinematics(forging.close(U))
        result = forging.inverse_kinematics(Pose.from_quaternion(pose.position, pose.quaternion))
        assert result.status is IKStatus.SOLVED
        assert result.u == pytest.approx(U, abs=1e-9)
        assert result.redundant == ()

    def test_all_solutions_are_distinct_and_reach(self, forging: Robot) -> None:
        target = forging.forward_kinematics(forging.close(U)).position
        result = forging.inverse_kinematics(target, all_solutions=True)
        assert len(result.solutions) == 2  # the arm may also reach over its back
        for u in result.solutions:
            assert forging.forward_kinematics(forging.close(u)).position == pytest.approx(
                target, abs=1e-9
            )
            assert (u >= forging.limits[:, 0]).all()
            assert (u <= forging.limits[:, 1]).all()
        assert abs(result.solutions[0][0] - result.solutions[1][0]) == pytest.approx(np.pi)

    @pytest.mark.parametrize(
        "target", [[3.0, 0.0, 0.0], [0.0, 0.0, 2.5], [0.0, 5.0, -5.0], [5.3, 5.0, 6.2]]
    )
    def test_out_of_reach_is_told(self, forging: Robot, target: list[float]) -> None:
        result = forging.inverse_kinematics(target)
        assert result.status in (IKStatus.OUT_OF_REACH, IKStatus.LIMIT)
        assert result.solutions == ()
        assert result.residual > 0.1
        assert "m" in result.message

    def test_pose_that_needs_more_joints(self, forging: Robot) -> None:
        pose = forging.forward_kinematics(forging.close(U))
        tilt = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
        result = forging.inverse_kinematics(Pose(pose.position, tilt @ pose.rotation))
        assert result.status is not IKStatus.SOLVED
        assert "4 active joints" in result.message

    @pytest.mark.parametrize("target", [[np.nan, 0, 0], [1, 2], "here", [[1, 2]]])
    def test_bad_targets_are_refused(self, forging: Robot, target: object) -> None:
        with pytest.raises(InputError):
            forging.inverse_kinematics(target)  # type: ignore[arg-type]

    def test_bad_rotation_is_refused(self, forging: Robot) -> None:
        with pytest.raises(InputError, match="orthonormal"):
            forging.inverse_kinematics(Pose(np.zeros(3), 2.0 * np.eye(3)))
        with pytest.raises(
            InputError, match=r"0, 0, 0, 2 has the norm 2; expected 1 to 0\.001; divide it by 2"
        ):
            Pose.from_quaternion([0, 0, 0], [0, 0, 0, 2])

    def test_masked_target_asks_for_some_coordinates_only(self, forging: Robot) -> None:
        pose = forging.forward_kinematics(forging.close(U))
        lifted = Pose(pose.position + np.array([9.0, 9.0, 0.05]), pose.rotation)
        result = forging.inverse_kinematics(
            lifted, seed=U, mask=[False, False, True, False, False, False]
        )
        assert result.status is IKStatus.SOLVED
        reached = forging.forward_kinematics(forging.close(result.u))
        assert reached.position[2] == pytest.approx(pose.position[2] + 0.05, abs=1e-9)
        assert set(result.redundant) == {"q1", "q4", "q12", "q22"}

    @pytest.mark.parametrize("mask", [[True] * 5, [False] * 6, [False] * 3 + [True] * 3])
    def test_bad_masks_are_refused(self, forging: Robot, mask: list[bool]) -> None:
        with pytest.raises(InputError, match="mask"):
            forging.inverse_kinematics([0.3, 0.3, 1.1], mask=mask)


@pytest.mark.parametrize("what", [10, "10 kg", None])
def test_a_payload_is_refused_where_it_is_given(forging: Robot, what: object) -> None:
    with pytest.raises(
        InputError, match=r"expected a Payload, such as Payload\(10(\.0)?\), got \w+"
    ):
        forging.loads.with_payload(what)  # type: ignore[arg-type]


def test_reactions_name_what_there_is(forging: Robot) -> None:
    reactions = forging.reactions(forging.close(U))
    for there in (reactions, copy.deepcopy(reactions)):
        with pytest.raises(KeyError) as caught:
            there.pins["fourbar"]
        assert isinstance(caught.value, InputError)
        known = ", ".join(there.pins)
        assert re.fullmatch(
            rf"there is no pin 'fourbar'( \(did you mean .*\))?; known: {known}", str(caught.value)
        )
        with pytest.raises(
            KeyError, match=r"there is no joint 'q33' \(did you mean 'q3'\?\); known: q1, "
        ):
            there.joints["q33"]
        assert "fourbar" not in there.pins
        assert there.pins.get("fourbar") is None
