"""A recording and what the model says about it, as arrays, for reports and identification."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Robot

from ...messages.joint_samples import FloatArray
from ...stream.pipeline import Counts
from ...stream.stroke_margins import StrokeMargins
from ..batch_outputs import NODE
from ..job import CAUSAL
from ..sample_outliers import SampleOutlier
from .error_statistics import ErrorStatistics
from .stamp_intervals import StampIntervals

COMPUTED: Final = f"{NODE}/joint_states"  # the node's output: its efforts are the model's
_SMOOTHERS: Final = {"spline": "a spline", "savgol": "a Savitzky-Golay filter"}


@dataclass(eq=False)
class EvaluatedRecording:
    """Some samples of a recording with what the model says, in order.

    Attributes:
        robot: the robot that it was computed with.
        loads: the loads that it was computed with.
        topic: where the samples are from.
        start_ns: stamp of the bag's first sample [ns].
        time: (N,) [s] since then.
        state: closed, a batch of N.
        acceleration: (N, n) of the active joints [rad/s^2 or m/s^2]; NaN where it is not known.
        efforts: (N, n) of the active joints [N m or N]; NaN where they are not known.
        recorded: recorded efforts (N, n) [N m or N]; NaN where there are none.
        every: one in so many samples is here.
        counts: what happened to the samples.
        gaps: (from, to) [s] where stamps go back, or are further apart than the largest gap.
        refused: (time [s], why) of samples that were refused.
        outliers: samples that do not fit the motion around them, and have no acceleration. The
            causal filter leaves none out.
        measured: joints of the bag's samples: the active ones, or those of the node's parameter.
        max_gap: the largest gap [s], a parameter of the node.
        stamps: intervals between all stamps.
        errors: recorded less computed efforts over all samples.
        losses: what could not be read.
        pressure_topic: with pressures of the cylinders; empty where there is none.
        pressed: active joints whose recorded efforts are those that pressures measure.
        smooth: how accelerations were found, one of `job.SMOOTHINGS`.
        causal_lag: how late they are where they come from the node's filter [s].
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
    pressed: tuple[str, ...]
    smooth: str
    causal_lag: float

    @property
    def is_causal(self) -> bool:
        """Whether accelerations come from the node's filter, which takes every sample."""
        return self.smooth == CAUSAL

    @property
    def smoother(self) -> str:
        """What accelerations without lag are from, in words."""
        return _SMOOTHERS[self.smooth]

    @property
    def is_computed(self) -> bool:
        """Whether a processed bag has the samples in place of a recording.

        Their efforts are the model's then.
        """
        return self.topic == COMPUTED

    @property
    def pressure_source(self) -> str:
        """Which recorded efforts are from pressures, in words; empty where none are."""
        if not self.pressed:
            return ""
        return f"{', '.join(self.pressed)}: from the pressures on {self.pressure_topic}"

    @property
    def power(self) -> FloatArray:
        """Power of the actuators, positive into the robot (N,) [W]."""
        total: FloatArray = (self.efforts * self.state.du).sum(axis=1)
        return total

    @cached_property
    def energy(self) -> tuple[FloatArray, FloatArray]:
        """Energy of motion, and of gravity and springs (N,) [J]."""
        energy = self.robot.energy(self.state, self.loads)
        potential = np.asarray(energy.potential) + np.asarray(energy.springs)
        return np.asarray(energy.kinetic), potential

    @cached_property
    def margins(self) -> tuple[tuple[str, ...], FloatArray]:
        """Joints with a stroke that ends, and their margins to the nearer end (N, k) [rad or m]."""
        strokes = StrokeMargins(self.robot)
        lower, upper = strokes.margins(self.state.s)
        return strokes.joints, np.minimum(lower, upper)
