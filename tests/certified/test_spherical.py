"""Platforms that three legs turn about a fixed point: all orientations, against elimination."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.certified.interval import Interval
from hybrid_dynamics_core.certified.platforms.platform import LegIntervals
from hybrid_dynamics_core.certified.platforms.spherical import orientations
from tests.certified.geometries import random_turn
from tests.hard_cases.quadrics import rotations_at_distances
from tests.sampling import swept


@pytest.mark.parametrize("seed", swept(range(30), range(4)))
def test_orientations_are_those_of_elimination(seed: int) -> None:
    rng = np.random.default_rng(seed)
    feet, tips = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    lengths = np.linalg.norm(tips @ random_turn(rng).T - feet, axis=1)
    length = Interval(lengths)
    poses = orientations(LegIntervals(Interval(feet), Interval(tips), length * length))
    assert poses.complete, poses.reason
    expected = np.array(rotations_at_distances(feet, tips, lengths))
    apart = np.abs(poses.rotations[:, None] - expected).max(axis=(2, 3))
    assert apart.shape == (len(expected), len(expected))
    assert (apart < 1e-6).sum(axis=0).tolist() == [1] * len(expected)
    assert not poses.origins.any()


def test_two_equal_legs_leave_a_freedom_and_prove_nothing() -> None:
    """Two legs between the same points: the third equation says nothing new."""
    rng = np.random.default_rng(1)
    feet, tips = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    feet[1], tips[1] = feet[0], tips[0]
    length = Interval(np.linalg.norm(tips - feet, axis=1))
    poses = orientations(LegIntervals(Interval(feet), Interval(tips), length * length))
    assert not poses.complete
