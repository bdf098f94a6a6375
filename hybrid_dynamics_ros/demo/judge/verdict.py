"""Whether a run went well: nothing lost, and the efforts are those of the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from hybrid_dynamics_core import Robot

from ...messages.joint_samples import FloatArray
from ..expectation import Expectation
from ..topics import EFFORTS, INPUT, POSE, STATES
from .results import JointSeries, Results

# The node calls the model for one state, the check for all at once: rounding differs in the last
# digits.
TOLERANCE: Final = 1e-9
_NAN: Final = float("nan")


@dataclass(frozen=True)
class Verdict:
    """Findings about a run.

    Attributes:
        expected: messages by topic that should have come.
        received: messages by topic that came; one that came twice counts once.
        difference: largest difference of an effort from the model called directly [N m or N]; NaN
            without efforts.
        relative: largest difference within one message over the largest effort in it.
        delay: median and 99 % quantile of the time from sending the input to receiving the efforts
            [s].
    """

    expected: dict[str, int]
    received: dict[str, int]
    difference: float
    relative: float
    delay: tuple[float, float]

    @property
    def lost(self) -> int:
        """Messages of all topics that should have come and did not."""
        return sum(self.expected.values()) - sum(self.received.values())

    @property
    def good(self) -> bool:
        """Whether nothing was lost and the efforts agree."""
        return self.lost == 0 and self.relative <= TOLERANCE


def judge(expected: Expectation, results: Results, robot: Robot) -> Verdict:
    """Compare what was received with what was played, and with the model called directly."""
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
    """Largest difference of an effort, absolute and relative to the largest one of its message."""
    efforts, inputs = results.efforts, results.inputs
    _, rows, origins = np.intersect1d(efforts.stamp_ns, inputs.stamp_ns, return_indices=True)
    _, places, accelerations = np.intersect1d(
        inputs.stamp_ns[origins], expected.stamp_ns, return_indices=True
    )
    rows = rows[places]
    origins = origins[places]
    if rows.size == 0:
        return _NAN, _NAN
    position = _columns(inputs, inputs.position, robot)[origins]
    velocity = _columns(inputs, inputs.velocity, robot)[origins]
    state = robot.close(position, velocity)
    tau = robot.inverse_dynamics(state, expected.acceleration[accelerations])
    errors = np.abs(_columns(efforts, efforts.effort, robot)[rows] - tau)
    relative = errors.max(axis=1) / np.abs(tau).max(axis=1)
    return float(errors.max()), float(relative.max())


def _columns(series: JointSeries, table: FloatArray, robot: Robot) -> FloatArray:
    """Columns of the active joints in the robot's order."""
    columns: FloatArray = table[:, [series.names.index(name) for name in robot.active]]
    return columns


def _delay(results: Results) -> tuple[float, float]:
    """Median and 99 % quantile of the time from sending the input to receiving the efforts [s]."""
    inputs, efforts = results.inputs, results.efforts
    _, asked, answered = np.intersect1d(inputs.stamp_ns, efforts.stamp_ns, return_indices=True)
    delays = efforts.log_ns[answered] - inputs.log_ns[asked]
    if delays.size == 0:
        return _NAN, _NAN
    median, late = np.quantile(delays, [0.5, 0.99]) * 1e-9
    return float(median), float(late)
