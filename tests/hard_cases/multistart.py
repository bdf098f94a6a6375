"""All poses of a platform on six legs of known length, from thousands of starts at once.

Brute force.
"""

from __future__ import annotations

import numpy as np

from tests.hard_cases.quadrics import rotation


def platform_poses(
    feet: np.ndarray, tips: np.ndarray, lengths: np.ndarray, starts: int, seed: int = 0
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Every (R, t) found with |t + R tips[i] - feet[i]| = lengths[i].

    Feet, tips (6, 3), lengths (6,).

    Newton from random rotations and places, each step a small turn and shift; no step is longer
    than 0.5.
    """
    rng = np.random.default_rng(seed)
    r = np.array([rotation(q) for q in rng.normal(size=(starts, 4))])
    t = rng.uniform(-1.0, 1.0, size=(starts, 3)) * lengths.max()
    for _ in range(60):
        arm = np.einsum("nij,kj->nki", r, tips)
        leg = t[:, None] + arm - feet
        lost = ~(np.abs(t).max(axis=1) < 1e3)
        miss = 0.5 * ((leg**2).sum(axis=2) - lengths**2)
        slope = np.concatenate([leg, np.cross(arm, leg)], axis=2)
        slope[lost | (np.abs(np.linalg.det(slope)) < 1e-12)] = np.eye(6)
        step = -np.linalg.solve(slope, miss[..., None])[..., 0]
        step *= np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        t = t + step[:, :3]
        r = _turns(step[:, 3:]) @ r
    leg = t[:, None] + np.einsum("nij,kj->nki", r, tips) - feet
    closed = np.abs(np.linalg.norm(leg, axis=2) - lengths).max(axis=1) < 1e-10
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for rotated, moved in zip(r[closed], t[closed], strict=True):
        if all(np.abs(rotated - a).max() + np.abs(moved - b).max() > 1e-6 for a, b in found):
            found.append((rotated, moved))
    return found


def _turns(vectors: np.ndarray) -> np.ndarray:
    """Rotations of rotation vectors (n, 3)."""
    angle = np.maximum(np.linalg.norm(vectors, axis=1), 1e-12)[:, None, None]
    x, y, z = vectors.T
    skew = np.zeros((len(vectors), 3, 3))
    skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0] = x, y, z
    skew -= np.transpose(skew, (0, 2, 1))
    return np.eye(3) + np.sin(angle) / angle * skew + (1.0 - np.cos(angle)) / angle**2 * skew @ skew
