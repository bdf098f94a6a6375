"""Outliers: measurements that do not fit what all others show.

The start is a robust fit, since one wrong row spoils least squares. Then rows are left out and
taken back by their studentised residuals, as in `identification/outliers.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import stats

from ..ground.arrays import Array
from .fit import Fitted, Fitter, Mask

Loss = Literal["reject", "huber", "linear"]
LOSSES = ("reject", "huber", "linear")
CASES = 0.01  # share of clean data in which a good row is left out
CAUCHY = 2.4  # deviations at which a residual has half the weight in the robust start
HUBER = 1.345  # deviations up to which a residual has full weight
STEPS = 12  # iterations of the robust start
ROUNDS = 12  # of leaving rows out and taking them back
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
    if loss == "linear" or not outliers_of(fitter, fitted, owners):
        return fitted
    robust = _robust(fitter, fitted, HUBER if loss == "huber" else CAUCHY, loss)
    if loss == "huber":
        return robust
    excluded: Mask = _excluded(fitter, robust, owners)
    for _ in range(ROUNDS):
        weights = _base_weights(fitter) * ~excluded
        if int((weights > 0.0).sum()) < len(fitter.start):
            return fitted
        robust = fitter.settled(fitter.with_weights(robust, weights))
        before = excluded
        excluded = _excluded(fitter, robust, owners)
        if np.array_equal(before, excluded):
            break
    return robust


def outliers_of(fitter: Fitter, fitted: Fitted, owners: Array) -> list[Outlier]:
    """Measurements beyond the limit of noise in a fit."""
    sizes = np.abs(studentised(fitter, fitted))
    limit = _limit(fitter, fitted)
    outliers: list[Outlier] = []
    for quantity in np.unique(owners):
        largest = sizes[:, owners == quantity].max(axis=1)
        rows = np.flatnonzero(largest > limit).tolist()
        outliers += [Outlier(row, int(quantity), float(largest[row])) for row in rows]
    return sorted(outliers, key=_row)


def _row(outlier: Outlier) -> int:
    return outlier.row


def studentised(fitter: Fitter, fitted: Fitted) -> Array:
    """Residuals of the fit to all other components over their deviation (N, c)."""
    base = _base_weights(fitter)
    residuals = np.nan_to_num(fitted.predicted.differences) / fitted.noise.by_component * base
    rows = fitted.jacobian * (base / fitted.noise.by_component)[..., None]
    leverage = np.einsum("nci,ij,ncj->nc", rows, fitted.covariance, rows)
    is_used = fitted.weights > 0.0
    variance = np.where(is_used, np.maximum(1.0 - leverage, LEAST_FREE), 1.0 + leverage)
    return np.asarray(residuals / np.sqrt(variance))


def _base_weights(fitter: Fitter) -> Array:
    """Weights without any rejection (N, c)."""
    return np.asarray(fitter.measured * fitter.row_weights[:, None])


def _limit(fitter: Fitter, fitted: Fitted) -> float:
    """Size of a studentised residual that noise does not reach.

    Where the robot fits worse than the given noise, its own scatter counts.
    """
    sizes = np.abs(studentised(fitter, fitted))[fitter.measured]
    scatter = float(np.median(sizes) / stats.norm.ppf(0.75))
    tail = 0.5 * CASES / max(len(sizes), 1)
    return float(stats.norm.isf(tail)) * max(1.0, scatter)


def _excluded(fitter: Fitter, fitted: Fitted, owners: Array) -> Mask:
    """Components (N, c) of all outliers."""
    excluded: Mask = np.zeros(fitter.measured.shape, dtype=bool)
    for outlier in outliers_of(fitter, fitted, owners):
        excluded[outlier.row, owners == outlier.quantity] = True
    return excluded


def _robust(fitter: Fitter, fitted: Fitted, limit: float, loss: Loss) -> Fitted:
    """The fit with weights that fall with the residuals."""
    base = _base_weights(fitter)
    for _ in range(STEPS):
        sizes = np.abs(studentised(fitter, fitted))
        scatter = float(np.median(sizes[fitter.measured]) / stats.norm.ppf(0.75))
        ratio = sizes / (limit * max(1.0, scatter))
        if loss == "huber":
            factors = np.sqrt(1.0 / np.maximum(ratio, 1.0))
        else:
            factors = 1.0 / np.sqrt(1.0 + ratio**2)
        before = fitted.predicted.values
        fitted = fitter.minimised(fitter.with_weights(fitted, base * factors))
        change = np.abs((fitted.predicted.values - before) * fitter.scales)
        deviations = np.sqrt(np.diag(fitted.covariance))
        if (change < 0.01 * deviations).all():
            break
    return fitted
