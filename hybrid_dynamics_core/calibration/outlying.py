"""Outliers: measurements that do not fit what all others show.

The start is a robust fit, since one wrong row spoils least squares. Then rows are left out and
taken back by their studentised residuals, as in `identification/outliers.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..ground.arrays import Array
from ..identification.outliers import robust_deviation
from .fit import SETTLED, Fitted, Fitter, Mask

Loss = Literal["reject", "huber", "linear"]
LOSSES = ("reject", "huber", "linear")
CASES = 0.01  # share of clean data in which a good row is left out
CAUCHY = 2.4  # deviations at which a residual has half the weight in the robust start
HUBER = 1.345  # deviations up to which a residual has full weight
STEPS = 12  # iterations of the robust start
ROUNDS = 12  # of leaving rows out and taking them back
STILL = 0.01  # of a deviation: change of a parameter that has converged
SURELY = 0.1  # share of an estimated deviation below which a median shows it to be too wide
MEDIAN = 1.17  # deviation of the scatter by a median, times the root of the number of residuals
SIGNIFICANT = 4.0  # such deviations that are no chance
LEAST_FREE = 1e-6  # 1 - leverage below which a component alone determines a parameter


@dataclass(frozen=True)
class Outlier:
    """A measurement that was left out, or has little weight.

    Attributes:
        row: index of the row.
        quantity: index of the quantity.
        size: its largest studentised residual.
    """

    row: int
    quantity: int
    size: float


def without_outliers(fitter: Fitter, fitted: Fitted, owners: Array, loss: Loss) -> Fitted:
    """The fit, robust against outliers.

    Args:
        fitter: the fitter.
        fitted: the best fit to all measurements.
        owners: quantity of each component (c,).
        loss: `reject` leaves outliers out, `huber` gives them less weight, `linear` does nothing.
    """
    if loss == "linear":
        return fitted
    narrowed = _narrowed(fitter, fitted)
    if not outliers_of(fitter, narrowed, owners):
        return fitted
    if loss == "huber":
        return _settled_robust(fitter, narrowed)
    robust = _robust(fitter, narrowed, _cauchy_weights)
    excluded = _excluded(fitter, robust, owners)
    for _ in range(ROUNDS):
        weights = _base_weights(fitter) * ~excluded
        used = int(np.count_nonzero(weights))
        if used < len(fitter.start):
            return fitted
        weighted = fitter.with_weights(robust, weights)
        robust = fitter.settled(weighted)
        before = excluded
        excluded = _excluded(fitter, robust, owners)
        if np.array_equal(before, excluded):
            break
    return robust


def outliers_of(fitter: Fitter, fitted: Fitted, owners: Array) -> list[Outlier]:
    """Measurements beyond the limit of noise in a fit."""
    sizes = studentised_sizes(fitter, fitted)
    limit = _limit(fitter, sizes)
    outliers: list[Outlier] = []
    for quantity in np.unique(owners).tolist():
        mine = owners == quantity
        largest = sizes[:, mine].max(axis=1)
        rows = np.flatnonzero(largest > limit).tolist()
        outliers += [Outlier(row, int(quantity), float(largest[row])) for row in rows]
    return sorted(outliers, key=_row)


def _row(outlier: Outlier) -> int:
    return outlier.row


def studentised_sizes(fitter: Fitter, fitted: Fitted) -> Array:
    """Sizes (N, c) of residuals of the fit to all other components, over their deviation."""
    factors = _base_weights(fitter) / fitted.noise.by_component
    residuals = np.nan_to_num(fitted.predicted.differences) * factors
    rows = fitted.jacobian * factors[..., None]
    leverage = np.einsum("nci,ij,ncj->nc", rows, fitted.covariance, rows)
    is_used = fitted.weights > 0.0
    of_used = np.maximum(1.0 - leverage, LEAST_FREE)
    variance = np.where(is_used, of_used, 1.0 + leverage)
    sizes: Array = np.abs(residuals) / np.sqrt(variance)
    return sizes


def _base_weights(fitter: Fitter) -> Array:
    """Weights without any rejection (N, c)."""
    weights: Array = fitter.measured * fitter.row_weights[:, None]
    return weights


def _scatter(fitter: Fitter, sizes: Array) -> float:
    """The deviation of studentised residuals by their median, and at least 1.

    Where the robot fits worse than the given noise, its own scatter counts.
    """
    measured = sizes[fitter.measured]
    return max(1.0, float(robust_deviation(measured)))


def _narrowed(fitter: Fitter, fitted: Fitted) -> Fitted:
    """The fit with deviations by medians, where outliers made those that were estimated too wide.

    Many outliers hide themselves otherwise: a tenth of the rows triples the deviation.
    """
    noise = fitted.noise
    sizes = studentised_sizes(fitter, fitted)
    counts = _base_weights(fitter) > 0.0
    deviations = noise.deviations.copy()
    for k in range(len(noise.names)):
        mine = noise.groups == k
        measured = sizes[:, mine][counts[:, mine]]
        if not len(measured):
            continue
        scatter = float(robust_deviation(measured))
        chance = SIGNIFICANT * MEDIAN / np.sqrt(len(measured))
        if scatter < max(SURELY, 1.0 - chance):
            deviations[k] *= scatter
    return fitter.with_noise(fitted, noise.with_deviations(deviations))


def _settled_robust(fitter: Fitter, fitted: Fitted) -> Fitted:
    """Huber's fit, with deviations by medians of its own residuals where none are given."""
    for _ in range(ROUNDS):
        robust = _robust(fitter, fitted, _huber_weights)
        fitted = _with_medians(fitter, robust)
        change = np.abs(fitted.noise.deviations / robust.noise.deviations - 1.0)
        if change.max() < SETTLED:
            break
    return fitted


def _with_medians(fitter: Fitter, fitted: Fitted) -> Fitted:
    """The fit with deviations by medians of its residuals; given ones stay."""
    noise = fitted.noise
    sizes = studentised_sizes(fitter, fitted)
    counts = _base_weights(fitter) > 0.0
    deviations = noise.deviations.copy()
    for k in range(len(noise.names)):
        mine = noise.groups == k
        measured = sizes[:, mine][counts[:, mine]]
        if len(measured):
            deviations[k] *= float(robust_deviation(measured))
    return fitter.with_noise(fitted, noise.with_deviations(deviations))


def _limit(fitter: Fitter, sizes: Array) -> float:
    """Size of a studentised residual that noise does not reach."""
    from scipy import stats  # noqa: PLC0415  slow to import

    count = int(np.count_nonzero(fitter.measured))
    tail = 0.5 * CASES / max(count, 1)
    deviations = float(stats.norm.isf(tail))
    return deviations * _scatter(fitter, sizes)


def _excluded(fitter: Fitter, fitted: Fitted, owners: Array) -> Mask:
    """Components (N, c) of all outliers."""
    excluded: Mask = np.zeros(fitter.measured.shape, dtype=bool)
    for outlier in outliers_of(fitter, fitted, owners):
        mine = owners == outlier.quantity
        excluded[outlier.row, mine] = True
    return excluded


def _huber_weights(sizes: Array) -> Array:
    """Weights of residuals whose influence stays the same beyond a limit."""
    beyond = np.maximum(sizes / HUBER, 1.0)
    weights: Array = np.sqrt(1.0 / beyond)
    return weights


def _cauchy_weights(sizes: Array) -> Array:
    """Weights of residuals whose influence falls to zero."""
    ratio = sizes / CAUCHY
    weights: Array = 1.0 / np.sqrt(1.0 + ratio**2)
    return weights


def _robust(fitter: Fitter, fitted: Fitted, weights_of: Callable[[Array], Array]) -> Fitted:
    """The fit with weights that fall with the residuals."""
    base = _base_weights(fitter)
    for _ in range(STEPS):
        sizes = studentised_sizes(fitter, fitted)
        scatter = _scatter(fitter, sizes)
        weights = base * weights_of(sizes / scatter)
        before = fitted.predicted.values
        weighted = fitter.with_weights(fitted, weights)
        fitted = fitter.minimised(weighted)
        change = (fitted.predicted.values - before) * fitter.scales
        variances = np.diag(fitted.covariance)
        if (np.abs(change) < STILL * np.sqrt(variances)).all():
            break
    return fitted
