"""All orientations of a platform that three legs turn about a fixed point.

With the quaternion e of the orientation, each leg is a quadric in three dimensions. By Bezout's
theorem three of them meet in eight points at most, if in finitely many. The homotopy begins with
the eight points (1, +-1, +-1, +-1).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .certificates import System, certify, chosen
from .paths import PathTracker, polished
from .platform import LegIntervals, PlatformPoses, entry_radii, verdict
from .start_system import distinct
from .study import Complex, Legs, pose, turning

LEGS = 3
MOST = 8  # orientations, by Bezout's theorem
_TOLERANCES = (1e-6, 1e-8)  # of the tracker, attempt by attempt


class _Start(NamedTuple):
    """Three quadrics with their eight solutions."""

    matrices: Complex
    points: Complex


def orientations(legs: LegIntervals) -> PlatformPoses:
    """All orientations of a platform on three legs, feet and tips (3, 3) about the fixed point."""
    sizes = (legs.feet.magnitude.max(), legs.tips.magnitude.max())
    scale = 2.0 ** -np.ceil(np.log2(max(sizes)))  # a power of two changes no digits
    feet, tips = legs.feet * scale, legs.tips * scale
    squares = legs.squares * scale**2
    matrices = turning(Legs(feet.middle, tips.middle, squares.middle)).real
    system = System(matrices, entry_radii(feet, tips, squares))
    points = np.zeros((0, 4), dtype=complex)
    for number, tolerance in enumerate(_TOLERANCES):
        ends = _ends(_start(number), system, tolerance)
        points = np.concatenate([points, ends])
        if len(points):
            points = distinct(points)
        if len(points) >= MOST:
            break
    balls = certify(system, points)
    balls = chosen(balls, balls.certified)
    complete, reason = verdict(balls, MOST)
    real = balls.centres[balls.real].real
    still = np.zeros_like(real)
    turns = [pose(point)[0] for point in np.concatenate([real, still], axis=1)]
    rotations = np.reshape(turns, (len(real), 3, 3))
    return PlatformPoses(rotations, np.zeros((len(real), 3)), complete, reason)


def _ends(start: _Start, system: System, tolerance: float) -> Complex:
    last = system.matrices
    middle = 0.5 * (start.matrices + last)
    ends = PathTracker(start.matrices, middle, last, tolerance).ends(start.points)
    arrived = ends.points[ends.arrived]
    if len(arrived):
        arrived = polished(last, arrived)
    exact: Complex = arrived[np.isfinite(arrived).all(axis=1)]
    return exact


def _start(number: int) -> _Start:
    """Random multiples of x^2 - w^2, y^2 - w^2 and z^2 - w^2, in random coordinates."""
    random = np.random.default_rng(number)
    parts = random.normal(size=(2, 4, 4))
    change = parts[0] + 1j * parts[1]
    factors = np.exp(2j * np.pi * random.uniform(size=LEGS))
    matrices = np.zeros((LEGS, 4, 4), dtype=complex)
    for k in range(LEGS):
        square = np.diag(np.eye(4)[k + 1] - np.eye(4)[0])
        matrices[k] = factors[k] * change.T @ square @ change
    signs = 1.0 - 2.0 * np.indices((2, 2, 2)).reshape(3, -1).T
    corners = np.concatenate([np.ones((MOST, 1)), signs], axis=1)
    points = np.linalg.solve(change, corners.T).T
    return _Start(matrices, points)
