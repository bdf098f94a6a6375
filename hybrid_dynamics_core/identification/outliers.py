"""Outlier tests on studentised residuals, from a robust start.

Cook and Weisberg (1982), Residuals and Influence in Regression, chapter 2. Of k Gaussian values,
the largest stays below the limit in 19 of 20 cases. So good samples are rarely left out, and
intervals keep their confidence. The start is the fit of Huber (1964), doi 10.1214/aoms/1177703732,
since one bad sample spoils least squares.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array

Mask = NDArray[np.bool_]
HUBER = 1.345  # deviations up to which residuals have full weight: 95 % efficient on Gaussians
STEPS = 20  # most iterations of the robust start
SETTLED = 0.05  # change of a deviation below which the robust start has converged
ROUNDS = 20  # iterations of removing and restoring samples
CASES = 0.05  # share of clean recordings in which a good sample is left out
TINY = 1e-300  # keeps divisors above zero
# Both are shares of a joint's efforts. Residuals below NEGLIGIBLE do not matter. Errors of
# accelerations and of the model are not white: a joint with little noise shows only these.
NEGLIGIBLE = 1e-3
BETTER = 0.1  # least noise of a joint over the typical one, both as shares of their efforts
LEAST_FREE = 1e-9  # 1 - leverage below which an equation alone determines a parameter


def noise_limit(count: int) -> float:
    """Deviations within which the largest of `count` Gaussian values stays in 19 of 20 cases."""
    from scipy.special import ndtri  # noqa: PLC0415  slow to import

    tail = 0.5 * CASES / max(count, 1)
    return float(-ndtri(tail))


def robust_deviation(values: Array) -> Array:
    """Standard deviation (...) of Gaussian values (N, ...) about zero, by the median of sizes."""
    from scipy.special import ndtri  # noqa: PLC0415  slow to import

    medians = np.median(np.abs(values), axis=0)
    return np.asarray(medians / ndtri(0.75))


def least_deviation(deviation: Array, size: Array, count: int) -> Array:
    """The least noise (n,) by which outliers of each joint are judged.

    Args:
        deviation: (n,) of the residuals.
        size: (n,) deviation of the efforts.
        count: number of values that are compared with `noise_limit`.
    """
    share = deviation / np.maximum(size, TINY)
    typical = float(np.median(share))
    least_share = max(NEGLIGIBLE / noise_limit(count), BETTER * typical)
    return np.asarray(np.maximum(deviation, least_share * size))


def outlying_samples(columns: Array, target: Array, floor: Array) -> Mask:
    """Find samples whose residual of `columns` beta = `target` exceeds the noise in some joint.

    Args:
        columns: (N, n, b), of full rank.
        target: (N, n).
        floor: (n,) least standard deviation of each joint's noise, in units of the target.

    Returns:
        Mask (N,) of outliers.
    """
    limit = noise_limit(target.size)
    size = robust_deviation(target)
    residuals, scale = _robust_fit(columns, target, floor)
    outlying = _beyond(residuals, limit)
    for _ in range(ROUNDS):
        included = np.where(outlying, 0.0, 1.0)
        residuals = _studentised(columns, target, included[:, None] / scale, scale)
        deviation = np.maximum(scale * robust_deviation(residuals[~outlying]), floor)
        scale = least_deviation(deviation, size, target.size)
        before = outlying
        outlying = _beyond(residuals, limit)
        if np.array_equal(outlying, before):
            break
    return outlying


def _beyond(residuals: Array, limit: float) -> Mask:
    """(N,) whether a sample is beyond a limit in some joint."""
    is_beyond = np.abs(residuals) > limit
    return np.asarray(is_beyond.any(axis=1))


def _robust_fit(columns: Array, target: Array, floor: Array) -> tuple[Array, Array]:
    """Studentised residuals (N, n) of Huber's fit, and the deviation of each joint's noise (n,)."""
    weights = np.ones_like(target)
    residuals = target
    size = robust_deviation(target)
    scale = np.maximum(size, floor)
    for _ in range(STEPS):
        residuals = _studentised(columns, target, weights / scale, scale)
        deviation = np.maximum(scale * robust_deviation(residuals), floor)
        before = scale
        scale = least_deviation(deviation, size, target.size)
        sizes = np.maximum(np.abs(residuals), HUBER)
        weights = np.minimum(1.0, HUBER / sizes)
        if (np.abs(scale - before) <= SETTLED * scale).all():
            break
    return residuals, scale


def _studentised(
    columns: Array,
    target: Array,
    weights: Array,
    scale: Array,
) -> Array:
    """Studentised residuals (N, n): of each equation to the fit of all others.

    The noise of each joint has the deviation `scale` (n,). With the residual r of the fit to all
    equations, the weight w of an equation, and its leverage h at weight one, the residual is r / (1
    - w^2 h) with the variance 1 + h / (1 - w^2 h).
    """
    from scipy.linalg import solve_triangular  # noqa: PLC0415  slow to import

    size = columns.shape[-1]
    weighted = columns * weights[..., None]
    matrix = weighted.reshape(-1, size)
    norms = np.linalg.norm(matrix, axis=0)
    lengths = np.maximum(norms, TINY)
    goal = (target * weights).ravel()
    equations = np.column_stack([matrix / lengths, goal])
    reduced = np.asarray(np.linalg.qr(equations, mode="r"))
    triangle = reduced[:size, :size]
    beta = solve_triangular(triangle, reduced[:size, size]) / lengths
    normalised = columns / scale[:, None]
    rows = normalised.reshape(-1, size) / lengths
    whitened = solve_triangular(triangle, rows.T, trans="T")
    leverages = np.square(whitened).sum(axis=0)
    leverage = leverages.reshape(target.shape)
    in_fit = np.square(weights * scale) * leverage
    free = np.maximum(1.0 - in_fit, LEAST_FREE)
    residual = target - columns @ beta
    deviation = np.sqrt(free * (free + leverage))
    return np.asarray(residual / scale / deviation)
