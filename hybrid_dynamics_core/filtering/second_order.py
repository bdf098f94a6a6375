"""What rates that are not yet determined do to accelerometers, which are quadratic in them.

Without it, a filter that starts in motion trusts accelerometers too much (second-order Kalman
filter, Athans et al. 1968).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from .belief import Belief
from .sensors import Kind, Sensor

LEVER = 10.0  # [m] from a joint to a sensor, at most: below this effect of rates it is left out


class SecondOrder(NamedTuple):
    """The second-order part of a reading.

    Attributes:
        shift: (k,) its mean.
        covariance: (k, k).
    """

    shift: Array
    covariance: Array


def second_order(
    sensor: Sensor,
    belief: Belief,
    rates: Array,
) -> SecondOrder | None:
    """The second-order part of a reading along rates; None where it does not matter.

    Args:
        sensor: the sensor.
        belief: the belief at the time of the reading.
        rates: covariance (n, n) of the active rates.
    """
    if sensor.kind is not Kind.ACCELEROMETER:
        return None
    largest = float(np.diagonal(rates).max())
    if LEVER * largest < sensor.quality.noise:
        return None
    bent = sensor.curvature(belief.state, belief.ddu) @ rates
    shift = 0.5 * np.trace(bent, axis1=1, axis2=2)
    covariance = 0.5 * np.einsum("iab,jba->ij", bent, bent)
    return SecondOrder(shift, covariance)
