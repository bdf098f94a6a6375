"""The shortest move of one coordinate from rest to rest within a rate, an acceleration and a jerk.

It has up to seven segments of constant jerk (double S), in closed form.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array


class Ramp(NamedTuple):
    """A move in segments of constant jerk.

    Attributes:
        times: (8,) starts of the segments, and the end [s].
        jerks: (7,) jerk in each.
        states: (8, 3) position, rate and acceleration at `times`.
    """

    times: Array
    jerks: Array
    states: Array

    @property
    def duration(self) -> float:
        """[s]."""
        return float(self.times[-1])

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, rate and acceleration (N,) at times (N,) of the move [s]."""
        k = np.clip(
            np.searchsorted(self.times, t, side="right") - 1,
            0,
            6,
        )
        x, v, a = np.moveaxis(
            self.states[k],
            -1,
            0,
        )
        tau = t - self.times[k]
        jerk = self.jerks[k]
        acceleration = a + jerk * tau
        rate = v + a * tau + jerk * tau**2 / 2.0
        position = x + v * tau + a * tau**2 / 2.0 + jerk * tau**3 / 6.0
        return position, rate, acceleration


def ramp(
    way: float,
    rate: float,
    acceleration: float,
    jerk: float,
) -> Ramp:
    """The shortest move over a way from rest to rest.

    Args:
        way: above zero.
        rate: largest rate [1/s of the way's unit].
        acceleration: largest acceleration.
        jerk: largest jerk.
    """
    fastest = min(rate, _reachable(way, acceleration, jerk))
    strongest = min(acceleration, np.sqrt(fastest * jerk))
    bend = strongest / jerk
    push = max(fastest / strongest - bend, 0.0)  # rounding may put it below
    cruise = max(way / fastest - 2.0 * bend - push, 0.0)
    spans = np.array([bend, push, bend, cruise, bend, push, bend])
    jerks = jerk * np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])
    states = np.zeros((8, 3))
    for k, (span, constant) in enumerate(zip(spans, jerks, strict=True)):
        x, v, a = states[k]
        states[k + 1] = [
            x + v * span + a * span**2 / 2.0 + constant * span**3 / 6.0,
            v + a * span + constant * span**2 / 2.0,
            a + constant * span,
        ]
    times = np.append(0.0, np.cumsum(spans))
    return Ramp(times, jerks, states)


def _reachable(way: float, acceleration: float, jerk: float) -> float:
    """The rate that is reached half-way."""
    lag = acceleration / jerk
    with_push = 0.5 * acceleration * (np.sqrt(lag**2 + 4.0 * way / acceleration) - lag)
    if with_push * jerk >= acceleration**2:
        return float(with_push)
    return float((way**2 * jerk / 4.0) ** (1.0 / 3.0))
