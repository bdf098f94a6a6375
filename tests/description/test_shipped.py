"""Every shipped robot closes at its reference, moves as it says, and has mass where it moves."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.formats import read_description
from tests.description.oracle import (
    close,
    frame_pose,
    freedom,
    gaps,
    jacobian,
    link_pose,
    mass_matrix,
)
from tests.sampling import swept

FOLDER = Path(str(resources.files("hybrid_dynamics_core"))) / "robots"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yaml"))
WITHOUT_MASS = {"staicu2015"}  # the paper gives none
CLOSED = 1e-12  # [m]
STEPS = 12


def robot_of(name: str) -> RobotDescription:
    return read_description(FOLDER / f"{name}.yaml")


def reference(robot: RobotDescription) -> dict[str, float]:
    """The closed configuration at the reference's active coordinates."""
    return close(
        robot, {name: robot.reference.get(name, 0.0) for name in robot.active}, robot.reference
    )


def passive(robot: RobotDescription) -> list[str]:
    return [name for name in robot.joints if name not in robot.active]


def box(robot: RobotDescription) -> tuple[np.ndarray, np.ndarray]:
    """Limits of the active joints; 0.05 rad or m about the reference where there are none."""
    limits = np.array([robot.joints[name].limits for name in robot.active])
    middle = np.array([robot.reference.get(name, 0.0) for name in robot.active])
    lower = np.where(np.isfinite(limits[:, 0]), limits[:, 0], middle - 0.05)
    upper = np.where(np.isfinite(limits[:, 1]), limits[:, 1], middle + 0.05)
    return lower, upper


def test_the_class_is_shown() -> None:
    assert {"ankle", "delta", "excavator", "five_bar", "forging_chu2020", "gough"} <= set(NAMES)
    assert {"palletizer", "staicu2015", "type_c", "type_d"} <= set(NAMES)


@pytest.mark.parametrize("name", swept(NAMES))
class TestEveryRobot:
    def test_says_where_its_numbers_come_from(self, name: str) -> None:
        robot = robot_of(name)
        assert robot.name == name
        assert "assumed" in robot.source or "20" in robot.source  # or the year of a paper
        assert robot.notes == ()  # nothing had to be guessed

    def test_closes_at_its_reference(self, name: str) -> None:
        robot = robot_of(name)
        assert set(robot.reference) == set(robot.joints)
        s = reference(robot)
        assert np.abs(gaps(robot, s)).max() < CLOSED
        for joint, value in robot.reference.items():
            assert s[joint] == pytest.approx(value, abs=2e-3), joint  # printed with three digits

    def test_active_joints_determine_all_others(self, name: str) -> None:
        robot = robot_of(name)
        s = reference(robot)
        assert freedom(robot, s) == len(robot.active)
        singular = np.linalg.svd(jacobian(robot, s, passive(robot)), compute_uv=False)
        assert singular[-1] > 0.02 * singular[0]  # far from singular, where rates would be large

    def test_closes_throughout_its_limits(self, name: str) -> None:
        robot = robot_of(name)
        lower, upper = box(robot)
        home = np.array([robot.reference.get(joint, 0.0) for joint in robot.active])
        assert np.all(lower <= home)
        assert np.all(home <= upper)
        for part in np.random.default_rng(7).random((4, len(home))):
            s = reference(robot)
            for k in range(1, STEPS + 1):
                u = home + (lower + part * (upper - lower) - home) * k / STEPS
                s = close(robot, dict(zip(robot.active, u.tolist(), strict=True)), s)
                assert np.abs(gaps(robot, s)).max() < CLOSED
            for joint, value in s.items():
                low, high = robot.joints[joint].limits
                assert low - 1e-9 <= value <= high + 1e-9, joint

    def test_every_active_joint_moves_mass(self, name: str) -> None:
        """The minimal mass matrix at the reference is positive definite."""
        if name in WITHOUT_MASS:
            pytest.skip("no masses given")
        robot = robot_of(name)
        s, names = reference(robot), [*robot.active, *passive(robot)]
        both = jacobian(robot, s, names)
        n = len(robot.active)
        lower = -np.linalg.lstsq(both[:, n:], both[:, :n], rcond=1e-8)[0]
        motion = np.vstack([np.eye(n), lower])
        minimal = motion.T @ mass_matrix(robot, s, names) @ motion
        size = np.sqrt(np.diag(minimal))
        assert np.linalg.eigvalsh(minimal / np.outer(size, size))[0] > 1e-3

    def test_limits_of_all_active_joints_are_given(self, name: str) -> None:
        if name in ("forging_chu2020", "staicu2015"):
            pytest.skip("the papers give none")
        robot = robot_of(name)
        for joint in robot.active:
            assert all(math.isfinite(limit) for limit in robot.joints[joint].limits), joint


def test_palletizer_keeps_its_hand_level() -> None:
    robot = robot_of("palletizer")
    s = reference(robot)
    for q2, q3 in ((1.2, -0.8), (1.8, 0.2), (0.8, -0.5)):
        s = close(robot, {"q1": 0.4, "q2": q2, "q3": q3, "q4": 0.0}, s)
        assert frame_pose(robot, "end_effector", s)[:3, 2] == pytest.approx([0, 0, -1], abs=1e-12)
        assert s["p2"] == pytest.approx(q3 - q2, abs=1e-12)  # q3 is the pitch of the forearm


def test_type_c_tip_keeps_its_height() -> None:
    robot = robot_of("type_c")
    s, heights, reach = reference(robot), [], []
    for q2 in np.linspace(0.85, 1.35, 21):
        s = close(robot, {"q1": 0.0, "q2": float(q2), "q4": 0.0}, s)
        tip = link_pose(robot, "gripper", s)[:3, 3]
        heights.append(tip[2])
        reach.append(tip[0])
    assert np.ptp(heights) < 0.008
    assert np.ptp(reach) > 0.9


def test_delta_and_ankle_move_as_said() -> None:
    robot = robot_of("delta")
    s = close(robot, {f"theta_{leg}": 0.7 for leg in "ABC"} | {"q4": 0.0}, reference(robot))
    assert frame_pose(robot, "end_effector", s)[:3, :3] == pytest.approx(np.eye(3), abs=1e-14)
    assert s["z"] < -0.05  # arms down, platform down
    robot = robot_of("ankle")
    both = close(robot, {"q_L": 0.2, "q_R": 0.2}, {})
    assert both["roll"] == pytest.approx(0.0, abs=1e-12)
    against = close(robot, {"q_L": 0.2, "q_R": -0.2}, {})
    assert abs(against["roll"]) > 10 * abs(against["pitch"])


def test_excavator_bucket_curls_when_its_cylinder_extends() -> None:
    robot = robot_of("excavator")
    s = reference(robot)
    given = {name: s[name] for name in robot.active}
    out, curled = (close(robot, {**given, "bucket_cylinder": stroke}, s) for stroke in (0.5, 0.7))
    assert curled["bucket_pitch"] < out["bucket_pitch"] - 0.2
    assert curled["stick_pitch"] == pytest.approx(out["stick_pitch"])
