"""The expected output of the node for a recording: numbers of messages, and their stamps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..bags.storage.storage import RawMessage
from ..messages.conversions import stamp_to_ns
from ..messages.interfaces import deserialize
from ..messages.joint_samples import FloatArray
from ..stream.filter.rate_estimator import EstimatorState, MotionEstimator
from .topics import EFFORTS, INPUT, POSE, STATES, TYPES


@dataclass(frozen=True, eq=False)
class Expectation:
    """The expected output for a recording.

    Attributes:
        stamp_ns: header stamps of the input (N,) [ns].
        acceleration: (N, n) estimate of the node's filter [rad/s^2 or m/s^2]. Rows are NaN while it
            is filling, when the node sends no efforts.
    """

    stamp_ns: NDArray[np.int64]
    acceleration: FloatArray

    @property
    def with_efforts(self) -> NDArray[np.bool_]:
        """Mask (N,) of inputs that lead to efforts."""
        return np.asarray(np.isfinite(self.acceleration).all(axis=1))

    @property
    def counts(self) -> dict[str, int]:
        """Number of messages on each topic."""
        total = len(self.stamp_ns)
        return {INPUT: total, STATES: total, EFFORTS: int(self.with_efforts.sum()), POSE: total}

    @property
    def duration(self) -> float:
        """Time from the first to the last stamp [s]."""
        return float(self.stamp_ns[-1] - self.stamp_ns[0]) * 1e-9


def expect(messages: Sequence[RawMessage], bandwidth: float, max_gap: float) -> Expectation:
    """The expected output for JointState messages with velocities.

    Args:
        messages: the recording.
        bandwidth: bandwidth of the node's acceleration filter [Hz].
        max_gap: largest gap of the node's acceleration filter [s].
    """
    estimator = MotionEstimator(bandwidth, max_gap)
    state: EstimatorState | None = None
    stamps: list[int] = []
    accelerations: list[FloatArray] = []
    for raw in messages:
        message = deserialize(raw.data, TYPES[INPUT])
        stamp_ns = stamp_to_ns(message.header.stamp)
        state, estimate = estimator.step(state, stamp_ns, message.position, message.velocity)
        acceleration = estimate.acceleration
        if acceleration is None:
            acceleration = np.full(len(message.velocity), np.nan)
        stamps.append(stamp_ns)
        accelerations.append(acceleration)
    return Expectation(np.array(stamps, dtype=np.int64), np.array(accelerations))
