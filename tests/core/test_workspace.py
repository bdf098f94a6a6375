"""The workspace by samples, against geometry that can be written down: the planar five-bar."""

from __future__ import annotations

import math
from importlib import resources

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, SampleStatus, Workspace, load
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kinematics import workspace
from hybrid_dynamics_core.kinematics.sampling import halton_samples, sampled_ranges
from hybrid_dynamics_core.kinematics.workspace import find_workspace, margins_at

FILE = (
    resources.files("hybrid_dynamics_core")
    .joinpath("robots/five_bar.yaml")
    .read_text(encoding="utf-8")
)
HALF, CRANK, BAR = 0.06, 0.18, 0.24  # of the five-bar's file [m]
PASSIVE = (
    "p_L: {type: revolute, parent: crank_L, child: bar_L, origin: {xyz: [crank, 0, 0]}, axis: z"
)


@pytest.fixture(scope="module")
def five_bar() -> Robot:
    return load("five_bar")


@pytest.fixture(scope="module")
def found(five_bar: Robot) -> Workspace:
    return five_bar.workspace(20_000)


def elbows(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N, 2) ends of both cranks."""
    left = np.stack([-HALF + CRANK * np.cos(u[:, 0]), CRANK * np.sin(u[:, 0])], axis=1)
    return left, np.stack([HALF + CRANK * np.cos(u[:, 1]), CRANK * np.sin(u[:, 1])], axis=1)


def tips(u: np.ndarray) -> np.ndarray:
    """(N, 2) where the bars meet, on the far side of the motors; NaN where they do not."""
    left, right = elbows(u)
    apart = np.linalg.norm(right - left, axis=1)
    with np.errstate(invalid="ignore"):
        height = np.sqrt(BAR**2 - (0.5 * apart) ** 2)
    along = (right - left) / apart[:, None]
    return 0.5 * (left + right) + height[:, None] * np.stack([-along[:, 1], along[:, 0]], axis=1)


def test_samples_are_where_the_bars_meet(found: Workspace) -> None:
    samples = found.samples
    assert samples.reachable.all()
    assert samples.position[:, :2] == pytest.approx(tips(samples.u), abs=1e-12)  # rounding
    assert found.share() == 1.0


def test_extents_are_those_of_the_geometry(found: Workspace) -> None:
    """Farthest with both cranks inward, nearest with both outward.

    The search ends within 2e-5 of the ranges.
    """
    far, near = tips(np.array([[1.45, 1.69], [2.6, 0.54]]))[:, 1]
    corners = tips(np.array([[1.45, 0.54], [2.6, 1.69]]))[:, 0]
    assert found.extents[1] == pytest.approx([near, far], abs=1e-5)
    assert found.extents[0] == pytest.approx([corners.min(), corners.max()], abs=1e-4)
    assert found.extents[2] == pytest.approx(0.04, abs=1e-12)


def test_the_nearest_singularity_is_where_the_bars_are_straightest(
    found: Workspace, five_bar: Robot
) -> None:
    k = found.nearest
    assert k is not None
    left, right = elbows(found.samples.u)
    spread = np.linalg.norm(right - left, axis=1)
    assert found.samples.u[k, :2] == pytest.approx([1.45, 1.69], abs=1e-4)
    assert (
        spread[k] < spread.min() + 1e-4
    )  # the bars fold towards each other: that is the singularity near here
    assert found.samples.singularity[k] == five_bar.close(found.samples.u[k]).singularity


def test_open_loops_are_told_apart() -> None:
    """With limits taken away, a sample closes exactly where geometry says so."""
    wide = FILE.replace("limits: [1.45, 2.6]", "limits: [0, pi]").replace(
        "limits: [0.54, 1.69]", "limits: [0, pi]"
    )
    robot = Robot(parse_description(wide.replace("bar: 0.24", "bar: 0.20")))
    found = robot.workspace(5_000)
    left, right = elbows(found.samples.u)
    gap = np.linalg.norm(right - left, axis=1)
    clear = (np.abs(gap - 0.40) > 1e-6) & (
        gap > 1e-5
    )  # stretched or folded bars: the sample is singular
    closes = found.samples.reachable
    assert (closes == (gap < 0.40))[clear].all()
    assert (found.samples.status[~closes & clear] == SampleStatus.OPEN).all()
    assert np.isnan(found.samples.position[~closes]).all()
    assert found.share(SampleStatus.OPEN) == (gap[:5_000] > 0.40).mean()
    assert 0.1 < found.share() < 0.99


def test_passive_joints_beyond_their_limits_are_told_apart() -> None:
    assert PASSIVE in FILE
    robot = Robot(parse_description(FILE.replace(PASSIVE, f"{PASSIVE}, limits: [-1.5, -1.2]")))
    found = robot.workspace(2_000)
    turn = robot.close(found.samples.u).s[:, robot.coordinates.index("p_L")]
    beyond = (turn < -1.5) | (turn > -1.2)
    assert (found.samples.status == np.where(beyond, SampleStatus.BEYOND, SampleStatus.OK)).all()
    assert 0 < beyond.sum() < len(beyond)
    assert (found.samples.limit[beyond] < 0.0).all()


def test_margins_to_limits_are_shares_of_half_a_range(five_bar: Robot) -> None:
    middle = np.array([2.025, 1.115, 0.0])
    samples = margins_at(
        five_bar, middle + np.array([[0.0, 0.0, 0.0], [0.2875, 0.0, 0.0], [0.0, 0.6, 0.0]])
    )
    assert samples.limit == pytest.approx([1.0, 0.5, 1.0 - 0.6 / 0.575])
    assert samples.status.tolist() == [SampleStatus.OK, SampleStatus.OK, SampleStatus.BEYOND]
    assert samples.joint[1:].tolist() == [0, 1]


def test_a_robot_without_limits_gets_ranges_that_are_told(forging: Robot) -> None:
    found = forging.workspace(2_000, ranges={"q12": (0.0, 0.5)})
    assert found.assumed == ("q1", "q4")
    assert found.ranges[0] == pytest.approx([-math.pi, math.pi])
    assert found.ranges[1].tolist() == [0.0, 0.5]
    assert found.samples.u[:, 1].min() >= 0.0
    assert found.samples.u[:, 1].max() <= 0.5


def test_other_frames_and_loops_that_are_followed() -> None:
    robot = load("gough")
    found = robot.workspace(300, frame="hexapod_platform")
    state = robot.close(found.samples.u[:5])
    assert found.frame == "hexapod_platform"
    assert found.samples.position[:5] == pytest.approx(
        robot.forward_kinematics(state, "hexapod_platform").position, abs=1e-9
    )


@pytest.mark.parametrize(
    ("ranges", "words"),
    [
        ({"q9": (0.0, 1.0)}, "'q9' is not an active joint; they are q_L, q_R, q_T"),
        ({"q_L": (2.0, 1.5)}, "two rising numbers within its limits"),
        ({"q_L": (1.5, 3.0)}, r"within its limits \[1.45, 2.6\]"),
        ({"q_L": (math.nan, 2.0)}, "two rising numbers"),
    ],
)
def test_wrong_ranges_are_refused(five_bar: Robot, ranges: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        five_bar.workspace(10, ranges=ranges)
    with pytest.raises(InputError, match="expected a whole number of at least 1"):
        five_bar.workspace(0)


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_a_range_may_begin_and_end_at_limits(five_bar: Robot, share: float) -> None:
    lower, upper = five_bar.limits[0]
    ends = lower + share * (upper - lower), upper - share * (upper - lower)
    assert sampled_ranges(five_bar, {"q_L": ends})[0][0].tolist() == list(ends)
    for end in ends:
        with pytest.raises(InputError, match="two rising numbers"):
            sampled_ranges(five_bar, {"q_L": (end, end)})


@pytest.mark.parametrize("ends", [(-math.inf, 0.0), (0.0, math.inf), (-math.inf, math.inf)])
def test_a_range_ends_somewhere_though_the_joint_has_no_limits(
    forging: Robot, ends: tuple[float, float]
) -> None:
    assert np.isinf(forging.limits[0]).all()
    with pytest.raises(InputError, match="two rising numbers"):
        sampled_ranges(forging, {forging.active[0]: ends})


def test_progress_is_shown_where_it_lasts(five_bar: Robot, monkeypatch, capsys) -> None:
    monkeypatch.setattr("hybrid_dynamics_core.ground.progress.PATIENCE", -1.0)
    monkeypatch.setattr("hybrid_dynamics_core.ground.progress.PAUSE", 0.0)
    monkeypatch.setattr(workspace, "_BATCH", 100)
    find_workspace(five_bar, 300, shown=True)
    assert "workspace of five_bar |" in capsys.readouterr().err


def test_further_samples_are_denser_at_the_ends_and_the_others_are_even() -> None:
    """Shares of the outer fifth of a range: of sines, 2 acos(0.8) / pi; of all, a fifth."""
    box = np.array([[1.0, 3.0], [-0.2, 0.4], [5.0, 6.0]])
    samples = halton_samples(box, 3000, 2000)
    middle, half = box.mean(axis=1), np.ptp(box, axis=1) / 2.0
    outside = np.abs(samples - middle) / half > 0.8
    assert outside[:3000].mean(axis=0) == pytest.approx(0.2, abs=0.01)
    assert outside[3000:].mean(axis=0) == pytest.approx(2.0 * math.acos(0.8) / math.pi, abs=0.01)
