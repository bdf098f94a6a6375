"""The submechanisms of HyRoDyn and the clusters of generalized_rbda, beside other engines."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import load

FOLDER = Path(__file__).parents[2] / "examples" / "peers"


@pytest.fixture(scope="module")
def example() -> Any:
    sys.path.insert(0, str(FOLDER))
    try:
        yield importlib.import_module("submechanisms")
    finally:
        sys.path.remove(str(FOLDER))


def test_every_mechanism_has_a_title(example: Any) -> None:
    assert {path.stem for path in FOLDER.glob("*.yaml")} == set(example.TITLES)


def test_pinocchio_finds_the_accelerations_that_were_asked(example: Any) -> None:
    pytest.importorskip("pinocchio")
    for name in example.TITLES:
        robot = load(FOLDER / f"{name}.yaml")
        state, ddu = example.moving(robot)
        tau = robot.inverse_dynamics(state, ddu)
        found = example.with_pinocchio(robot, state, tau)
        # rounding, times the ratio of the heaviest link to the lightest rotor
        assert found == pytest.approx(ddu, abs=1e-10 * np.abs(ddu).max()), name


def test_mujoco_finds_them_as_nearly_as_its_loops_are_stiff(example: Any) -> None:
    pytest.importorskip("mujoco")
    for name in ("four_bar", "spu2_u1", "rotor_2"):
        errors = example.compared(name)["errors"]
        assert errors["mujoco"] < 1e-2  # a part of 1e-4 of each force stays, by `solimp`


def test_tellos_hip_keeps_the_constraint_that_generalized_rbda_writes() -> None:
    """Its implicit constraint of one rod, expanded, with its own numbers."""
    robot = load(FOLDER / "tello_hip.yaml")
    for u in ([0.1, 0.1], [0.4, -0.2], [-0.3, 0.5]):
        at = dict(zip(robot.coordinates, robot.close(u).s, strict=True))
        for motor, side in (("y1", 1.0), ("y2", -1.0)):
            c1, s1 = np.cos(at["q1"]), np.sin(at["q1"])
            c2, s2 = np.cos(at["q2"]), np.sin(at["q2"])
            c, s = np.cos(at[motor]), np.sin(at[motor])
            gap = 57 / 2500 * (s - c1 * s2) - 49 / 5000 * c1 - 8 / 625 * (c * c2 + c1 * s * s2)
            gap += side * (7 / 625 * (s1 * s2 - s * s1) - 399 / 20000 * s1) + 3021 / 160000
            assert abs(gap) < 1e-14


def test_tellos_motors_share_the_knee() -> None:
    robot = load(FOLDER / "tello_knee_ankle.yaml")
    at = dict(zip(robot.coordinates, robot.close([0.6, 0.2]).s, strict=True))
    assert at["knee"] == pytest.approx(0.4, abs=1e-15)
    assert at["turn"] == pytest.approx(1.6, abs=1e-15)


def test_a_line_says_what_is_driven(example: Any) -> None:
    result = example.compared("rrpr")
    text = example.line("rrpr", result)
    assert text.startswith("1-RRPR")
    assert "1 of 3" in text
