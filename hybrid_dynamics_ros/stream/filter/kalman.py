"""Derivatives of sampled positions by a Kalman filter, for samples at any stamps.

The model of the motion is white snap: the fourth derivative of a joint's position is white noise
(Bar-Shalom, Li and Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001,
ch. 6, one order higher). Samples are positions with white noise, or positions and velocities.

Why this one
  * Motions of degree 3 have no steady error, at any stamps. Slow motions have no lag: the error of
    the acceleration grows with the square of the frequency.
  * For samples much denser than 1/omega it is a linear filter with the poles of a Butterworth
    filter of order 4: an acceleration passes as (1 + c s) / (1 + c s + (c^2 / 2) s^2 + c s^3 + s^4)
    does, with s in units of omega and c = sqrt(4 + 2 sqrt(2)). It has lost 3 dB at 1.554 omega,
    and is up to 2.16 times too large at 0.85 omega.
  * White noise of deviation sigma on samples every dt gives the acceleration the deviation
    1.54 sigma sqrt(omega^5 dt).

How it runs: covariances depend on stamps alone, so all joints share them. They are those of
positions with unit noise in units of 1/omega, and settle within some 1/omega. A sample is weighted
by the interval before it, so the bandwidth does not depend on the sample rate. The covariance is
kept as U D U^T, where U has a unit diagonal (Bierman, *Factorization Methods for Discrete
Sequential Estimation*, 1977, ch. V and VI), which avoids loss of precision if the first samples
determine little.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from .filter import Condition, RateFilter, require_positive
from .scalars import Scalar, Scalars, choose
from .steps import Steps

_ORDER: Final = 4  # position, velocity, acceleration, jerk
_ABOVE: Final = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))  # entries of U

# Frequency over omega at which accelerations from positions have lost 3 dB.
_BANDWIDTH: Final = 1.5538243

# Large variances, in natural units, of derivatives that one sample does not determine.
_UNDETERMINED: Final = 1e20

# White snap of unit density over a unit of time has the covariance U D U^T.
_NOISE_U: Final = ((1 / 2, 3 / 20, 1 / 24), (1 / 2, 1 / 6), (1 / 2,))
_NOISE_D: Final = (1 / 100800, 1 / 720, 1 / 12, 1.0)

# Steady variance of accelerations in natural units: for dense samples, and for a step of 1/omega,
# where it grows with the cube of the step.
_DENSE: Final = 6.32
_SPARSE: Final = 0.31

_LARGEST: Final = 25.0  # largest variance of usable accelerations, over the steady one


Rows = list[list[Scalar]]


@dataclass(frozen=True)
class KalmanSteps:
    """The formulas of the filter.

    Constants are omega [1/s], and the velocity noise for unit position noise. The latter is a
    variance in natural units. The memory has the covariance (D, then U by rows), and last the least
    variance of accelerations so far over the steady one. After one sample D is zero for measured
    values: their noise follows from the interval to the second sample.

    Attributes:
        channels: 1 for positions, 2 for positions and velocities.
    """

    channels: int
    constants: int = 2
    memory: int = 11
    derivatives: int = _ORDER

    def update(self, constants: Scalars, memory: Scalars, dt: Scalar) -> tuple[Scalars, Scalars]:
        """Memory after one more sample, and gains of its position, then of its velocity."""
        omega, ratio = constants
        step = omega * dt
        noises = [1.0 / step, ratio / step]
        diagonal, upper = _factors(memory)
        for order, noise in enumerate(noises):
            diagonal[order] = choose(diagonal[order], 0.0, diagonal[order], noise)
        diagonal, upper = _predicted(diagonal, upper, step)
        gains: list[Scalar] = []
        for order, noise in enumerate(noises[: self.channels]):
            natural, diagonal, upper = _measured(diagonal, upper, order, noise)
            gains += _scaled(natural, omega, order)
        variance = diagonal[2] + upper[2][3] * upper[2][3] * diagonal[3]
        relative = variance / (_DENSE + _SPARSE * step * step * step)
        quality = choose(memory[-1], relative, relative, memory[-1])
        entries = [upper[i][k] for i, k in _ABOVE]
        return (*diagonal, *entries, quality), gains

    def correct(
        self, derivatives: Scalars, dt: Scalar, gains: Scalars, samples: Scalars
    ) -> Scalars:
        """The cubic moved to the new sample, and corrected by position and velocity in turn."""
        values = _moved(derivatives, dt)
        for order in range(self.channels):
            error = samples[order] - values[order]
            factors = gains[_ORDER * order : _ORDER * (order + 1)]
            values = [value + gain * error for value, gain in zip(values, factors, strict=True)]
        return values


def _factors(memory: Scalars) -> tuple[list[Scalar], Rows]:
    """D, and U with all entries."""
    upper = _unit()
    for (i, k), entry in zip(_ABOVE, memory[_ORDER:-1], strict=True):
        upper[i][k] = entry
    return list(memory[:_ORDER]), upper


def _unit() -> Rows:
    return [[float(i == k) for k in range(_ORDER)] for i in range(_ORDER)]


def _predicted(diagonal: Sequence[Scalar], upper: Rows, step: Scalar) -> tuple[list[Scalar], Rows]:
    """The covariance after an interval, with its process noise (Thornton's update).

    F U D U^T F^T + Q is W diag(D, D_Q) W^T with W = [F U, U_Q], whose rows are made orthogonal by
    Gram-Schmidt with weights, from the last one on. Columns of both parts alternate, so that row i
    begins in column 2 i, with a one of each part.

    Args:
        diagonal: D.
        upper: U.
        step: interval in units of 1/omega.
    """
    powers = [1.0, step]
    while len(powers) < 2 * _ORDER:
        powers.append(powers[-1] * step)
    rows, weights = _widened(upper, powers), _weights(diagonal, powers)
    after, variances = _unit(), list(diagonal)
    for j in reversed(range(_ORDER)):
        columns = slice(2 * j, None)
        row = rows[j][columns]
        weighted = [weight * entry for weight, entry in zip(weights[columns], row, strict=True)]
        variances[j] = _dot(weighted, row)
        for i in range(j):
            other = rows[i][columns]
            share = _dot(weighted, other) / variances[j]
            rows[i][columns] = [x - share * y for x, y in zip(other, row, strict=True)]
            after[i][j] = share
    return variances, after


def _widened(upper: Rows, powers: Sequence[Scalar]) -> Rows:
    """[F U, U_Q] with alternating columns, for powers of the step."""
    rows: Rows = []
    for i in range(_ORDER):
        row: list[Scalar] = [0.0] * (2 * i) + [1.0, 1.0]
        for k in range(i + 1, _ORDER):
            moved = upper[i][k]
            for j in range(i + 1, k + 1):
                factor = 1.0 / math.factorial(j - i)
                moved = moved + factor * powers[j - i] * upper[j][k]
            noise = _NOISE_U[i][k - i - 1] * powers[k - i]
            row += [moved, noise]
        rows.append(row)
    return rows


def _weights(diagonal: Sequence[Scalar], powers: Sequence[Scalar]) -> list[Scalar]:
    """(D, D_Q) of alternating columns, for powers of the step."""
    weights: list[Scalar] = []
    for k, (variance, noise) in enumerate(zip(diagonal, _NOISE_D, strict=True)):
        weights += [variance, noise * powers[7 - 2 * k]]
    return weights


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def _measured(
    diagonal: Sequence[Scalar], upper: Rows, order: int, noise: Scalar
) -> tuple[list[Scalar], list[Scalar], Rows]:
    """Gains of a measured derivative, and the covariance with it (Bierman's update).

    Args:
        diagonal: D.
        upper: U.
        order: order of the derivative.
        noise: variance of the sample.
    """
    after, variances = [list(row) for row in upper], list(diagonal)
    gains: list[Scalar] = [0.0] * _ORDER
    total = noise
    for k in range(order, _ORDER):
        factor = upper[order][k]
        part = diagonal[k] * factor
        before, total = total, total + part * factor
        variances[k] = diagonal[k] * (before / total)
        for i in range(k):
            after[i][k] = upper[i][k] - factor / before * gains[i]
            gains[i] = gains[i] + part * upper[i][k]
        gains[k] = part
    return [gain / total for gain in gains], variances, after


def _scaled(gains: Sequence[Scalar], omega: Scalar, order: int) -> list[Scalar]:
    """Gains in seconds, from gains in units of 1/omega.

    Args:
        gains: gains of a derivative in natural units.
        omega: rate of the filter [1/s].
        order: order of the derivative.
    """
    scaled = []
    for k, gain in enumerate(gains):
        value = gain
        for _ in range(order, k):
            value = value * omega
        for _ in range(k, order):
            value = value / omega
        scaled.append(value)
    return scaled


def _moved(derivatives: Scalars, dt: Scalar) -> list[Scalar]:
    """The cubic, shifted by `dt` [s]."""
    position, velocity, acceleration, jerk = derivatives
    return [
        position + dt * (velocity + dt * (0.5 * acceleration + dt * (jerk / 6.0))),
        velocity + dt * (acceleration + dt * (0.5 * jerk)),
        acceleration + dt * jerk,
        jerk,
    ]


@dataclass(frozen=True)
class KalmanFilter(RateFilter):
    """Kalman filter of white snap, for positions with or without velocities.

    Attributes:
        bandwidth: frequency where accelerations from dense positions have lost 3 dB [Hz].
        velocity_noise: deviation of measured velocities over that of positions [1/s].
        max_gap: gaps longer than this restart the filter [s].
    """

    bandwidth: float
    velocity_noise: float
    max_gap: float

    def __post_init__(self) -> None:
        require_positive("bandwidth", self.bandwidth)
        require_positive("velocity_noise", self.velocity_noise)
        self.prepare()

    @cached_property
    def omega(self) -> float:
        """The rate of the filter [1/s]."""
        return 2.0 * math.pi * self.bandwidth / _BANDWIDTH

    @property
    def lag(self) -> float:
        """Delay of accelerations for slow signals [s]: none."""
        return 0.0

    @property
    def steps(self) -> tuple[Steps, ...]:
        """Formulas for positions, and for positions with velocities; samples may alternate."""
        return KalmanSteps(1), KalmanSteps(2)

    @property
    def constants(self) -> tuple[float, ...]:
        """omega [1/s], and the variance of velocities in natural units."""
        return self.omega, (self.velocity_noise / self.omega) ** 2

    def first_memory(self, channels: int) -> tuple[float, ...]:
        """The memory after one sample; unmeasured derivatives are undetermined."""
        diagonal = [0.0] * channels + [_UNDETERMINED] * (_ORDER - channels)
        return (*diagonal, *(0.0 for _ in _ABOVE), math.inf)

    def is_good(self, elapsed: Condition, quality: Condition) -> Condition:  # noqa: ARG002
        """Whether the error of accelerations is within a factor of 5 of its steady value.

        That takes four positions, over some 1/omega; less with velocities.
        """
        return quality <= _LARGEST
