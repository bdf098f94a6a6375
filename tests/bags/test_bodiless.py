"""Errors of stamps that look like parameters: what no bodies can have is not offered."""

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
from hybrid_dynamics_ros.bags.analysis.identify import identify_recording
from hybrid_dynamics_ros.bags.make import write_trajectory
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory
from hybrid_dynamics_ros.messages.joint_samples import FloatArray

SECONDS, RATE, NOISE = 20.0, 50.0, 20.0
JITTER = 1e-4  # [s] of the stamps, as of a program that stamps after computing


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sines a joint and their efforts, sampled a little beside their stamps.

    Noise in the efforts.
    """
    robot, rng = load("excavator"), np.random.default_rng(0)
    n, time = len(robot.active), np.arange(round(SECONDS * RATE)) / RATE
    late = time + rng.normal(0.0, JITTER, len(time))
    lower, upper = robot.limits.T
    half = 0.9 * np.minimum(np.minimum(upper - robot.reference, robot.reference - lower), 1.0)
    w = rng.uniform(0.5, 3.0, (2, n))

    def motion(at: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        angle = w[:, None] * at[:, None]
        parts = np.sin(angle), w[:, None] * np.cos(angle), -(w[:, None] ** 2) * np.sin(angle)
        position, velocity, acceleration = (0.5 * half * part.sum(axis=0) for part in parts)
        return robot.reference + position, velocity, acceleration

    u, du, ddu = motion(late)
    efforts = robot.inverse_dynamics(robot.close(u, du), ddu) + rng.normal(
        0.0, NOISE, (len(time), n)
    )
    path = tmp_path_factory.mktemp("bodiless") / "rec"
    write_trajectory(
        path, Trajectory(robot.active, time, u, du, efforts), "/js", {"robot": "excavator"}
    )
    return path


@pytest.fixture(scope="module")
def found(bag: Path) -> IdentificationResult:
    return identify_recording(collect(bag, smooth="spline"))


def test_what_no_bodies_can_have_is_not_determined(found: IdentificationResult) -> None:
    """It is sure of itself, and wrong: the efforts are those of the file."""
    off = np.abs(found.identification.estimate - found.file_values) / found.identification.deviation
    by_name = dict(zip(found.identification.base.names, off, strict=True))
    limit = noise_limit(len(off))
    assert len(found.unphysical) >= 3
    assert not set(found.unphysical) & set(found.determined)
    assert all(by_name[name] > 0.9 * limit for name in found.unphysical)
    assert len(found.determined) >= 10
    assert max(by_name[name] for name in found.determined) < limit


def test_the_physical_values_are_nearer_to_the_truth(found: IdentificationResult) -> None:
    names = found.identification.base.names
    estimate, physical = (
        np.abs(found.identification.estimate - found.file_values),
        np.abs(found.physical - found.file_values),
    )
    for name in found.unphysical:
        assert physical[names.index(name)] < 0.1 * estimate[names.index(name)]


def test_the_command_says_so(bag: Path, found: IdentificationResult) -> None:
    said = " ".join(CliRunner().invoke(app, ["bag", "identify", str(bag)]).stdout.split())
    assert (
        f"{len(found.unphysical)} more would be, but no bodies with positive masses can have them"
        in said
    )
    told = json.loads(CliRunner().invoke(app, ["bag", "identify", str(bag), "--json"]).stdout)
    assert told["bodiless"] == list(found.unphysical)
    assert told["base"][found.unphysical[0]]["physical"] == pytest.approx(
        found.physical[found.identification.base.names.index(found.unphysical[0])]
    )
