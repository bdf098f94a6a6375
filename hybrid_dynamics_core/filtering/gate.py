"""Quantiles of the chi-squared distribution, and the update with a gate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np

from ..ground.arrays import Array
from .belief import Belief, Layout, moved
from .second_order import second_order
from .sensors import Sensor

GATE = 0.99999  # share of good readings that pass


@lru_cache(maxsize=128)
def chi_squared(
    share: float,
    freedoms: int,
) -> float:
    """Quantile of the chi-squared distribution, by bisection of its incomplete gamma function."""
    centre = NormalDist().inv_cdf(share)
    share_of_one = 2.0 / (9.0 * freedoms)
    root = 1.0 - share_of_one + centre * math.sqrt(share_of_one)
    guess = freedoms * max(root, 0.0) ** 3
    low, high = 0.0, 2.0 * guess + 1.0
    while high - low > 1e-12 * high:
        middle = (low + high) / 2.0
        if _below(middle, freedoms) < share:
            low = middle
        else:
            high = middle
    return low


def _below(
    value: float,
    freedoms: int,
) -> float:
    """Probability of less than a value, by the series of the incomplete gamma function."""
    shape = freedoms / 2.0
    x = value / 2.0
    if x <= 0.0:
        return 0.0
    term = math.exp(shape * math.log(x) - x - math.lgamma(shape + 1.0))
    total = term
    k = 1
    while term > 1e-17 * total or k < x:
        term *= x / (shape + k)
        total += term
        k += 1
    return total


@dataclass(frozen=True, eq=False)
class Innovation:
    """A reading against what was expected.

    Attributes:
        sensor: name of the sensor.
        time: [s].
        change: (k,) reading less the expected one.
        expected: (k,) the expected reading, without the constant error.
        covariance: (k, k) of the change.
        distance: squared Mahalanobis distance.
        is_used: whether it passed the gate.
    """

    sensor: str
    time: float
    change: Array
    expected: Array
    covariance: Array
    distance: float
    is_used: bool


def updated(
    layout: Layout,
    belief: Belief,
    sensor: Sensor,
    values: Array,
    share: float = GATE,
) -> tuple[Belief, Innovation]:
    """The belief after a reading, unless the reading is beyond the gate.

    Args:
        layout: places of the error state.
        belief: the belief at the time of the reading.
        sensor: the sensor.
        values: (k,) its reading.
        share: share of good readings that pass the gate.
    """
    readings, along_motion = sensor.observe(belief.state, belief.ddu)
    slopes = layout.slopes(sensor, along_motion)
    expected = readings + layout.bias_of(sensor, belief.bias)
    change = sensor.difference(values, expected)
    variance = sensor.quality.noise**2
    along = belief.covariance @ slopes.T
    covariance = slopes @ along
    covariance.flat[:: sensor.channels + 1] += variance
    noise = variance * np.eye(sensor.channels)
    bent = second_order(sensor, belief, belief.rates_covariance)
    if bent is not None:
        change = change - bent.shift
        noise += bent.covariance
        covariance += bent.covariance
    inverse = np.linalg.inv(covariance)
    distance = float(change @ inverse @ change)
    is_used = distance <= chi_squared(share, sensor.channels)
    name, time = sensor.name, belief.time
    innovation = Innovation(name, time, change, readings, covariance, distance, is_used)
    if not is_used:
        return belief, innovation
    gain = along @ inverse
    remaining = -gain @ slopes
    remaining.flat[:: layout.size + 1] += 1.0
    after = remaining @ belief.covariance @ remaining.T + gain @ noise @ gain.T
    return moved(layout, belief, gain @ change, after), innovation
