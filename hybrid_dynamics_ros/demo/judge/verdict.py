"""Whether a run went well: nothing lost, and the efforts are those of the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot

from ..expectation import Expectation
from ..topics import EFFORTS, INPUT, POSE, STATES
from .results import FloatArray, IntArray, JointSeries, Results

# The node calls the model for one state, the check for all at once: rounding differs in the last
# digits.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Verdict:
    """Findings about a run.

    Attributes:
        expected, received: messages by topic; a message that came twice counts once.
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
        return sum(self.expected[topic] - self.received[topic] for topic in self.expected)

    @property
    def good(self) -> bool:
        """Whether nothing was lost and the efforts agree."""
        return self.lost == 0 and self.relative <= TOLERANCE


def judge(expected: Expectation, results: Results, robot: Robot) -> Verdict:
    """Compare what was received with what was played and with the model called directly."""
    with_efforts = expected.stamp_ns[expected.with_efforts]
    wanted = {
        INPUT: expected.stamp_ns,
        STATES: expected.stamp_ns,
        EFFORTS: with_efforts,
        POSE: expected.stamp_ns,
    }
    stamps = {
        INPUT: results.inputs.stamp_ns,
        STATES: results.states.stamp_ns,
        EFFORTS: results.efforts.stamp_ns,
        POSE: results.pose.stamp_ns,
    }
    difference, relative = _differences(expected, results, robot)
    return Verdict(
        expected={topic: len(wanted[topic]) for topic in wanted},
        received={topic: len(np.intersect1d(wanted[topic], stamps[topic])) for topic in wanted},
        difference=difference,
        relative=relative,
        delay=_delay(results),
    )


def _differences(expected: Expectation, results: Results, robot: Robot) -> tuple[float, float]:
    """Largest difference of an effort, absolute and relative to the largest of its message."""
    efforts, inputs = results.efforts, results.inputs
    _, rows, origins = np.intersect1d(efforts.stamp_ns, inputs.stamp_ns, return_indices=True)
    _, places, accelerations = np.intersect1d(
        inputs.stamp_ns[origins], expected.stamp_ns, return_indices=True
    )
    rows, origins = rows[places], origins[places]
    if rows.size == 0:
        return float("nan"), float("nan")
    state = robot.close(
        _columns(inputs, inputs.position, robot)[origins],
        _columns(inputs, inputs.velocity, robot)[origins],
    )
    tau = robot.inverse_dynamics(state, expected.acceleration[accelerations])
    errors = np.abs(_columns(efforts, efforts.effort, robot)[rows] - tau)
    return float(errors.max()), float((errors.max(axis=1) / np.abs(tau).max(axis=1)).max())


def _columns(series: JointSeries, table: FloatArray, robot: Robot) -> FloatArray:
    """Columns of the active joints in the robot's order."""
    columns: FloatArray = table[:, [series.names.index(name) for name in robot.active]]
    return columns


def _delay(results: Results) -> tuple[float, float]:
    """Median and 99 % quantile of the time from sending the input to receiving the efforts [s]."""
    delays = _delays(results.inputs.stamp_ns, results.inputs.log_ns, results.efforts)
    if delays.size == 0:
        return float("nan"), float("nan")
    median, late = np.quantile(delays, [0.5, 0.99]) * 1e-9
    return float(median), float(late)


def _delays(stamp_ns: IntArray, log_ns: IntArray, answers: JointSeries) -> NDArray[np.int64]:
    _, asked, answered = np.intersect1d(stamp_ns, answers.stamp_ns, return_indices=True)
    return answers.log_ns[answered] - log_ns[asked]
