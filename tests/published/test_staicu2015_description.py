"""Staicu (2015): every leg of the described robot closes at the published joint values.

The file beside this test gives the inverse kinematics of the paper's horizontal example; see its
`about`.
"""

from __future__ import annotations

import json
from importlib import resources
from math import cos, pi
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.formats import read_description
from tests.description.oracle import close, frame_pose, freedom, gap, jacobian, link_pose

REFERENCE = json.loads((Path(__file__).parent / "staicu2015.json").read_text(encoding="utf-8"))
ROWS = REFERENCE["example"]
JOINTS = [f"{joint}_{leg}" for leg in "ABCDEF" for joint in ("lambda", "phi10", "phi21")]
POSES = ["x", "y", "z", "alpha_1", "alpha_2", "alpha_3"]
TOLERANCE = 1e-12  # [m]: what the reference values are computed to, times lengths of order 1 m


@pytest.fixture(scope="module")
def robot() -> RobotDescription:
    package = Path(str(resources.files("hybrid_dynamics_core")))
    return read_description(package / "robots" / "staicu2015.yaml")


def pose(t: float) -> dict[str, float]:
    """The example's motion law, relative to the central configuration."""
    s = 1.0 - cos(pi * t / 3.0)
    return {
        "x": 0.05 * s,
        "y": 0.05 * s,
        "z": 0.0,
        "alpha_1": pi / 12.0 * s,
        "alpha_2": 0.0,
        "alpha_3": 0.0,
    }


def values(row: dict) -> dict[str, float]:
    return {**{name: row[name][0] for name in JOINTS}, **pose(row["t"])}


def test_coordinates_are_the_papers(robot: RobotDescription) -> None:
    assert sorted(robot.joints) == sorted(JOINTS + POSES)
    assert robot.active == tuple(f"lambda_{leg}" for leg in "ABCDEF")
    assert all(robot.joints[f"lambda_{leg}"].type == "prismatic" for leg in "ABCDEF")
    assert len(robot.closures) == 6
    assert {closure.kind for closure in robot.closures} == {"point"}
    assert freedom(robot, {}) == 6  # 24 coordinates less 18 equations


def test_central_configuration_is_closed_at_zero(robot: RobotDescription) -> None:
    assert set(robot.reference) == set(robot.joints)
    assert not any(robot.reference.values())
    for closure in robot.closures:
        assert np.abs(gap(robot, closure, {})).max() < TOLERANCE
    geometry = REFERENCE["geometry"]
    assert link_pose(robot, "lower_platform", {})[:3, 3] == pytest.approx([0, 0, geometry["h1"]])
    tip = frame_pose(robot, "end_effector", {})[:3, 3]
    assert tip == pytest.approx([0, 0, geometry["h1"] + geometry["h2"]])


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"t={row['t']}")
def test_all_legs_close_at_the_published_values(robot: RobotDescription, row: dict) -> None:
    for closure in robot.closures:
        assert np.abs(gap(robot, closure, values(row))).max() < TOLERANCE, closure.name


@pytest.mark.parametrize("row", ROWS[1::4], ids=lambda row: f"t={row['t']}")
def test_inverse_kinematics_gives_the_published_values(robot: RobotDescription, row: dict) -> None:
    solution = close(robot, pose(row["t"]), {})
    for name in JOINTS:
        assert solution[name] == pytest.approx(row[name][0], abs=1e-11), name


@pytest.mark.parametrize("row", ROWS[1::4], ids=lambda row: f"t={row['t']}")
def test_published_rates_satisfy_the_derivative_of_the_closures(
    robot: RobotDescription, row: dict
) -> None:
    h = 1e-6
    ahead = pose(row["t"] + h)
    behind = pose(row["t"] - h)
    joint_rates = [row[name][1] for name in JOINTS]
    pose_rates = [(ahead[name] - behind[name]) / (2 * h) for name in POSES]
    slip = jacobian(robot, values(row), [*JOINTS, *POSES]) @ [*joint_rates, *pose_rates]
    assert np.abs(slip).max() < 1e-8  # central differences of step 1e-7 and 1e-6
