"""The formulas of the filter: one text for floats, arrays, and doubles of compiled code.

A scalar here is a float, an array with one entry a joint, or a `doubles.Double`. All three round
after every operation, in the same order, so they agree to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

Scalar = Any  # float | NDArray[float64] | doubles.Double

# The memory is never shorter than about one sample interval: older samples keep at least this share
# of their weight at each step. Where the bandwidth is too high for the sample rate, the filter
# becomes the finite difference of the last D + 1 samples and not less.
LEAST_DECAY: Final = 0.1
MOST_WEIGHT: Final = 1.0 - LEAST_DECAY

# The degree is raised only when the fit is well conditioned: determinant over product of the
# diagonal. Two stamps that almost coincide say nothing about a second derivative.
LEAST_CONDITION: Final = 1e-9


def weights(step: Scalar) -> tuple[Scalar, Scalar]:
    """What older samples keep of their weight after a step, and the weight of the new sample.

    A sample stands for the interval before it: the bandwidth does not depend on the sample rate.
    Both add up to 1; the difference itself would lose the weight of a very short step.

    Args:
        step: interval in units of 1/lambda.
    """
    back = -step
    if isinstance(back, float):
        return max(math.exp(back), LEAST_DECAY), min(-math.expm1(back), MOST_WEIGHT)
    return back.exp().at_least(LEAST_DECAY), (-back.expm1()).at_most(MOST_WEIGHT)


def aged(
    moments: Sequence[Scalar], step: Scalar, decay: Scalar, weight: Scalar
) -> tuple[Scalar, Scalar, Scalar, Scalar, Scalar]:
    """Moments after a step and a new sample of age 0: binomial shift of the ages.

    Args:
        moments: weighted sums of age^k, k = 0..4, ages in units of 1/lambda.
        step: interval in units of 1/lambda.
        decay: what older samples keep of their weight.
        weight: of the new sample.
    """
    m0, m1, m2, m3, m4 = moments
    return (
        decay * m0 + weight,
        decay * (m1 + step * m0),
        decay * (m2 + step * (2.0 * m1 + step * m0)),
        decay * (m3 + step * (3.0 * m2 + step * (3.0 * m1 + step * m0))),
        decay * (m4 + step * (4.0 * m3 + step * (6.0 * m2 + step * (4.0 * m1 + step * m0)))),
    )


def fit(moments: Sequence[Scalar], degree: int) -> tuple[Scalar, Scalar, tuple[Scalar, ...]]:
    """Determinant of the Hankel matrix of the moments, its least value, and cofactors.

    The moments allow the degree where the determinant is larger than its least value. The cofactors
    are those of the first column.
    """
    m0, m1, m2, m3, m4 = moments
    if degree == 0:
        return m0, 0.0, (1.0,)
    if degree == 1:
        return m0 * m2 - m1 * m1, LEAST_CONDITION * m0 * m2, (m2, m1)
    c0 = m2 * m4 - m3 * m3
    c1 = m2 * m3 - m1 * m4
    c2 = m1 * m3 - m2 * m2
    return m0 * c0 + m1 * c1 + m2 * c2, LEAST_CONDITION * m0 * m2 * m4, (c0, c1, c2)


def gains(cofactors: Sequence[Scalar], scale: Scalar, rate: Scalar) -> tuple[Scalar, ...]:
    """Gains of the value and of its derivatives.

    They are the first column of the inverse of the Hankel matrix of the moments, times the weight
    of the newest sample; d/dt = -lambda d/d(age) turns coefficients of powers of age into
    derivatives.

    Args:
        cofactors: of the first column.
        scale: weight of the newest sample over the determinant.
        rate: lambda [1/s].
    """
    if len(cofactors) == 3:
        c0, c1, c2 = cofactors
        return scale * c0, -rate * scale * c1, 2.0 * rate * rate * scale * c2
    if len(cofactors) == 2:
        c0, c1 = cofactors
        return scale * c0, rate * scale * c1
    return (scale * cofactors[0],)


def corrected(
    derivatives: Sequence[Scalar], dt: Scalar, factors: Sequence[Scalar], sample: Scalar
) -> tuple[Scalar, ...]:
    """Value and derivatives after one more sample: the polynomial moved to it, and corrected.

    Args:
        derivatives: at the sample before, two or three of them.
        dt: interval [s].
        factors: the `gains`; derivatives beyond them are not corrected.
        sample: the new value.
    """
    moved = _moved(derivatives, dt)
    error = sample - moved[0]
    count = len(factors)
    better = [value + gain * error for value, gain in zip(moved, factors, strict=False)]
    return (*better, *moved[count:])


def _moved(derivatives: Sequence[Scalar], dt: Scalar) -> tuple[Scalar, ...]:
    """The polynomial, seen `dt` [s] later."""
    if len(derivatives) == 2:
        value, first = derivatives
        return value + dt * first, first
    value, first, second = derivatives
    return value + dt * first + 0.5 * dt * dt * second, first + dt * second, second
