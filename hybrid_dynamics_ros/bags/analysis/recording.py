"""A recording with results of the model, as arrays, for reports and identification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Robot

from ...messages.joint_samples import FloatArray
from ...stream.limit_margins import beyond_in_rows
from ...stream.pipeline import Counts
from ...stream.stroke_margins import StrokeMargins
from ..batch_outputs import NODE
from ..job import CAUSAL
from ..sample_outliers import SampleOutlier
from .error_statistics import ErrorStatistics
from .stamp_intervals import StampIntervals

COMPUTED: Final = f"{NODE}/joint_states"  # the node's output, whose efforts are computed
_SMOOTHERS: Final = {"spline": "a spline", "savgol": "a Savitzky-Golay filter"}


@dataclass(eq=False)
class EvaluatedRecording:
    """Some samples of a recording with results of the model, in order.

    Attributes:
        robot: the robot of the computation.
        loads: the loads of the computation.
        topic: topic of the samples.
        start_ns: stamp of the bag's first sample [ns].
        time: (N,) time since then [s].
        state: closed states, a batch of N.
        acceleration: (N, n) accelerations of the active joints [rad/s^2 or m/s^2]; NaN if unknown.
        efforts: (N, n) computed efforts of the active joints [N m or N]; NaN if unknown.
        recorded: (N, n) recorded efforts [N m or N]; NaN if missing.
        every: every n-th sample was kept.
        counts: numbers of accepted and refused samples.
        gaps: (from, to) [s] of gaps, and of stamps that go back.
        refused: (time [s], reason) of refused samples.
        outliers: samples that do not fit the motion around them, and have no acceleration; empty
            for the causal filter.
        measured: joints of the samples: the active ones, or those of the node's parameter.
        max_gap: largest gap [s], a parameter of the node.
        stamps: intervals between the stamps of all samples.
        errors: statistics of recorded minus computed efforts over all samples.
        losses: parts of the bag that could not be read.
        pressure_topic: topic with pressures of the cylinders; empty if there is none.
        pressures: (N, 2) recorded on cap and rod side by cylinder [Pa]; NaN if missing.
        pressed: active joints whose recorded efforts are those that pressures measure.
        smooth: estimator of accelerations, one of `job.SMOOTHINGS`.
        causal_lag: lag of the node's filter [s].
    """

    robot: Robot
    loads: Loads
    topic: str
    start_ns: int
    time: FloatArray
    state: ClosedState
    acceleration: FloatArray
    efforts: FloatArray
    recorded: FloatArray
    every: int
    counts: Counts
    gaps: list[tuple[float, float]]
    refused: list[tuple[float, str]]
    outliers: list[SampleOutlier]
    measured: tuple[str, ...]
    max_gap: float
    stamps: StampIntervals
    errors: ErrorStatistics
    losses: list[str]
    pressure_topic: str
    pressures: Mapping[str, FloatArray]
    pressed: tuple[str, ...]
    smooth: str
    causal_lag: float

    @property
    def is_causal(self) -> bool:
        """Whether accelerations come from the node's filter."""
        return self.smooth == CAUSAL

    @property
    def smoother(self) -> str:
        """Text for an estimator of accelerations without lag."""
        return _SMOOTHERS[self.smooth]

    @property
    def is_computed(self) -> bool:
        """Whether the samples are the output of a processed bag.

        Their efforts then are computed.
        """
        return self.topic == COMPUTED

    @property
    def pressure_source(self) -> str:
        """A text on recorded efforts from pressures; empty if there are none."""
        if not self.pressed:
            return ""
        return f"{', '.join(self.pressed)}: from the pressures on {self.pressure_topic}"

    @property
    def power(self) -> FloatArray:
        """Power of the actuators (N,) [W], positive into the robot."""
        total: FloatArray = (self.efforts * self.state.du).sum(axis=1)
        return total

    @cached_property
    def energy(self) -> tuple[FloatArray, FloatArray]:
        """Kinetic energy, and energy of gravity and springs, (N,) [J] each."""
        energy = self.robot.energy(self.state, self.loads)
        potential = np.asarray(energy.potential) + np.asarray(energy.springs)
        return np.asarray(energy.kinetic), potential

    @cached_property
    def beyond(self) -> list[str]:
        """A sentence for each limit of drives, cylinders and pumps that the motion passes."""
        state, efforts = self.state, self.efforts
        return beyond_in_rows(self.robot, self.time, state, efforts, self.acceleration)

    @cached_property
    def margins(self) -> tuple[tuple[str, ...], FloatArray]:
        """Joints with limits, and their margins to the nearer limit (N, k) [rad or m]."""
        strokes = StrokeMargins(self.robot)
        lower, upper = strokes.margins(self.state.s)
        return strokes.joints, np.minimum(lower, upper)
