"""Derivatives of sampled signals: causal, for samples at any stamps, exact for polynomials.

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
least-squares fit. Gains depend on stamps alone. All work on samples is elementwise, so joints go
through together, and the bits of one do not depend on the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import formula

FloatArray = NDArray[np.float64]
Moments = tuple[float, float, float, float, float]

# Below it the moments of stamps a nanosecond apart come near the smallest numbers there are.
LEAST_BANDWIDTH: Final = 1e-12  # [Hz]


class StampEvent(Enum):
    """What the stamp of a sample meant to the filter."""

    NEXT = "next"  # went on from the sample before
    FIRST = "first"  # no sample before
    REPEATED = "repeated"  # same stamp and same values: nothing new
    CONFLICT = "conflicting stamp"  # same stamp, other values: restarted
    BACKWARD = "backward stamp"  # earlier than the sample before: restarted
    GAP = "gap"  # later than the largest gap: restarted


class FilterState(NamedTuple):
    """All that the filter remembers.

    Attributes:
        stamp_ns: stamp of the newest sample [ns].
        start_ns: stamp of the first sample since the last restart [ns].
        degree: degree of the polynomial that the samples so far determine.
        moments: weighted sums of age^k, k = 0..4, ages in units of 1/lambda.
        sample: newest sample, (n,).
        derivatives: (D + 1, n), the fitted value and its derivatives at ``stamp_ns`` [unit/s^k];
            rows above ``degree`` are zero.
    """

    stamp_ns: int
    start_ns: int
    degree: int
    moments: Moments
    sample: FloatArray
    derivatives: FloatArray


@dataclass(frozen=True)
class PolynomialFilter:
    """Fading-memory polynomial filter of degree 1 or 2.

    Attributes:
        degree: highest derivative that is estimated, 1 or 2.
        bandwidth: frequency where the highest derivative has lost 3 dB, 1e-12 or more [Hz].
        max_gap: stamps further apart than this restart the filter [s].
    """

    degree: int
    bandwidth: float
    max_gap: float

    def __post_init__(self) -> None:
        if self.degree not in (1, 2):
            raise ValueError(f"degree is {self.degree}, expected 1 or 2")
        for name in ("bandwidth", "max_gap"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} is {value}, expected a finite number above 0")
        if self.bandwidth < LEAST_BANDWIDTH:
            raise ValueError(
                f"bandwidth is {self.bandwidth} Hz, expected {LEAST_BANDWIDTH} Hz or more"
            )

    @cached_property
    def rate(self) -> float:
        """lambda, the rate at which samples are forgotten [1/s]."""
        return 2.0 * math.pi * self.bandwidth / math.sqrt(2.0 ** (1.0 / (self.degree + 1)) - 1.0)

    @cached_property
    def lag(self) -> float:
        """Delay of the highest derivative for slow signals and dense samples [s]."""
        return (self.degree + 1) / self.rate

    def ready(self, state: FilterState) -> bool:
        """Whether the state has its samples: degree + 1 or more, over the lag or longer.

        The polynomial is exact from sample degree + 1 on. Over a short time, though, noise in the
        samples is blown up. After one lag it is within a factor of 5 of what it settles at.
        """
        if state.degree != self.degree:
            return False
        return (state.stamp_ns - state.start_ns) * 1e-9 >= self.lag

    def step(
        self, state: FilterState | None, stamp_ns: int, sample: FloatArray
    ) -> tuple[FilterState, StampEvent]:
        """The state after one more sample.

        Args:
            state: state before, or None at the start. It is not changed.
            stamp_ns: stamp of the sample [ns].
            sample: (n,), finite.

        Returns:
            The new state, and what the stamp meant. Backward stamps, conflicting stamps and gaps
            restart the filter from this sample.
        """
        event = self._event(state, stamp_ns, sample)
        if state is None or event not in (StampEvent.NEXT, StampEvent.REPEATED):
            return self._start(stamp_ns, sample), event
        if event is StampEvent.REPEATED:
            return state, event
        return self._advance(state, stamp_ns, sample), event

    def _event(self, state: FilterState | None, stamp_ns: int, sample: FloatArray) -> StampEvent:
        if state is None:
            return StampEvent.FIRST
        if stamp_ns < state.stamp_ns:
            return StampEvent.BACKWARD
        if stamp_ns == state.stamp_ns:
            return (
                StampEvent.REPEATED if np.array_equal(sample, state.sample) else StampEvent.CONFLICT
            )
        return (
            StampEvent.GAP if (stamp_ns - state.stamp_ns) * 1e-9 > self.max_gap else StampEvent.NEXT
        )

    def _start(self, stamp_ns: int, sample: FloatArray) -> FilterState:
        sample = sample.copy()
        derivatives = np.zeros((self.degree + 1, sample.size))
        derivatives[0] = sample
        # The first sample has no interval before it: it gets its weight from the second.
        return FilterState(stamp_ns, stamp_ns, 0, (0.0, 0.0, 0.0, 0.0, 0.0), sample, derivatives)

    def _advance(self, state: FilterState, stamp_ns: int, sample: FloatArray) -> FilterState:
        dt = (stamp_ns - state.stamp_ns) * 1e-9  # [s]
        moments, gains = self.update(state.moments, dt, min(state.degree + 1, self.degree))
        with np.errstate(all="ignore"):
            rows = formula.corrected(tuple(state.derivatives), dt, gains, sample)
        degree = len(gains) - 1
        return FilterState(stamp_ns, state.start_ns, degree, moments, sample.copy(), np.array(rows))

    def update(self, moments: Moments, dt: float, degree: int) -> tuple[Moments, tuple[float, ...]]:
        """Moments after an interval, and gains of as many derivatives as they allow.

        Args:
            moments: before; zeros after the first sample.
            dt: interval [s].
            degree: highest degree that is looked for.
        """
        step = self.rate * dt
        decay, weight = formula.weights(step)
        if moments[0] == 0.0:  # the first sample has no interval: its weight is that of the second
            moments = (weight, 0.0, 0.0, 0.0, 0.0)
        moments = formula.aged(moments, step, decay, weight)
        determinant, least, cofactors = formula.fit(moments, degree)
        while degree > 0 and not determinant > least:
            degree -= 1
            determinant, least, cofactors = formula.fit(moments, degree)
        return moments, formula.gains(cofactors, weight / determinant, self.rate)
