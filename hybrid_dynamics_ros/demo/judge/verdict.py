"""The verdict on a run: no message lost, and efforts equal to the model's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot

from ...messages.joint_samples import FloatArray
from ..expectation import Expectation
from ..topics import EFFORTS, INPUT, POSE, STATES
from .results import JointSeries, Results

# The node evaluates single states, the check a batch: rounding differs in the last digits.
TOLERANCE: Final = 1e-9
_NAN: Final = float("nan")

Stamps = NDArray[np.int64]


@dataclass(frozen=True)
class Verdict:
    """Received and expected output of a run.

    Attributes:
        expected: number of expected messages by topic.
        received: number of expected messages that arrived, without duplicates.
        difference: largest difference of an effort from the model's [N m or N]; NaN without
            efforts.
        relative: largest difference of a message over its largest effort; NaN without efforts.
        delay: median and 99 % quantile of the time from sending an input to receiving its efforts
            [s].
    """

    expected: dict[str, int]
    received: dict[str, int]
    difference: float
    relative: float
    delay: tuple[float, float]

    @property
    def lost(self) -> int:
        """Number of lost messages of all topics."""
        return sum(self.expected.values()) - sum(self.received.values())

    @property
    def good(self) -> bool:
        """Whether no message was lost and the efforts agree."""
        return self.lost == 0 and self.relative <= TOLERANCE


def judge(expected: Expectation, results: Results, robot: Robot) -> Verdict:
    """Compare the received messages with the expected ones, and with the model."""
    received_stamps = {
        INPUT: results.inputs.stamp_ns,
        STATES: results.states.stamp_ns,
        EFFORTS: results.efforts.stamp_ns,
        POSE: results.pose.stamp_ns,
    }
    expected_counts = {}
    received_counts = {}
    for topic, received in received_stamps.items():
        stamps = expected.stamp_ns
        if topic == EFFORTS:
            stamps = stamps[expected.with_efforts]
        expected_counts[topic] = len(stamps)
        received_counts[topic] = len(np.intersect1d(stamps, received))
    difference, relative = _differences(expected, results, robot)
    return Verdict(expected_counts, received_counts, difference, relative, _delay(results))


def _differences(expected: Expectation, results: Results, robot: Robot) -> tuple[float, float]:
    """Largest difference of an effort, absolute and relative to the largest of its message.

    Inputs, efforts and expected accelerations are matched by stamp.
    """
    efforts, inputs = results.efforts, results.inputs
    stamps = np.intersect1d(efforts.stamp_ns, inputs.stamp_ns)
    stamps = np.intersect1d(stamps, expected.stamp_ns)
    if stamps.size == 0:
        return _NAN, _NAN
    effort_rows = _rows_of(stamps, efforts.stamp_ns)
    input_rows = _rows_of(stamps, inputs.stamp_ns)
    expected_rows = _rows_of(stamps, expected.stamp_ns)
    position = _columns(inputs, inputs.position, robot)[input_rows]
    velocity = _columns(inputs, inputs.velocity, robot)[input_rows]
    state = robot.close(position, velocity)
    tau = robot.inverse_dynamics(state, expected.acceleration[expected_rows])
    errors = np.abs(_columns(efforts, efforts.effort, robot)[effort_rows] - tau)
    relative = errors.max(axis=1) / np.abs(tau).max(axis=1)
    return float(errors.max()), float(relative.max())


def _rows_of(stamps: Stamps, series: Stamps) -> NDArray[np.intp]:
    """The first row of each stamp (k,), ascending, in a series (N,) that contains them."""
    _, _, rows = np.intersect1d(stamps, series, return_indices=True)
    return np.asarray(rows, dtype=np.intp)


def _columns(series: JointSeries, table: FloatArray, robot: Robot) -> FloatArray:
    """The columns (N, n) of the active joints, from a table with the joints of a series."""
    columns: FloatArray = table[:, [series.names.index(name) for name in robot.active]]
    return columns


def _delay(results: Results) -> tuple[float, float]:
    """Median and 99 % quantile of the time from sending an input to receiving its efforts [s]."""
    inputs, efforts = results.inputs, results.efforts
    stamps = np.intersect1d(inputs.stamp_ns, efforts.stamp_ns)
    sent = inputs.log_ns[_rows_of(stamps, inputs.stamp_ns)]
    received = efforts.log_ns[_rows_of(stamps, efforts.stamp_ns)]
    delays = received - sent
    if delays.size == 0:
        return _NAN, _NAN
    median, late = np.quantile(delays, [0.5, 0.99]) * 1e-9
    return float(median), float(late)
