"""Weighted least squares over the parameters of a robot, by Levenberg and Marquardt's method.

A prior holds what no measurement shows near the file: its deviation is a twentieth of the robot's
reach, thousands of times that of a measurement. Where the data show a parameter, it has no effect.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import DescriptionError, InputError
from ..ground.arrays import Array
from .closed_rows import OpenLoopError
from .noise import Noise
from .sensitivity import Predicted, Sensitivity

Mask = NDArray[np.bool_]
PRIOR = 0.05  # of the reach: deviation of what no measurement shows
MAX_ITERATIONS = 40
MAX_DAMPING = 1e8
FIRST_DAMPING = 1e-4
GAIN = 1e-8  # expected decrease of the sum of squares below which the fit has converged
NEAR = 2e-3  # of the reach: change of the parameters for which derivatives stay good enough
ROUNDS = 30  # of estimating deviations and weights
SETTLED = 1e-3  # relative change of deviations that have converged


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fit.

    Attributes:
        predicted: prediction of the estimate.
        jacobian: derivatives (N, c, k) per natural unit [1/m].
        noise: deviations.
        weights: weight of each component (N, c); zero for those that are left out.
        covariance: of the parameters in natural units (k, k) [m^2].
    """

    predicted: Predicted
    jacobian: Array
    noise: Noise
    weights: Array
    covariance: Array

    @property
    def normalised(self) -> Array:
        """Weighted residuals (N, c), zero where nothing was measured."""
        residuals = np.nan_to_num(self.predicted.differences)
        return np.asarray(residuals / self.noise.by_component * self.weights)

    @property
    def rows(self) -> Array:
        """Weighted derivatives (N, c, k)."""
        factors = self.weights / self.noise.by_component
        return np.asarray(self.jacobian * factors[..., None])

    @property
    def leverages(self) -> Array:
        """Leverage of each component (N, c)."""
        rows = self.rows
        return np.asarray(np.einsum("nci,ij,ncj->nc", rows, self.covariance, rows))

    @property
    def freedom(self) -> float:
        """Degrees of freedom: components with a weight, less what the parameters take."""
        used = int((self.weights > 0.0).sum())
        return used - float(self.leverages.sum())

    @property
    def chi2(self) -> float:
        """Reduced chi-squared."""
        total = float((self.normalised**2).sum())
        return total / max(self.freedom, 1e-9)


class Fitter:
    """Fits the parameters.

    Attributes:
        sensitivity: predictions and derivatives.
        measured: mask (N, c) of what was measured.
        row_weights: square roots of the weights of the rows (N,).
    """

    def __init__(self, sensitivity: Sensitivity, row_weights: Array) -> None:
        self.sensitivity = sensitivity
        self.scales = sensitivity.scales
        self.start = sensitivity.free_robot.start
        self.deviation = PRIOR * sensitivity.reach
        self.first = sensitivity.at_start()
        self.measured: Mask = np.isfinite(self.first.differences)
        self.row_weights = row_weights
        count = len(self.start)
        if int(self.measured.sum()) < count:
            raise InputError(
                f"{int(self.measured.sum())} measured numbers cannot give {count} parameters; give"
                " more rows, or fewer parameters"
            )

    def first_fit(self, noise: Noise) -> Fitted:
        """The starting point, without a step."""
        jacobian = self.sensitivity.jacobian(self.first)
        weights = self.measured * self.row_weights[:, None]
        return self._with_covariance(Fitted(self.first, jacobian, noise, weights, np.eye(0)))

    def settled(self, fitted: Fitted) -> Fitted:
        """The best parameters, with deviations of the noise that fit where none are given."""
        for _ in range(ROUNDS):
            fitted = self.minimised(fitted)
            noise = self._estimated_noise(fitted)
            change = np.abs(noise.deviations / fitted.noise.deviations - 1.0).max()
            fitted = self._with_covariance(replace(fitted, noise=noise))
            if change < SETTLED:
                break
        return fitted

    def with_weights(self, fitted: Fitted, weights: Array) -> Fitted:
        """The same fit with other weights (N, c), not yet minimised."""
        return self._with_covariance(replace(fitted, weights=weights))

    def with_noise(self, fitted: Fitted, noise: Noise) -> Fitted:
        """The same fit with other deviations, not yet minimised."""
        return self._with_covariance(replace(fitted, noise=noise))

    def minimised(self, fitted: Fitted) -> Fitted:
        """The parameters with the least sum of squares."""
        damping = FIRST_DAMPING
        at_jacobian = fitted.predicted.values
        for _ in range(MAX_ITERATIONS):
            step, expected = self._step(fitted, damping)
            if expected < GAIN:
                break
            trial = self._after(fitted, step)
            if trial is None:
                damping *= 10.0
                if damping > MAX_DAMPING:
                    break
                continue
            damping = max(0.1 * damping, 1e-12)
            fitted = replace(fitted, predicted=trial)
            away = np.abs((trial.values - at_jacobian) * self.scales).max()
            if away > NEAR * self.sensitivity.reach:
                at_jacobian = trial.values
                fitted = replace(fitted, jacobian=self.sensitivity.jacobian(trial))
        return self._with_covariance(fitted)

    def _after(self, fitted: Fitted, step: Array) -> Predicted | None:
        """The prediction after a step, if that is better."""
        values = fitted.predicted.values + step / self.scales
        try:
            trial = self.sensitivity.at(values, fitted.predicted)
        except (DescriptionError, OpenLoopError):
            return None
        if self._cost(replace(fitted, predicted=trial)) < self._cost(fitted):
            return trial
        return None

    def _natural(self, predicted: Predicted) -> Array:
        """Changes of the parameters in natural units (k,) [m]."""
        return np.asarray((predicted.values - self.start) * self.scales)

    def _cost(self, fitted: Fitted) -> float:
        prior = self._natural(fitted.predicted) / self.deviation
        return float((fitted.normalised**2).sum() + (prior**2).sum())

    def _step(self, fitted: Fitted, damping: float) -> tuple[Array, float]:
        """The damped step (k,) in natural units, and the decrease that it promises."""
        count = len(self.start)
        rows = fitted.rows.reshape(-1, count)
        prior = np.eye(count) / self.deviation
        matrix = np.vstack([rows, prior])
        at = self._natural(fitted.predicted) / self.deviation
        target = np.concatenate([fitted.normalised.ravel(), at])
        norms = np.linalg.norm(matrix, axis=0)
        scaled = matrix / norms
        damped = np.vstack([scaled, np.sqrt(damping) * np.eye(count)])
        goal = np.concatenate([-target, np.zeros(count)])
        step = np.linalg.lstsq(damped, goal, rcond=None)[0]
        step[list(self.sensitivity.free_robot.fixed)] = 0.0
        after = target + scaled @ step
        return step / norms, float(target @ target - after @ after)

    def _with_covariance(self, fitted: Fitted) -> Fitted:
        count = len(self.start)
        rows = fitted.rows.reshape(-1, count)
        matrix = np.vstack([rows, np.eye(count) / self.deviation])
        norms = np.linalg.norm(matrix, axis=0)
        triangle = np.linalg.qr(matrix / norms, mode="r")
        inverse = np.linalg.inv(triangle) / norms[:, None]
        return replace(fitted, covariance=inverse @ inverse.T)

    def _estimated_noise(self, fitted: Fitted) -> Noise:
        """Deviations by Foerstner's estimate: sums of squares over redundancies."""
        noise = fitted.noise
        squares = fitted.normalised**2
        shares = (fitted.weights > 0.0) - fitted.leverages
        deviations = noise.deviations.copy()
        for k, is_given in enumerate(noise.is_given):
            if is_given:
                continue
            mine = noise.groups == k
            redundancy = float(shares[:, mine].sum())
            ratio = float(squares[:, mine].sum()) / max(redundancy, 1e-3)
            deviations[k] *= np.sqrt(ratio)
        return noise.with_deviations(deviations)
