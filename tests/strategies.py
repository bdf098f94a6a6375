"""Random states of shipped robots for property tests."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot

NEAR = 0.05  # [m]
# Share of a limited range at both ends that is not used: next to a toggle point rates grow without
# bound.
MARGIN = 0.03


def positions(robot: Robot) -> st.SearchStrategy[np.ndarray]:
    """Active coordinates within the limits.

    Unlimited angles are within a turn, unlimited strokes near the reference.
    """
    turns = np.array([robot.joint_types[name] == "revolute" for name in robot.active])
    half = np.where(turns, np.pi, NEAR)
    lower = np.where(np.isfinite(robot.limits[:, 0]), robot.limits[:, 0], robot.reference - half)
    upper = np.where(np.isfinite(robot.limits[:, 1]), robot.limits[:, 1], robot.reference + half)
    return vectors(lower + MARGIN * (upper - lower), upper - MARGIN * (upper - lower))


def vectors(lower: np.ndarray, upper: np.ndarray) -> st.SearchStrategy[np.ndarray]:
    """Vectors within a box."""
    parts = [st.floats(a, b, allow_nan=False) for a, b in zip(lower, upper, strict=True)]
    return st.tuples(*parts).map(np.array)


def rates(robot: Robot, size: float = 1.0) -> st.SearchStrategy[np.ndarray]:
    """Active rates or accelerations up to `size` [rad/s or m/s, per second]."""
    return vectors(np.full(len(robot.active), -size), np.full(len(robot.active), size))
