"""Velocities and accelerations of the measured joints, from the fields of a JointState.

Velocities of a message are used unchanged. Accelerations, and missing velocities, come from filters
(`routes`).
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.ground.check_arrays import all_finite

from ...messages.joint_samples import RejectedError, RejectionCode
from .filter import FilterState, StampEvent
from .recursion import FloatArray
from .routes import Kalman, Route, kalman_routes, polynomial_routes

Mask = NDArray[np.bool_]


class Estimate(NamedTuple):
    """Rates of the measured joints at one stamp; None if the filter lacks samples.

    Attributes:
        velocity: (n,) [rad/s or m/s], measured or estimated.
        acceleration: (n,) [rad/s^2 or m/s^2].
        event: event of the stamp.
    """

    velocity: FloatArray | None
    acceleration: FloatArray | None
    event: StampEvent


class EstimatorState(NamedTuple):
    """State of the estimator after a sample.

    Attributes:
        from_velocities: whether the newest sample had velocities.
        filter: state of its filter.
    """

    from_velocities: bool
    filter: FilterState


@dataclass(eq=False)
class RateRows:
    """Rates of N samples, one row each.

    Attributes:
        velocity: (N, n) [rad/s or m/s]; zero if unknown.
        has_velocity: mask (N,) of known velocities.
        acceleration: (N, n) [rad/s^2 or m/s^2]; NaN if unknown.
        has_acceleration: mask (N,) of known accelerations.
        events: number of stamps by event.
        state: state of the estimator after the last sample; None for given rates.
    """

    velocity: FloatArray
    has_velocity: Mask
    acceleration: FloatArray
    has_acceleration: Mask
    events: Counter[StampEvent]
    state: Any

    @staticmethod
    def given(velocity: FloatArray, acceleration: FloatArray) -> RateRows:
        """Make rates from given velocities and accelerations."""
        every = np.ones(len(velocity), dtype=bool)
        return RateRows(velocity, every, acceleration, every, Counter(), None)

    def part(self, rows: NDArray[np.intp] | slice) -> RateRows:
        """The rates of some rows, without events and state."""
        return RateRows(
            self.velocity[rows],
            self.has_velocity[rows],
            self.acceleration[rows],
            self.has_acceleration[rows],
            Counter(),
            None,
        )

    def at(self, place: slice | int) -> tuple[FloatArray | None, FloatArray | None]:
        """Velocity and acceleration of one sample, or of a run of `runs`.

        They are None if unknown.
        """
        first = place.start if isinstance(place, slice) else place
        velocity = self.velocity[place] if self.has_velocity[first] else None
        acceleration = self.acceleration[place] if self.has_acceleration[first] else None
        return velocity, acceleration

    def runs(self) -> Iterator[slice]:
        """Runs of consecutive rows with the same known rates."""
        return _runs(2 * self.has_velocity.astype(np.int8) + self.has_acceleration)


class MotionEstimator:
    """Estimator of rates, for single samples or batches.

    Messages with and without velocities may alternate. If each kind has its own filter, a change
    restarts the estimation.

    Attributes:
        bandwidth: bandwidth of polynomial filters, and of smoothing of recordings [Hz].
        max_gap: gaps longer than this restart the estimation [s].
    """

    def __init__(self, bandwidth: float, max_gap: float, kalman: Kalman | None = None) -> None:
        """Make an estimator with polynomial filters, or with a Kalman filter.

        Raises:
            ValueError: a number is not positive.
        """
        self.bandwidth, self.max_gap = bandwidth, max_gap
        if kalman is None:
            self._routes = polynomial_routes(bandwidth, max_gap)
        else:
            self._routes = kalman_routes(kalman, max_gap)

    @property
    def takes_turns(self) -> bool:
        """Whether samples with and without velocities go through the same filter."""
        without, having = self._routes
        return without.filter is having.filter

    def lag(self, *, measured: bool) -> float:
        """Lag of accelerations [s], from measured velocities or from positions."""
        return self._routes[measured].filter.lag

    def step(
        self,
        state: EstimatorState | None,
        stamp_ns: int,
        position: FloatArray,
        velocity: FloatArray | None,
    ) -> tuple[EstimatorState, Estimate]:
        """State and estimate after one more sample.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamp_ns: stamp [ns].
            position: (n,) [rad or m].
            velocity: (n,) [rad/s or m/s], or None if not measured.

        Raises:
            RejectedError: estimated rates are not finite.
        """
        measured = velocity is not None
        route, before = self._route(state, measured)
        samples = route.samples(position, velocity)
        after, event = route.filter.step(before, stamp_ns, samples)
        derivatives = after.derivatives
        if not all_finite(derivatives):
            raise _overflow()
        acceleration = None
        if route.filter.ready(after):
            acceleration = derivatives[route.acceleration]
            if velocity is None:
                velocity = derivatives[1]
        return EstimatorState(measured, after), Estimate(velocity, acceleration, event)

    def run(
        self,
        state: EstimatorState | None,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
        measured: Mask,
    ) -> RateRows:
        """Results of `step` for N consecutive samples.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamps: (N,) [ns].
            position: (N, n) [rad or m].
            velocity: (N, n) [rad/s or m/s], used where measured.
            measured: mask (N,) of samples with velocities.

        Raises:
            RejectedError: estimated rates are not finite.
        """
        count, n = position.shape
        rates = RateRows(
            velocity=np.where(measured[:, None], velocity, 0.0),
            has_velocity=measured.copy(),
            acceleration=np.full((count, n), np.nan),
            has_acceleration=np.zeros(count, dtype=bool),
            events=Counter(),
            state=state,
        )
        for rows in _runs(measured.astype(np.int8)):
            self._run(rates, rows, stamps[rows], position[rows])
        return rates

    def _run(
        self, rates: RateRows, rows: slice, stamps: NDArray[np.int64], position: FloatArray
    ) -> None:
        """Set the rates of one run of samples of one kind.

        Args:
            rates: rates of all samples; its `state` is advanced over the run.
            rows: rows of the run.
            stamps: (k,) stamps of the run [ns].
            position: (k, n) positions of the run [rad or m].
        """
        measured = bool(rates.has_velocity[rows.start])
        route, before = self._route(rates.state, measured)
        samples = route.samples(position, rates.velocity[rows])
        derivatives, ready, events, after = route.filter.run(before, stamps, samples)
        if not np.isfinite(derivatives).all():
            raise _overflow()
        is_ready = ready[:, None]
        if not measured:
            rates.velocity[rows] = np.where(is_ready, derivatives[:, 1], 0.0)
            rates.has_velocity[rows] = ready
        rates.acceleration[rows] = np.where(is_ready, derivatives[:, route.acceleration], np.nan)
        rates.has_acceleration[rows] = ready
        rates.events += events
        rates.state = EstimatorState(measured, after)

    def _route(
        self, state: EstimatorState | None, measured: bool
    ) -> tuple[Route, FilterState | None]:
        """The route of samples of a kind, and the previous state of its filter.

        The state is None if another filter processed the samples before.
        """
        route = self._routes[measured]
        if state is None or self._routes[state.from_velocities].filter is not route.filter:
            return route, None
        return route, state.filter


def _overflow() -> RejectedError:
    return RejectedError(
        RejectionCode.OVERFLOW, "estimated rates of the measured joints are not finite"
    )


def _runs(kinds: NDArray[np.int8]) -> Iterator[slice]:
    """Runs of equal entries, in order."""
    edges = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
    return (slice(start, end) for start, end in itertools.pairwise(edges) if start < end)
