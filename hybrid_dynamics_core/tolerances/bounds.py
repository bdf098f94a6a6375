"""The worst and the likely size of an error that is a sum of small independent ones.

Every variable reaches a ball: a number an interval, a pin a circle. The image of these balls, by
the sensitivities, is a convex set; its farthest point is the worst error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..ground.arrays import Array

DIRECTIONS = 800  # on the sphere, from the best of which the search starts
SPACING = 0.1  # [rad] every direction is nearer than this to one of them
STARTS = 12
ROUNDS = 60
TINY = 1e-300
NODES = 24  # of the quadrature, over half a turn
BISECTIONS = 44

Ball = tuple[Array, float]  # sensitivities (N, 3, d), radius


def farthest(balls: Sequence[Ball], shift: Array) -> Array:
    """The largest errors (N, 3) that the variables can add up to.

    The search climbs from the best of `DIRECTIONS`. It never exceeds the truth, and misses it by
    less than 1 - cos(SPACING), 0.5 %, whatever the number of variables.

    Args:
        balls: of each variable, the sensitivities and the radius.
        shift: what adds to them (N, 3).
    """
    best = shift.copy()
    sizes = np.linalg.norm(best, axis=1)
    directions = np.broadcast_to(_sphere(DIRECTIONS), (len(shift), DIRECTIONS, 3))
    reach = np.einsum("nak,nak->na", directions, _farthest_along(balls, shift, directions))
    starts = np.argsort(-reach, axis=1)[:, :STARTS]
    ways = np.take_along_axis(directions, starts[:, :, None], axis=1)
    points = _farthest_along(balls, shift, ways)
    for _ in range(ROUNDS):
        lengths = np.linalg.norm(points, axis=2, keepdims=True)
        points = _farthest_along(balls, shift, points / np.maximum(lengths, TINY))
    lengths = np.linalg.norm(points, axis=2)
    chosen = np.argmax(lengths, axis=1)
    rows = np.arange(len(shift))
    is_larger = lengths[rows, chosen] > sizes
    best[is_larger] = points[rows, chosen][is_larger]
    return best


def _farthest_along(balls: Sequence[Ball], shift: Array, ways: Array) -> Array:
    """The point (N, a, 3) of the set that is farthest along each direction (N, a, 3)."""
    points = np.repeat(shift[:, None], ways.shape[1], axis=1)
    for sensitivity, radius in balls:
        along = ways @ sensitivity
        lengths = np.linalg.norm(along, axis=2, keepdims=True)
        unit = along / np.maximum(lengths, TINY)
        points += radius * (unit @ np.swapaxes(sensitivity, 1, 2))
    return points


def likely(covariance: Array, shift: Array, confidence: float) -> Array:
    """The size (N,) below which normal errors are with a probability.

    The probability of a ball is the mean over directions of chi's distribution with three degrees
    of freedom; its radius is found by bisection.

    Args:
        covariance: of the errors (N, 3, 3).
        shift: their means (N, 3).
        confidence: the probability, from 0.5 to 1.
    """
    from scipy.special import gammainc  # noqa: PLC0415  slow to import

    values, vectors = np.linalg.eigh(covariance)
    roots = np.sqrt(np.maximum(values, 0.0))
    means = np.einsum("nik,ni->nk", vectors, shift)
    directions, weights = _quadrature()
    ways = directions * roots[:, None]
    a = np.einsum("nqk,nqk->nq", ways, ways)
    half_b = np.einsum("nqk,nk->nq", ways, means)
    length = np.linalg.norm(shift, axis=1)
    low = length
    high = length + 10.0 * np.sqrt(values.sum(axis=1).clip(0.0)) / (1.0 - confidence) ** 0.25
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        c = (length**2 - middle**2)[:, None]
        roots_of = np.sqrt(np.maximum(half_b**2 - a * c, 0.0))
        radius = -c / np.maximum(half_b + roots_of, TINY)
        share = gammainc(1.5, 0.5 * radius**2) @ weights
        is_below = share < confidence
        low = np.where(is_below, middle, low)
        high = np.where(is_below, high, middle)
    return np.asarray(0.5 * (low + high))


def _sphere(count: int) -> Array:
    """Directions (count, 3) that are evenly distributed: a spiral of Fibonacci."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


def _quadrature() -> tuple[Array, Array]:
    """Directions (q, 3) and weights (q,) of the mean over the sphere."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    angles = 2.0 * np.pi * (np.arange(NODES) + 0.5) / NODES
    z, angle = np.meshgrid(nodes, angles, indexing="ij")
    across = np.sqrt(1.0 - z**2)
    directions = np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=-1)
    every = np.repeat(weights / (2.0 * NODES), NODES)
    return directions.reshape(-1, 3), every
