"""Friction that nobody models looks like parameters: what no bodies can have is not offered."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_core import load
from hybrid_dynamics_core.identification import noise_limit
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.identification_result import IdentificationResult
from hybrid_dynamics_ros.bags.analysis.identify import identify_recording, requested_parameters
from hybrid_dynamics_ros.bags.make import write_trajectory
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory

SECONDS, PERIOD, RATE = 20.0, 5.0, 50.0  # [s, s, Hz]
NOISE = 20.0  # [N m or N] of the efforts
LINKS = ("bucket",)
FRICTION = 0.08  # of each joint: deviation of its viscous efforts over that of the others


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A periodic motion, two waves a joint, and its efforts with friction.

    What is held out is a period like the others, so that estimates explain it as well as the file.
    """
    robot, rng = load("excavator"), np.random.default_rng(0)
    n, time = len(robot.active), np.arange(round(SECONDS * RATE)) / RATE
    waves = rng.permuted(np.tile(np.arange(1, 4), (n, 1)), axis=1)[:, :2].T
    w = 2.0 * np.pi / PERIOD * waves[:, None]
    lower, upper = robot.limits.T
    half = 0.9 * np.minimum(np.minimum(upper - robot.reference, robot.reference - lower), 1.0)
    angle = w * time[:, None] + rng.uniform(0.0, 2.0 * np.pi, (2, 1, n))
    parts = np.sin(angle), w * np.cos(angle), -(w**2) * np.sin(angle)
    position, du, ddu = (0.5 * half * part.sum(axis=0) for part in parts)
    u = robot.reference + position
    efforts = robot.inverse_dynamics(robot.close(u, du), ddu)
    efforts += FRICTION * efforts.std(axis=0) * du / du.std(axis=0)
    efforts += rng.normal(0.0, NOISE, efforts.shape)
    path = tmp_path_factory.mktemp("bodiless") / "rec"
    write_trajectory(
        path, Trajectory(robot.active, time, u, du, efforts), "/js", {"robot": "excavator"}
    )
    return path


@pytest.fixture(scope="module")
def found(bag: Path) -> IdentificationResult:
    recording = collect(bag, smooth="spline")
    return identify_recording(recording, requested_parameters(recording.robot, LINKS))


def test_what_no_bodies_can_have_is_not_determined(found: IdentificationResult) -> None:
    """It is sure of itself, and wrong: masses and inertias are those of the file."""
    off = np.abs(found.identification.estimate - found.file_values) / found.identification.deviation
    by_name = dict(zip(found.identification.base.names, off, strict=True))
    limit = noise_limit(len(off))
    assert not found.worse_than_file
    assert len(found.unphysical) >= 2
    assert not set(found.unphysical) & set(found.determined)
    assert all(by_name[name] > 0.9 * limit for name in found.unphysical)
    assert len(found.determined) >= 5


def test_the_physical_values_are_nearer_to_the_truth(found: IdentificationResult) -> None:
    names = found.identification.base.names
    estimate, physical = (
        np.abs(found.identification.estimate - found.file_values),
        np.abs(found.physical - found.file_values),
    )
    for name in found.unphysical:
        assert physical[names.index(name)] < 0.1 * estimate[names.index(name)]


def test_the_command_says_so(bag: Path, found: IdentificationResult) -> None:
    call = ["bag", "identify", str(bag), "--links", *LINKS]
    said = " ".join(CliRunner().invoke(app, call).stdout.split())
    assert (
        f"{len(found.unphysical)} more would be, but no bodies with positive masses can have them"
        in said
    )
    told = json.loads(CliRunner().invoke(app, [*call, "--json"]).stdout)
    assert told["bodiless"] == list(found.unphysical)
    assert told["base"][found.unphysical[0]]["physical"] == pytest.approx(
        found.physical[found.identification.base.names.index(found.unphysical[0])]
    )
