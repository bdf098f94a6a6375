"""A causal polynomial filter for derivatives of samples at arbitrary stamps.

The filter fits a polynomial of degree D to all samples so far, by least squares. A sample of age
tau has the weight exp(-lambda tau). The derivatives of the polynomial at the newest stamp are the
estimate.

This is the fading-memory polynomial filter (Morrison, *Introduction to Sequential Smoothing and
Prediction*, 1969, ch. 13). For D = 1 and 2 it is also known as critically damped g-h and g-h-k
filter (Brookner, *Tracking and Kalman Filtering Made Easy*, 1998, ch. 1). Its gains come from the
stamps of the samples.

Why this one
  * It is exact for every polynomial of degree D, at any stamps, from sample D + 1 on. It has no
    start-up transient, and no bias that grows with jitter or lost messages. Difference quotients
    with a low pass have both.
  * It has one parameter, with a meaning. For samples much denser than 1/lambda it is the linear
    filter s^D lambda^(D+1) / (s + lambda)^(D+1) for the highest derivative: an ideal differentiator
    and D + 1 equal real poles, without overshoot. Its gain falls to 1/sqrt(2) of the ideal
    differentiator at the bandwidth f_b [Hz]: lambda = 2 pi f_b / sqrt(2^(1/(D+1)) - 1).
  * Lag of the highest derivative at low frequency: (D + 1) / lambda less half a sample interval.
    At high rates that is 0.205 / f_b for D = 1 and 0.243 / f_b for D = 2. Lower derivatives have
    none: a changing highest derivative costs them an error of second order only.
  * White noise of deviation sigma on samples every dt gives the highest derivative the deviation
    sigma sqrt(lambda^3 dt / 4) for D = 1, sigma sqrt(3 lambda^5 dt / 16) for D = 2.

How it runs: the state is the polynomial itself (value and derivatives at the newest stamp, a row
each) and the weighted moments of the sample ages. A step moves the polynomial to the new stamp,
compares it with the new sample, and adds gains times the difference. This is an exact update of the
least-squares fit. Gains depend on stamps alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from .filter import Condition, RateFilter, require_positive
from .scalars import Scalar, Scalars, choose, choose_each, exp, expm1
from .steps import Steps

# Older samples keep at least this share of their weight at each step, so the memory has at least
# about one sample interval. If the bandwidth is too high for the sample rate, the filter becomes
# the finite difference of the last D + 1 samples.
LEAST_DECAY: Final = 0.1
MOST_WEIGHT: Final = 1.0 - LEAST_DECAY

# The degree is raised only when the fit is well conditioned: determinant over product of the
# diagonal. Two stamps that almost coincide say nothing about a second derivative.
LEAST_CONDITION: Final = 1e-9

# Below it, moments of stamps a nanosecond apart could underflow.
LEAST_BANDWIDTH: Final = 1e-12  # [Hz]


@dataclass(frozen=True)
class PolynomialSteps:
    """The formulas. The constant is lambda [1/s].

    The memory has weighted sums of age^k, k = 0..4, with ages in units of 1/lambda, and the allowed
    degree. It is zero after one sample, whose weight follows from the interval to the second.

    Attributes:
        degree: highest derivative that is fitted, 1 or 2.
    """

    degree: int
    channels: int = 1
    constants: int = 1
    memory: int = 6

    @property
    def derivatives(self) -> int:
        """The value and its derivatives."""
        return self.degree + 1

    def update(self, constants: Scalars, memory: Scalars, dt: Scalar) -> tuple[Scalars, Scalars]:
        """Memory and gains after one more sample; gains beyond the degree are zero."""
        (rate,) = constants
        step = rate * dt
        decay, weight = _weights(step)
        m0, *higher, _ = memory
        moments = _aged([choose(m0, 0.0, m0, weight), *higher], step, decay, weight)
        degree, determinant, cofactors = _fit(moments, self.degree)
        return (*moments, degree), _gains(cofactors, weight / determinant, rate)

    def correct(
        self, derivatives: Scalars, dt: Scalar, gains: Scalars, samples: Scalars
    ) -> Scalars:
        """The polynomial shifted to the new sample, and corrected."""
        (sample,) = samples
        moved = _moved(derivatives, dt)
        error = sample - moved[0]
        return [value + gain * error for value, gain in zip(moved, gains, strict=True)]


def _weights(step: Scalar) -> tuple[Scalar, Scalar]:
    """The factor for weights of older samples after a step, and the weight of the new sample.

    A sample stands for the interval before it: the bandwidth does not depend on the sample rate.
    They add up to 1. The second is not computed as a difference, which would lose digits for short
    steps.

    Args:
        step: interval in units of 1/lambda.
    """
    decay = exp(-step)
    weight = -expm1(-step)
    return (
        choose(decay, LEAST_DECAY, decay, LEAST_DECAY),
        choose(weight, MOST_WEIGHT, MOST_WEIGHT, weight),
    )


def _aged(moments: Scalars, step: Scalar, decay: Scalar, weight: Scalar) -> Scalars:
    """Moments after a step and a new sample, by a binomial shift of the ages.

    Args:
        moments: weighted sums of age^k, k = 0..4, ages in units of 1/lambda.
        step: interval in units of 1/lambda.
        decay: factor for weights of older samples.
        weight: weight of the new sample.
    """
    m0, m1, m2, m3, m4 = moments
    return (
        decay * m0 + weight,
        decay * (m1 + step * m0),
        decay * (m2 + step * (2.0 * m1 + step * m0)),
        decay * (m3 + step * (3.0 * m2 + step * (3.0 * m1 + step * m0))),
        decay * (m4 + step * (4.0 * m3 + step * (6.0 * m2 + step * (4.0 * m1 + step * m0)))),
    )


def _fit(moments: Scalars, highest: int) -> tuple[Scalar, Scalar, list[Scalar]]:
    """The largest allowed degree, and the fit of that degree.

    A degree is allowed if the Hankel matrix of its moments is well conditioned. With fewer samples
    than degree + 1 it is singular.

    Args:
        moments: with the newest sample.
        highest: the wanted degree, 1 or 2.

    Returns:
        The degree; determinant of its Hankel matrix; cofactors of the first column, zeros for
        higher degrees.
    """
    m0, m1, m2, m3, m4 = moments
    fits: list[tuple[Scalar, Scalar, list[Scalar]]] = [
        (m0 * m2 - m1 * m1, LEAST_CONDITION * m0 * m2, [m2, -m1, 0.0])
    ]
    if highest == 2:
        c0 = m2 * m4 - m3 * m3
        c1 = m2 * m3 - m1 * m4
        c2 = m1 * m3 - m2 * m2
        determinant = m0 * c0 + m1 * c1 + m2 * c2
        fits.append((determinant, LEAST_CONDITION * m0 * m2 * m4, [c0, c1, c2]))
    best: Scalars = [0.0, m0, 1.0, 0.0, 0.0]
    for degree, (determinant, least, column) in enumerate(fits, start=1):
        best = choose_each(determinant, least, [float(degree), determinant, *column], best)
    allowed, determinant, *cofactors = best
    return allowed, determinant, cofactors[: highest + 1]


def _gains(cofactors: Sequence[Scalar], scale: Scalar, rate: Scalar) -> Scalars:
    """Gains of the value and of its derivatives.

    They are the first column of the inverse of the Hankel matrix of the moments, times the weight
    of the newest sample; d/dt = -lambda d/d(age) turns coefficients of powers of age into
    derivatives.

    Args:
        cofactors: cofactors of the first column.
        scale: weight of the newest sample over the determinant.
        rate: lambda [1/s].
    """
    c0, c1, *higher = cofactors
    first = -rate * scale * c1
    return scale * c0, first, *(2.0 * rate * rate * scale * c2 for c2 in higher)


def _moved(derivatives: Scalars, dt: Scalar) -> Scalars:
    """The polynomial, shifted by `dt` [s]."""
    value, first, *higher = derivatives
    if not higher:
        return value + dt * first, first
    (second,) = higher
    return value + dt * first + 0.5 * dt * dt * second, first + dt * second, second


@dataclass(frozen=True)
class PolynomialFilter(RateFilter):
    """Fading-memory polynomial filter of degree 1 or 2.

    Attributes:
        degree: highest derivative that is estimated, 1 or 2.
        bandwidth: frequency where the highest derivative has lost 3 dB, 1e-12 or more [Hz].
        max_gap: gaps longer than this restart the filter [s].
    """

    degree: int
    bandwidth: float
    max_gap: float

    def __post_init__(self) -> None:
        if self.degree not in (1, 2):
            raise ValueError(f"degree is {self.degree}, expected 1 or 2")
        require_positive("bandwidth", self.bandwidth)
        if self.bandwidth < LEAST_BANDWIDTH:
            raise ValueError(
                f"bandwidth is {self.bandwidth} Hz, expected {LEAST_BANDWIDTH} Hz or more"
            )
        self.prepare()

    @cached_property
    def rate(self) -> float:
        """lambda, the decay rate of weights [1/s]."""
        return 2.0 * math.pi * self.bandwidth / math.sqrt(2.0 ** (1.0 / (self.degree + 1)) - 1.0)

    @cached_property
    def lag(self) -> float:
        """Delay of the highest derivative for slow signals and dense samples [s]."""
        return (self.degree + 1) / self.rate

    @property
    def steps(self) -> tuple[Steps, ...]:
        """The formulas of the degree, for one channel."""
        return (PolynomialSteps(self.degree),)

    @property
    def constants(self) -> tuple[float, ...]:
        """lambda [1/s]."""
        return (self.rate,)

    def first_memory(self, channels: int) -> tuple[float, ...]:  # noqa: ARG002
        """Zeros: no interval yet."""
        return (0.0,) * 6

    def is_good(self, elapsed: Condition, quality: Condition) -> Condition:
        """Whether the filter has enough samples: degree + 1, over at least the lag.

        The polynomial is exact from sample degree + 1 on, but noise is amplified over a short time.
        After one lag it is within a factor of 5 of its steady value.
        """
        return (quality == self.degree) & (elapsed >= self.lag)
