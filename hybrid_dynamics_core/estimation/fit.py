"""Least squares with what is known before, noise from the residuals, and honest covariance.

Each unknown has a normal distribution before the measurement; so has each error of the model.
Neighbouring blocks are correlated where the model is wrong. The noise is increased by that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..identification.outliers import noise_limit

Mask = NDArray[np.bool_]
RUNS = 8  # fits, each with the noise of the one before
PRIOR_SAMPLES = 2.0  # [blocks] as which the expected noise counts
CORRELATED = (-0.5, 0.8)  # least and largest correlation of neighbours that counts
LEAST_PAIRS = 4  # of neighbours that show a correlation
TINY = 1e-300  # keeps divisions by zero finite


@dataclass(frozen=True, eq=False)
class System:
    """Block means of the equations, with what is known before: B blocks, k drives, p unknowns.

    Attributes:
        matrix: (B, k, p) change of each effort with each unknown.
        target: (B, k) measured efforts less those of the model [N m, N].
        mean: (p,) expected unknowns.
        deviation: (p,) their standard deviations.
        floor: (k,) expected noise of a block [N m, N].
        run: (B,) number of the run of each block.
    """

    matrix: Array
    target: Array
    mean: Array
    deviation: Array
    floor: Array
    run: Array

    def only(self, rows: Mask) -> System:
        """The system of the blocks of a mask (B,)."""
        parts = (self.matrix[rows], self.target[rows], self.mean, self.deviation, self.floor)
        return System(*parts, self.run[rows])


@dataclass(frozen=True, eq=False)
class Fit:
    """Unknowns after the measurement.

    Attributes:
        values: (p,) estimated unknowns.
        covariance: (p, p) of the unknowns.
        noise: (k,) standard deviation of a block [N m, N].
        residual: (B, k) target less the fit [N m, N].
        free: degrees of freedom of the noise.
    """

    values: Array
    covariance: Array
    noise: Array
    residual: Array
    free: float


def fitted(system: System) -> Fit:
    """The fit, repeated with the noise that its residuals show."""
    normal = NormalEquations(system)
    noise = system.floor
    correlation = np.ones_like(noise)
    free = np.ones_like(noise)
    count = len(system.target)
    solution = normal.solved(noise)
    for _ in range(RUNS):
        squares = (solution.residual**2).sum(axis=0)
        free = np.maximum(count - solution.leverage, 0.0)
        expected = PRIOR_SAMPLES * system.floor**2
        noise = np.sqrt((squares + expected) / (free + PRIOR_SAMPLES))
        correlation = _correlation(solution, noise, system.run)
        solution = normal.solved(noise * np.sqrt(correlation))
    degrees = float((free / correlation).sum() + PRIOR_SAMPLES)
    return Fit(solution.values, solution.covariance, noise, solution.residual, max(degrees, 1.0))


def solved(system: System, noise: Array) -> Solution:
    """The fit at a given noise (k,) [N m, N]."""
    return NormalEquations(system).solved(noise)


def unfitting(system: System, fit: Fit) -> Mask:
    """Mask (B,) of blocks whose residuals are too large for noise."""
    limit = noise_limit(system.target.size)
    size = np.abs(fit.residual) / fit.noise
    return np.asarray((size > limit).any(axis=1))


@dataclass(frozen=True, eq=False)
class Solution:
    """Unknowns at a given noise.

    Attributes:
        values: (p,) estimated unknowns.
        covariance: (p, p) of the unknowns.
        residual: (B, k) target less the fit [N m, N].
        leverage: (k,) number of equations of each drive that the unknowns use up.
        shared: (B - 1, k) by how much the unknowns make residuals of neighbours opposite: minus
            their covariance over the variance of noise, if noise itself has none.
        cost: sum of squares of residuals over noise, and of unknowns over deviations.
    """

    values: Array
    covariance: Array
    residual: Array
    leverage: Array
    shared: Array
    cost: float


class NormalEquations:
    """Normal equations of a system, each unknown in units of its deviation."""

    def __init__(self, system: System) -> None:
        self._system = system
        columns = np.moveaxis(system.matrix * system.deviation, 1, 0)  # (k, B, p)
        gap = (system.target - system.matrix @ system.mean).T
        self._columns = columns
        self._gram = np.swapaxes(columns, 1, 2) @ columns
        self._right = np.einsum("kbp,kb->kp", columns, gap)

    def solved(self, noise: Array) -> Solution:
        """The solution at a noise (k,) [N m, N]."""
        from scipy.linalg import cho_factor, cho_solve  # noqa: PLC0415  slow to import

        system = self._system
        weights = 1.0 / noise**2
        matrix = np.tensordot(weights, self._gram, axes=1) + np.eye(len(system.mean))
        factor = cho_factor(matrix, lower=True)
        z = cho_solve(factor, weights @ self._right)
        inverse = cho_solve(factor, np.eye(len(z)))
        values = system.mean + system.deviation * z
        residual = system.target - system.matrix @ values
        leverage = weights * np.einsum("kpq,qp->k", self._gram, inverse)
        mapped = self._columns @ inverse
        products = (mapped[:, 1:] * self._columns[:, :-1]).sum(axis=2)
        shared = (weights[:, None] * products).T
        cost = float(np.square(residual / noise).sum() + z @ z)
        covariance = inverse * np.outer(system.deviation, system.deviation)
        return Solution(values, covariance, residual, leverage, shared, cost)


def _correlation(solution: Solution, noise: Array, run: Array) -> Array:
    """By how much the correlation of neighbours increases the variance of a mean (k,).

    Unknowns that take up much of the noise leave residuals with opposite neighbours. What they do
    by themselves is taken out.

    Args:
        solution: the fit.
        noise: (k,) standard deviation of a block [N m, N].
        run: (B,) number of the run of each block; neighbours are of one run.
    """
    residual = solution.residual
    is_pair = run[1:] == run[:-1]
    if is_pair.sum() < LEAST_PAIRS:
        return np.ones(residual.shape[1])
    of_fit = noise**2 * solution.shared[is_pair].sum(axis=0)
    products = (residual[1:] * residual[:-1])[is_pair].sum(axis=0) + of_fit
    squares = np.maximum(noise**2 * is_pair.sum(), TINY)
    rho = np.clip(products / squares, *CORRELATED)
    return np.asarray((1.0 + rho) / (1.0 - rho))
