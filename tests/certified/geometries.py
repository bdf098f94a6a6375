"""Random legs between two bodies, at a pose where they close."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core.certified.interval import Interval
from hybrid_dynamics_core.certified.platforms.platform import (
    LegIntervals,
    PlatformPoses,
    platform_poses,
)
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


def random_planar_legs(rng: np.random.Generator, number: int) -> tuple[np.ndarray, ...]:
    """Feet, tips and squared lengths (N, 3) that fit the place and exp(i theta) (N, 1) after."""

    def points(*shape: int) -> np.ndarray:
        return rng.uniform(-1.0, 1.0, shape) + 1j * rng.uniform(-1.0, 1.0, shape)

    feet, tips, place = points(number, 3), 0.7 * points(number, 3), points(number, 1)
    turn = np.exp(1j * rng.uniform(-np.pi, np.pi, (number, 1)))
    return feet, tips, np.abs(place + tips * turn - feet) ** 2, place, turn
