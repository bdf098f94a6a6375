"""Motion between readings: accelerations that forget themselves, after Singer (1970).

An acceleration is a random process with a deviation and a correlation time:
u''' = -u''/time + white noise. Its matrices act on [u; u'; u''].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array, frozen

ORDERS = 3  # u, u', u''
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_SHORT = 1e-3  # of the correlation time, below which a power series is more accurate


@dataclass(frozen=True, eq=False)
class MotionModel:
    """How active coordinates may move.

    Attributes:
        accelerations: (n,) deviation of each active acceleration [rad/s^2, m/s^2].
        time: correlation time of the accelerations [s].
    """

    accelerations: Array
    time: float

    def __post_init__(self) -> None:
        if not 0.0 < self.time < math.inf:
            raise InputError(f"correlation time is {self.time:g} s; expected more than zero")
        if not (np.isfinite(self.accelerations).all() and (self.accelerations > 0.0).all()):
            raise InputError(f"accelerations are {self.accelerations}; expected more than zero")

    @property
    def n(self) -> int:
        """Number of active coordinates."""
        return len(self.accelerations)

    def transition(self, step: float) -> Array:
        """F (3 n, 3 n) of a step [s], which may be negative."""
        return np.asarray(np.kron(_transition(step, self.time), np.eye(self.n)))

    def noise(self, step: float) -> Array:
        """Covariance (3 n, 3 n) of what the motion adds in a step [s]."""
        variances = np.diag(self.accelerations**2)
        return np.asarray(np.kron(_noise(step, self.time), variances))


@lru_cache(maxsize=256)
def _transition(
    step: float,
    time: float,
) -> Array:
    """F (3, 3) of one coordinate."""
    decay, first, second = _responses(step, time)
    return frozen([[1.0, step, second], [0.0, 1.0, first], [0.0, 0.0, decay]])


def _responses(
    step: float,
    time: float,
) -> tuple[float, float, float]:
    """u'', u' and u after a step that starts with u'' = 1."""
    ratio = step / time
    decay = math.exp(-ratio)
    if abs(ratio) < _SHORT:
        first = step * (1.0 - ratio / 2.0 + ratio**2 / 6.0)
        second = step**2 * (0.5 - ratio / 6.0 + ratio**2 / 24.0)
        return decay, first, second
    change = math.expm1(-ratio)
    return decay, -time * change, time**2 * (change + ratio)


@lru_cache(maxsize=256)
def _noise(
    step: float,
    time: float,
) -> Array:
    """Covariance (3, 3) of one coordinate with a deviation of 1."""
    if step > time:  # two halves
        half = _noise(step / 2.0, time)
        transition = _transition(step / 2.0, time)
        return frozen(transition @ half @ transition.T + half)
    total = np.zeros((ORDERS, ORDERS))
    for node, weight in zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True):
        response = np.array(_responses(step * (node + 1.0) / 2.0, time)[::-1])
        total += weight * np.outer(response, response)
    density = 2.0 / time
    return frozen(density * step / 2.0 * total)
