"""Staicu (2015), Figures 5 to 10: the robot of two parallel modules, from poses to legs and back.

The reference file holds value, rate and acceleration of every leg variable along the paper's
horizontal example.
"""

from __future__ import annotations

import json
import math
from itertools import combinations
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
    """The horizontal example, with rates and accelerations.

    x = y = 0.05 s, alpha_1 = pi/12 s, with s = 1 - cos(pi t / 3).
    """
    w = math.pi / 3.0
    values = scaled(1.0 - math.cos(w * t))
    rates = scaled(w * math.sin(w * t))
    return values, rates, scaled(w * w * math.cos(w * t))


def scaled(s: float) -> dict[str, float]:
    """The pose of the example at a value of its law."""
    sizes = (0.05, 0.05, 0.0, math.pi / 12.0, 0.0, 0.0)
    return {name: size * s for name, size in zip(POSE, sizes, strict=True)}


def test_coordinates_are_the_papers(robot: Robot) -> None:
    assert robot.active == tuple(f"lambda_{leg}" for leg in "ABCDEF")
    assert set(POSE) < set(robot.passive)
    assert len(robot.coordinates) == 24


@pytest.mark.parametrize("row", REFERENCE["example"], ids=lambda row: f"t={row['t']}")
class TestHorizontalExample:
    def test_legs_from_the_pose(self, robot: Robot, row: dict) -> None:
        """All 18 leg variables with rates and accelerations, Eq. 8 to 17."""
        state = robot.close_given(*law(row["t"]))
        assert state.dds is not None
        assert state.iterations == 0 or state.residual < 1e-14
        for name in set(robot.coordinates) - set(POSE):
            k = robot.coordinates.index(name)
            motion = [state.s[k], state.ds[k], state.dds[k]]
            assert motion == pytest.approx(row[name], abs=TOLERANCE)

    def test_pose_from_the_legs(self, robot: Robot, row: dict) -> None:
        """Forward kinematics of the inverse kinematics, 1e-10."""
        u, du, ddu = np.transpose([row[f"lambda_{leg}"] for leg in "ABCDEF"])
        state = robot.close(u, du)
        dds = robot.accelerations(state, ddu)
        for part, expected in zip((state.s, state.ds, dds), law(row["t"]), strict=True):
            got = [part[robot.coordinates.index(name)] for name in POSE]
            assert got == pytest.approx([expected[name] for name in POSE], abs=1e-10)


def test_platform_pose_is_the_papers(robot: Robot) -> None:
    """R = Rx(alpha_1) Ry(alpha_2) Rz(alpha_3), and the upper centre is h2 over the lower one."""
    geometry = REFERENCE["geometry"]
    values = {"x": 0.04, "y": -0.03, "z": -0.05, "alpha_1": 0.2, "alpha_2": -0.1, "alpha_3": 0.15}
    pose = robot.forward_kinematics(robot.close_given(values))
    height = geometry["h1"] - 0.05 + geometry["h2"]
    assert pose.position == pytest.approx([0.04, -0.03, height], abs=1e-12)
    angles = [values[name] for name in POSE[3:]]
    ca, cb, cc = map(math.cos, angles)
    sa, sb, sc = map(math.sin, angles)
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
    # Two of the lower module, above and below its base, times at least two of the upper one.
    assert len(modes) >= 4
    for first, second in combinations(poses, 2):
        assert np.abs(first - second).max() > 1e-6
    # The mode of the reference comes first.
    assert modes[0].state.s == pytest.approx(robot.close(legs).s, abs=1e-9)
