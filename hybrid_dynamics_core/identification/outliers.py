"""Samples that noise does not explain: outlier tests on studentised residuals, from a robust start.

Cook and Weisberg (1982), Residuals and Influence in Regression, chapter 2: with k values the limit
is the one that the largest of k Gaussian ones stays below in 19 of 20 cases, so that good samples
are hardly ever left out and intervals keep their confidence. The start is Huber's (1964, doi
10.1214/aoms/1177703732), as one bad sample spoils least squares.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.linalg import solve_triangular

from ..ground.arrays import Array

Mask = NDArray[np.bool_]
HUBER = 1.345  # deviations up to which residuals count in full: 95 % efficient with Gaussian noise
STEPS = 8  # of the robust start
ROUNDS = 20  # of leaving out and taking back
CASES = 0.05  # share of clean recordings in which a good sample is left out
LEAST_FREE = 1e-9  # 1 - leverage of an equation that alone tells a parameter: rounding is below


def noise_limit(count: int) -> float:
    """How many deviations the largest of `count` Gaussian values stays within, in 19 of 20 cases."""
    return float(stats.norm.isf(0.5 * CASES / max(count, 1)))


def robust_deviation(values: Array) -> Array:
    """Standard deviation of Gaussian values about zero (N, n), by the median of their sizes: (n,)."""
    return np.asarray(np.median(np.abs(values), axis=0) / stats.norm.ppf(0.75))


def outlying_samples(columns: Array, target: Array, floor: Array) -> Mask:
    """Which of N samples are further from `columns` beta = `target` in some joint than noise explains: (N,).

    Args:
        columns: (N, n, b), of full rank.
        target: (N, n).
        floor: (n,) least deviation of each joint's noise, in units of the target.
    """
    limit, weights, found = noise_limit(target.size), np.ones_like(target), target
    scale = np.maximum(robust_deviation(target), floor)
    for _ in range(STEPS):
        found = _studentised(columns, target, weights / scale, scale)
        scale = np.maximum(scale * robust_deviation(found), floor)
        weights = np.minimum(1.0, HUBER / np.maximum(np.abs(found), HUBER))
    out = (np.abs(found) > limit).any(axis=1)
    for _ in range(ROUNDS):
        found = _studentised(columns, target, np.where(out, 0.0, 1.0)[:, None] / scale, scale)
        scale = np.maximum(scale * robust_deviation(found[~out]), floor)
        before, out = out, (np.abs(found) > limit).any(axis=1)
        if (out == before).all():
            break
    return np.asarray(out)


def _studentised(columns: Array, target: Array, weights: Array, scale: Array) -> Array:
    """How far each equation is from the fit to the others, in deviations of that if noise has the `scale`, (N, n).

    From the residual r of the whole fit: with the weight w and the leverage h of the equation at a
    weight of one, it is r / (1 - w^2 h) from the fit to the others, which has the variance 1 + h /
    (1 - w^2 h).
    """
    size = columns.shape[-1]
    matrix = (columns * weights[..., None]).reshape(-1, size)
    lengths = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    whole = np.asarray(
        np.linalg.qr(np.column_stack([matrix / lengths, (target * weights).ravel()]), mode="r")
    )
    triangle, image = whole[:size, :size], whole[:size, size]
    beta = solve_triangular(triangle, image) / lengths
    rows = (columns / scale[:, None]).reshape(-1, size) / lengths
    leverage = (
        np.square(solve_triangular(triangle, rows.T, trans="T")).sum(axis=0).reshape(target.shape)
    )
    free = np.maximum(1.0 - np.square(weights * scale) * leverage, LEAST_FREE)
    return np.asarray((target - columns @ beta) / scale / np.sqrt(free * (free + leverage)))
