"""Routes of samples through filters, for the two estimators of rates.

Samples with and without velocities are two kinds.
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
    """The part of a sample that a filter uses."""

    POSITION = "position"
    VELOCITY = "velocity"
    BOTH = "both"


class Route(NamedTuple):
    """The route of one kind of samples.

    Attributes:
        filter: the filter.
        takes: part of a sample that it uses: positions, velocities or both.
        acceleration: index of the acceleration in its derivatives.
    """

    filter: RateFilter
    takes: Taken
    acceleration: int

    def samples(self, position: FloatArray, velocity: FloatArray | None) -> FloatArray:
        """Input of the filter (..., channels, n), from position and velocity (..., n)."""
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
    """Routes of samples without and with velocities, each with its own filter.

    Polynomials of degree 2 are fitted to positions, and of degree 1 to velocities, which count as
    exact.

    Args:
        bandwidth: frequency where accelerations from dense samples have lost 3 dB [Hz].
        max_gap: gaps longer than this restart a filter [s].
    """
    of_positions = PolynomialFilter(2, bandwidth, max_gap)
    of_velocities = PolynomialFilter(1, bandwidth, max_gap)
    return Route(of_positions, Taken.POSITION, 2), Route(of_velocities, Taken.VELOCITY, 1)


def kalman_routes(settings: Kalman, max_gap: float) -> tuple[Route, Route]:
    """Routes of samples without and with velocities through one Kalman filter.

    Both kinds may alternate.
    """
    filt = KalmanFilter(settings.bandwidth, settings.velocity_noise, max_gap)
    return Route(filt, Taken.POSITION, 2), Route(filt, Taken.BOTH, 2)
