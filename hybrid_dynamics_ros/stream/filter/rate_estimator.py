"""Velocities and accelerations of the active joints, from what a JointState carries.

Messages with velocities: the velocities are taken as measured, the acceleration is the derivative
of a polynomial of degree 1 through them. Messages without: both come from a polynomial of degree 2
through the positions.
"""

from __future__ import annotations

from typing import NamedTuple

from .compiled import CompiledFilter
from .filter import FilterState, FloatArray, StampEvent


class Estimate(NamedTuple):
    """Rates of the active joints at one stamp; None where the filter has not its samples yet.

    Attributes:
        velocity: (n,) [rad/s or m/s], measured or estimated.
        acceleration: (n,) [rad/s^2 or m/s^2].
        event: what the stamp meant to the filter.
    """

    velocity: FloatArray | None
    acceleration: FloatArray | None
    event: StampEvent


class EstimatorState(NamedTuple):
    """State of the filter, and whether it runs on velocities or on positions."""

    from_velocities: bool
    filter: FilterState


class MotionEstimator:
    """Chooses the filter for each sample; a change between the two kinds of message starts anew."""

    def __init__(self, bandwidth: float, max_gap: float) -> None:
        """Bandwidth [Hz] and largest gap [s], as in :class:`filters.PolynomialFilter`."""
        self._velocity_filter = CompiledFilter(1, bandwidth, max_gap)
        self._position_filter = CompiledFilter(2, bandwidth, max_gap)

    def lag(self, *, measured: bool) -> float:
        """How late accelerations are [s]: from velocities that are measured, or from positions alone."""
        return (self._velocity_filter if measured else self._position_filter).lag

    def step(
        self,
        state: EstimatorState | None,
        stamp_ns: int,
        position: FloatArray,
        velocity: FloatArray | None,
    ) -> tuple[EstimatorState, Estimate]:
        """State and estimate after one more sample.

        Args:
            state: state before, or None at the start; it is not changed.
            stamp_ns: stamp [ns].
            position: (n,) [rad or m].
            velocity: (n,) [rad/s or m/s], or None where it was not measured.
        """
        measured = velocity is not None
        before = state.filter if state is not None and state.from_velocities == measured else None
        filt = self._velocity_filter if measured else self._position_filter
        after, event = filt.step(before, stamp_ns, position if velocity is None else velocity)
        ready = filt.ready(after)
        if velocity is None and ready:
            velocity = after.derivatives[1]
        acceleration = after.derivatives[filt.degree] if ready else None
        return EstimatorState(measured, after), Estimate(velocity, acceleration, event)
