"""Least squares with what is known before, noise from the residuals, and honest covariance.

Each unknown has a normal distribution before the measurement; so has each error of the model.
Blocks of a run are correlated where the model is wrong: their noise is increased by it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from ..ground.arrays import Array
from ..identification.outliers import noise_limit

Mask = NDArray[np.bool_]
RUNS = 8  # fits, each with the noise of the one before
PRIOR_SAMPLES = 2.0  # how much the expected noise counts
CORRELATED = (-0.5, 0.8)  # least and largest correlation of neighbours that counts
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class System:
    """Block means of the equations, with what is known before.

    Attributes:
        matrix: (B, k, p).
        target: (B, k).
        mean: (p,) expected unknowns.
        deviation: (p,) their standard deviations.
        floor: (k,) expected noise of a block.
        run: (B,) number of the run of each block.
    """

    matrix: Array
    target: Array
    mean: Array
    deviation: Array
    floor: Array
    run: Array

    def only(self, rows: Mask) -> System:
        """Some of the blocks."""
        parts = (self.matrix[rows], self.target[rows], self.mean, self.deviation, self.floor)
        return System(*parts, self.run[rows])


@dataclass(frozen=True, eq=False)
class Fit:
    """Unknowns after the measurement.

    Attributes:
        values: (p,).
        covariance: (p, p).
        noise: (k,) standard deviation of a block.
        residual: (B, k) target less the fit.
        free: degrees of freedom of the noise.
    """

    values: Array
    covariance: Array
    noise: Array
    residual: Array
    free: float


def fitted(system: System) -> Fit:
    """The fit, with noise from its residuals."""
    normal = NormalEquations(system)
    noise = system.floor
    correlation = np.ones_like(noise)
    free = correlation
    count = len(system.target)
    solution = normal.solved(noise)
    for _ in range(RUNS):
        squares = (solution.residual**2).sum(axis=0)
        free = np.maximum(count - solution.leverage, 0.0)
        expected = PRIOR_SAMPLES * system.floor**2
        noise = np.sqrt((squares + expected) / (free + PRIOR_SAMPLES))
        correlation = _correlation(solution.residual, system.run)
        solution = normal.solved(noise * np.sqrt(correlation))
    degrees = float((free / correlation).sum() + PRIOR_SAMPLES)
    return Fit(solution.values, solution.covariance, noise, solution.residual, max(degrees, 1.0))


def solved(system: System, noise: Array) -> Solution:
    """The fit at a given noise (k,)."""
    return NormalEquations(system).solved(noise)


def unfitting(system: System, fit: Fit) -> Mask:
    """Mask (B,) of blocks whose residuals are no noise."""
    limit = noise_limit(system.target.size)
    size = np.abs(fit.residual) / fit.noise
    return np.asarray((size > limit).any(axis=1))


@dataclass(frozen=True, eq=False)
class Solution:
    """Unknowns at a given noise.

    Attributes:
        values: (p,).
        covariance: (p, p).
        residual: (B, k) target less the fit.
        leverage: (k,) how many equations of each drive determine unknowns.
        cost: weighted squares of the residuals and of the unknowns.
    """

    values: Array
    covariance: Array
    residual: Array
    leverage: Array
    cost: float


class NormalEquations:
    """Normal equations of a system, each unknown in units of its deviation."""

    def __init__(self, system: System) -> None:
        self._system = system
        columns = np.moveaxis(system.matrix * system.deviation, 1, 0)  # (k, B, p)
        gap = (system.target - system.matrix @ system.mean).T
        self._gram = np.swapaxes(columns, 1, 2) @ columns
        self._right = np.einsum("kbp,kb->kp", columns, gap)

    def solved(self, noise: Array) -> Solution:
        """The solution at a noise (k,)."""
        system = self._system
        weights = 1.0 / noise**2
        matrix = np.tensordot(weights, self._gram, axes=1) + np.eye(len(system.mean))
        factor = cho_factor(matrix, lower=True)
        z = cho_solve(factor, weights @ self._right)
        scaled = cho_solve(factor, np.eye(len(z)))
        values = system.mean + system.deviation * z
        residual = system.target - system.matrix @ values
        leverage = weights * np.einsum("kpq,qp->k", self._gram, scaled)
        cost = float(np.square(residual / noise).sum() + z @ z)
        covariance = scaled * np.outer(system.deviation, system.deviation)
        return Solution(values, covariance, residual, leverage, cost)


def _correlation(residual: Array, run: Array) -> Array:
    """Variance of a mean of blocks over that of independent ones (k,), by neighbours."""
    is_pair = run[1:] == run[:-1]
    if is_pair.sum() < 4:
        return np.ones(residual.shape[1])
    products = (residual[1:] * residual[:-1])[is_pair].sum(axis=0)
    squares = np.maximum((residual[1:] ** 2)[is_pair].sum(axis=0), TINY)
    rho = np.clip(products / squares, *CORRELATED)
    return np.asarray((1.0 + rho) / (1.0 - rho))
