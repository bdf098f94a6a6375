"""The two estimators of rates that can be chosen: which filters samples go through.

Samples with and without velocities are two kinds of sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from .filter import RateFilter
from .kalman import KalmanFilter
from .polynomial import PolynomialFilter
from .recursion import FloatArray


class Taken(Enum):
    """What a filter takes of a sample."""

    POSITION = "position"
    VELOCITY = "velocity"
    BOTH = "both"


class Route(NamedTuple):
    """How samples of one kind go through a filter.

    Attributes:
        filter: the filter.
        takes: what it takes of a sample: positions, velocities or both.
        acceleration: which of its derivatives is the acceleration.
    """

    filter: RateFilter
    takes: Taken
    acceleration: int

    def samples(self, position: FloatArray, velocity: FloatArray | None) -> FloatArray:
        """What the filter takes, (..., channels, n), of position and velocity (..., n)."""
        if velocity is None or self.takes is Taken.POSITION:
            return position[..., None, :]
        if self.takes is Taken.VELOCITY:
            return velocity[..., None, :]
        return np.array((position, velocity)).swapaxes(0, -2)


@dataclass(frozen=True)
class Kalman:
    """Settings of the Kalman filter.

    Attributes:
        bandwidth: frequency where accelerations from dense positions have lost 3 dB [Hz].
        velocity_noise: deviation of measured velocities over that of positions [1/s].
    """

    bandwidth: float
    velocity_noise: float


def polynomial_routes(bandwidth: float, max_gap: float) -> tuple[Route, Route]:
    """Routes of samples without velocities and of those with them, each with its own filter.

    A polynomial of degree 2 is fitted to positions, or one of degree 1 to velocities, which count
    as exact.

    Args:
        bandwidth: frequency where accelerations from dense samples have lost 3 dB [Hz].
        max_gap: stamps further apart than this restart a filter [s].
    """
    of_positions = PolynomialFilter(2, bandwidth, max_gap)
    of_velocities = PolynomialFilter(1, bandwidth, max_gap)
    return Route(of_positions, Taken.POSITION, 2), Route(of_velocities, Taken.VELOCITY, 1)


def kalman_routes(settings: Kalman, max_gap: float) -> tuple[Route, Route]:
    """The same through one filter of positions, and of velocities where there are some.

    Samples with and without velocities may take turns.
    """
    filt = KalmanFilter(settings.bandwidth, settings.velocity_noise, max_gap)
    return Route(filt, Taken.POSITION, 2), Route(filt, Taken.BOTH, 2)
