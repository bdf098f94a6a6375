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
LARGE = 1.5  # times Chebyshev's bound
BATCH = 500  # rows at once

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
    for first in range(0, len(shift), BATCH):
        rows = slice(first, first + BATCH)
        parts: list[Ball] = []
        for sensitivity, radius in balls:
            parts.append((sensitivity[rows], radius))
        best[rows] = _farthest(parts, shift[rows])
    return best


def _farthest(balls: Sequence[Ball], shift: Array) -> Array:
    """`farthest` of few rows: from the best directions of a sphere, uphill to a fixed point."""
    count = len(shift)
    directions = np.broadcast_to(_sphere(DIRECTIONS), (count, DIRECTIONS, 3))
    points = _farthest_along(balls, shift, directions)
    along = np.einsum("nak,nak->na", directions, points)
    order = np.argsort(-along, axis=1)
    starts = order[:, :STARTS, None]
    directions = np.take_along_axis(directions, starts, axis=1)
    points = _farthest_along(balls, shift, directions)
    for _ in range(ROUNDS):
        lengths = np.linalg.norm(points, axis=2, keepdims=True)
        directions = points / np.maximum(lengths, TINY)
        points = _farthest_along(balls, shift, directions)
    lengths = np.linalg.norm(points, axis=2)
    chosen = np.argmax(lengths, axis=1)
    best = points[np.arange(count), chosen]
    is_larger = lengths.max(axis=1) > np.linalg.norm(shift, axis=1)
    return np.where(is_larger[:, None], best, shift)


def _farthest_along(balls: Sequence[Ball], shift: Array, directions: Array) -> Array:
    """The point (N, a, 3) of the set that is farthest along each direction (N, a, 3)."""
    count = directions.shape[1]
    points = np.repeat(shift[:, None], count, axis=1)
    for sensitivity, radius in balls:
        gradients = directions @ sensitivity
        lengths = np.linalg.norm(gradients, axis=2, keepdims=True)
        variables = radius * gradients / np.maximum(lengths, TINY)
        points += variables @ np.swapaxes(sensitivity, 1, 2)
    return points


def likely(covariance: Array, shift: Array, confidence: float) -> Array:
    """The size (N,) below which normal errors are with a probability.

    Args:
        covariance: of the errors (N, 3, 3).
        shift: their means (N, 3).
        confidence: the probability, from 0.5 to 1.
    """
    sizes = np.zeros(len(shift))
    for first in range(0, len(shift), BATCH):
        rows = slice(first, first + BATCH)
        errors = _NormalErrors(covariance[rows], shift[rows])
        sizes[rows] = errors.quantile(confidence)
    return sizes


class _NormalErrors:
    """Normal errors: standard ones z, stretched along the axes of their covariance.

    In a direction of z, errors leave a ball at one distance, since its middle is inside. So the
    probability of the ball is the mean over directions of chi's distribution at this distance.
    """

    def __init__(self, covariance: Array, shift: Array) -> None:
        values, vectors = np.linalg.eigh(covariance)
        variances = np.maximum(values, 0.0)
        means = np.einsum("nik,ni->nk", vectors, shift)
        directions, self.weights = _quadrature()
        deviations = np.sqrt(variances)
        stretched = directions * deviations[:, None]
        self.length = np.linalg.norm(shift, axis=1)
        self.deviation = np.sqrt(variances.sum(axis=1))
        # of the equation square d^2 + 2 along d + length^2 = size^2 for the distance d
        self.square = np.einsum("nqk,nqk->nq", stretched, stretched)
        self.along = np.einsum("nqk,nk->nq", stretched, means)

    def quantile(self, confidence: float) -> Array:
        """The size (N,) by bisection; Chebyshev's inequality bounds it."""
        low = self.length
        high = low + LARGE * self.deviation / np.sqrt(1.0 - confidence)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            is_below = self.probability(middle) < confidence
            low = np.where(is_below, middle, low)
            high = np.where(is_below, high, middle)
        sizes: Array = 0.5 * (low + high)
        return sizes

    def probability(self, sizes: Array) -> Array:
        """The probability (N,) of an error below some sizes (N,), no less than the mean's."""
        from scipy.special import gammainc  # noqa: PLC0415  slow to import

        room = sizes**2 - self.length**2
        root = np.sqrt(self.along**2 + self.square * room[:, None])
        distance = room[:, None] / np.maximum(self.along + root, TINY)
        within = gammainc(1.5, 0.5 * distance**2)
        share: Array = within @ self.weights
        return share


def _sphere(count: int) -> Array:
    """Directions (count, 3) that are evenly distributed: a spiral of Fibonacci."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    golden = 1.0 + np.sqrt(5.0)
    return _on_sphere(z, np.pi * golden * k)


def _quadrature() -> tuple[Array, Array]:
    """Directions (q, 3) and weights (q,) of the mean over the sphere."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    turns = (np.arange(NODES) + 0.5) / NODES
    z, angle = np.meshgrid(nodes, 2.0 * np.pi * turns, indexing="ij")
    shares = np.repeat(weights, NODES) / (2.0 * NODES)
    return _on_sphere(z.ravel(), angle.ravel()), shares


def _on_sphere(z: Array, angle: Array) -> Array:
    """Unit vectors (q, 3) from their heights and angles."""
    across = np.sqrt(1.0 - z**2)
    x = across * np.cos(angle)
    y = across * np.sin(angle)
    return np.stack([x, y, z], axis=1)
