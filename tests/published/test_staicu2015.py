"""Staicu (2015), Figures 5 to 10: the robot of two parallel modules, from poses to legs and back.

The reference file holds value, rate and acceleration of every leg variable along the paper's
horizontal example.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, load

REFERENCE = json.loads((Path(__file__).parent / "staicu2015.json").read_text(encoding="utf-8"))
POSE = ("x", "y", "z", "alpha_1", "alpha_2", "alpha_3")
TOLERANCE = 1e-12  # the reference is given in full double precision


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("staicu2015")


def law(t: float) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """The horizontal example: x = y = 0.05 s, alpha_1 = pi/12 s, s = 1 - cos(pi t / 3); rates; accelerations."""
    w = math.pi / 3.0
    sizes = {
        "x": 0.05,
        "y": 0.05,
        "z": 0.0,
        "alpha_1": math.pi / 12.0,
        "alpha_2": 0.0,
        "alpha_3": 0.0,
    }
    laws = (1.0 - math.cos(w * t), w * math.sin(w * t), w * w * math.cos(w * t))
    values, rates, accelerations = ({name: size * s for name, size in sizes.items()} for s in laws)
    return values, rates, accelerations


def test_coordinates_are_the_papers(robot: Robot) -> None:
    assert robot.active == tuple(f"lambda_{leg}" for leg in "ABCDEF")
    assert set(POSE) < set(robot.passive)
    assert len(robot.coordinates) == 24


@pytest.mark.parametrize("row", REFERENCE["example"], ids=lambda row: f"t={row['t']}")
class TestHorizontalExample:
    def test_legs_from_the_pose(self, robot: Robot, row: dict) -> None:
        """Eq. 8 to 17: all 18 leg variables with rates and accelerations."""
        state = robot.close_given(*law(row["t"]))
        assert state.dds is not None
        assert state.iterations == 0 or state.residual < 1e-14
        for name in set(robot.coordinates) - set(POSE):
            k = robot.coordinates.index(name)
            assert [state.s[k], state.ds[k], state.dds[k]] == pytest.approx(
                row[name], abs=TOLERANCE
            )

    def test_pose_from_the_legs(self, robot: Robot, row: dict) -> None:
        """Forward kinematics of the inverse kinematics, 1e-10."""
        names = [f"lambda_{leg}" for leg in "ABCDEF"]
        state = robot.close([row[name][0] for name in names], [row[name][1] for name in names])
        dds = robot.accelerations(state, [row[name][2] for name in names])
        for part, expected in zip((state.s, state.ds, dds), law(row["t"]), strict=True):
            got = [part[robot.coordinates.index(name)] for name in POSE]
            assert got == pytest.approx([expected[name] for name in POSE], abs=1e-10)


def test_platform_pose_is_the_papers(robot: Robot) -> None:
    """R = Rx(alpha_1)

    Ry(alpha_2) Rz(alpha_3); the upper platform's centre is h2 over the lower one's.
    """
    geometry = REFERENCE["geometry"]
    values = {"x": 0.04, "y": -0.03, "z": -0.05, "alpha_1": 0.2, "alpha_2": -0.1, "alpha_3": 0.15}
    pose = robot.forward_kinematics(robot.close_given(values))
    assert pose.position == pytest.approx(
        [0.04, -0.03, geometry["h1"] - 0.05 + geometry["h2"]], abs=1e-12
    )
    (ca, sa), (cb, sb), (cc, sc) = ((math.cos(values[n]), math.sin(values[n])) for n in POSE[3:])
    about_x = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    about_y = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    about_z = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
    assert pose.rotation == pytest.approx(about_x @ about_y @ about_z, abs=1e-12)


def test_all_assembly_modes_close_with_the_same_legs(robot: Robot) -> None:
    legs = [0.01, -0.02, 0.015, 0.03, -0.02, 0.01]
    modes = robot.assembly_modes(legs)
    poses = []
    for mode in modes:
        assert mode.state.residual < 1e-13
        assert mode.state.u == pytest.approx(legs, abs=0)
        pose = robot.forward_kinematics(mode.state)
        poses.append(np.concatenate([pose.position, pose.rotation.ravel()]))
    assert (
        len(modes) >= 4
    )  # two of the lower module, above and below its base, times at least two of the upper one
    gaps = [np.abs(a - b).max() for i, a in enumerate(poses) for b in poses[:i]]
    assert min(gaps) > 1e-6
    assert modes[0].state.s == pytest.approx(
        robot.close(legs).s, abs=1e-9
    )  # the reference's own mode comes first
