"""Random legs between two bodies, at a pose where they close."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core.certified.interval import Interval
from hybrid_dynamics_core.certified.platform import LegIntervals, PlatformPoses, platform_poses
from tests.generated.assembly import turn, unit


def random_turn(rng: np.random.Generator) -> np.ndarray:
    return turn(unit(rng.normal(size=3)), rng.uniform(-np.pi, np.pi))


def random_legs(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Feet and tips (6, 3), and lengths (6,) that fit some pose."""
    feet = rng.uniform(-1.0, 1.0, (6, 3))
    tips = rng.uniform(-0.7, 0.7, (6, 3))
    place = rng.uniform(-1.0, 1.0, 3)
    return feet, tips, np.linalg.norm(place + tips @ random_turn(rng).T - feet, axis=1)


def solved(feet: np.ndarray, tips: np.ndarray, lengths: np.ndarray) -> PlatformPoses:
    length = Interval(lengths)
    return platform_poses(LegIntervals(Interval(feet), Interval(tips), length * length))
