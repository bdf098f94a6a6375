"""The pipeline from samples of joints by name to results or rejections, with counts.

This module does not depend on ROS.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.wording import counted

from ..messages.extra_joints import PassThrough
from ..messages.joint_samples import (
    JointOrder,
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
    rejection_of,
    resting_joints,
)
from ..messages.pressures import MeasuredForces, PressureInput
from ..messages.readings import MAX_AGE, ReadingOrder
from .estimates.chambers import ChamberCheck
from .estimates.payload import PayloadInput
from .estimates.tool_force import ToolForceInput
from .evaluator import MotionEvaluator
from .filter.filter import StampEvent
from .filter.routes import Kalman
from .floating.base import PoseInput, PoseInputs
from .floating.evaluator import FloatingEvaluator, evaluator_of
from .results import MotionResult

_UNREMARKABLE = (StampEvent.NEXT, StampEvent.FIRST)


@dataclass
class Counts:
    """Counts of the samples so far.

    Attributes:
        received: number of all samples.
        with_efforts: number of results with efforts.
        rejected: number of rejections by reason.
        events: number of stamps by event.
        wraps: number of removed jumps of whole turns, by joint.
        waiting: number of partial samples that waited for other joints.
    """

    received: int = 0
    with_efforts: int = 0
    rejected: Counter[RejectionCode] = field(default_factory=Counter)
    events: Counter[StampEvent] = field(default_factory=Counter)
    wraps: Counter[str] = field(default_factory=Counter)
    waiting: int = 0

    @property
    def accepted(self) -> int:
        """Number of samples with a result."""
        return self.received - self.waiting - self.rejected.total()

    def summary(self) -> str:
        """One line of text: totals, rejections and restarts by kind."""
        parts = [
            f"{self.received} received",
            f"{self.accepted} accepted",
            f"{self.with_efforts} with efforts",
        ]
        if self.waiting:
            parts.append(f"{self.waiting} with some joints, which waited for the others")
        parts += [f"{count} rejected: {code.value}" for code, count in self.rejected.items()]
        for event, count in self.events.items():
            if event not in _UNREMARKABLE:
                parts.append(f"{count} {_plural(event, count)}")
        for joint, count in self.wraps.items():
            parts.append(f"{counted(count, 'whole turn')} of {joint} continued")
        return ", ".join(parts)


def _plural(event: StampEvent, count: int) -> str:
    return event.value if count == 1 or event is StampEvent.REPEATED else f"{event.value}s"


class Pipeline:
    """The pipeline of one robot for one stream of samples.

    Attributes:
        evaluator: the evaluator.
        readings: order and joiner of joint states.
        extras: joints that the robot does not have; None if ignored.
        pressures: pressures of the cylinders.
        chambers: check of the sides of pressure sensors.
        tool: observer of the force at the tool.
        scale: newest motion, for weighing the load at the tool.
        poses: measured poses of ball and free joints.
        resting: default positions of joints that samples need not name [rad or m].
        counts: counts of the samples so far.
    """

    def __init__(
        self,
        robot: Robot,
        bandwidth: float,
        max_gap: float,
        measured: Sequence[str] | None = None,
        kalman: Kalman | None = None,
        poses: PoseInputs | None = None,
    ) -> None:
        """Make the pipeline; arguments and errors are those of `MotionEvaluator`."""
        self.poses = poses or PoseInputs()
        self.evaluator: MotionEvaluator = evaluator_of(
            robot, bandwidth, max_gap, measured, kalman, self.poses.posed
        )
        for source in self.poses.every:
            source.set_filter(self.evaluator.estimator)
        self.counts = Counts(wraps=self.evaluator.wraps)
        self.resting = {**resting_joints(robot), **self.poses.resting(robot)}
        self._order = JointOrder(self.evaluator.measured, self.resting)
        self.readings = ReadingOrder(self.evaluator.measured, self.resting)
        self.extras: PassThrough | None = None
        self.pressures = PressureInput(robot, MAX_AGE)
        self.chambers = ChamberCheck(robot)
        self.tool = ToolForceInput(robot)
        self.scale = PayloadInput(robot)

    def pass_through(self, max_age: float) -> None:
        """Pass through joints that the robot does not have, up to an age [s]."""
        robot, measured = self.evaluator.robot, self.evaluator.measured
        if self.extras is None:
            self.extras = PassThrough(robot.coordinates, measured)
        self.extras.max_age = max_age

    def process(
        self, sample: JointSample, *, is_estimated: bool = False
    ) -> MotionResult | Rejection | None:
        """The result of one sample, or its rejection; None if it waits for other joints.

        A rejected sample does not change the filter. No content of a sample raises an error.

        Args:
            sample: readings of joints by name.
            is_estimated: whether the sample is a motion of the joints with given rates; missing
                ones are not estimated.
        """
        self.counts.received += 1
        try:
            result = self._process(sample, is_estimated)
        except RejectedError as error:
            return self.reject(error.rejection)
        except HybridDynamicsError as error:
            return self.reject(rejection_of(error))
        if result is None:
            self.counts.waiting += 1
            return None
        if self.pressures.newest:
            newest = self.pressures.newest
            result.measured_forces = self.pressures.at(result.stamp_ns, newest)
            self.compare(result, newest)
            self.observe(result)
        if result.efforts is not None:
            self.counts.with_efforts += 1
        if result.event is not None:
            self.counts.events[result.event] += 1
        return result

    def compare(self, result: MotionResult, newest: tuple[MeasuredForces, ...]) -> None:
        """Compare measured forces of one sample with those that its motion requires.

        Args:
            result: the result of the sample, or one row.
            newest: pressures at its time.
        """
        measured, stamp = result.measured_forces, int(np.max(result.stamp_ns))
        if measured is None or result.efforts is None or not self.chambers.is_due(stamp):
            return
        required = result.drive_forces
        if required is not None:
            exchanged = self.pressures.exchanged_at(stamp, newest)
            self.chambers.take(stamp, required, measured.reshape(-1), exchanged)

    def observe(self, result: MotionResult) -> None:
        """Let the force and the load at the tool take a result, or rows of results."""
        result.observe(self.tool, self.scale, self.evaluator.mode is None)

    def reject(self, rejection: Rejection) -> Rejection:
        """Count a rejection of a sample in `process`."""
        self.counts.rejected[rejection.code] += 1
        return rejection

    def withdraw(self, result: MotionResult, rejection: Rejection) -> Rejection:
        """Count a result of `process` as a rejection, since it could not be sent."""
        if result.efforts is not None:
            self.counts.with_efforts -= 1
        return self.reject(rejection)

    def reject_unread(self, rejection: Rejection) -> Rejection:
        """Count a rejected message that did not reach `process`."""
        self.counts.received += 1
        return self.reject(rejection)

    def wait_unread(self) -> None:
        """Count a partial message that is joined outside of `process`."""
        self.counts.received += 1
        self.counts.waiting += 1

    @property
    def odometry(self) -> PoseInput | None:
        """Odometry of a floating base; None if it stays at its reference."""
        return self.poses.odometry

    def _place(self, stamp_ns: int) -> None:
        """Set joints with measured poses to those at a stamp [ns]."""
        if isinstance(self.evaluator, FloatingEvaluator):
            for source in self.poses.every:
                self.evaluator.motions[source.joint.joint] = source.at(stamp_ns)

    def _process(self, sample: JointSample, is_estimated: bool) -> MotionResult | None:
        evaluator = self.evaluator
        if evaluator.is_plain and evaluator.calibration is None:
            return self._evaluate(sample, is_estimated)  # in plain floats
        # Very large numbers overflow in the model, so the result is checked.
        with np.errstate(all="ignore"):
            return self._evaluate(sample, is_estimated)

    def _evaluate(self, sample: JointSample, is_estimated: bool) -> MotionResult | None:
        stamp_ns = sample.stamp_ns
        if stamp_ns < 0:
            raise RejectedError(
                RejectionCode.BAD_STAMP, f"stamp is {stamp_ns} ns, expected 0 or more"
            )
        self._place(stamp_ns)
        if is_estimated:
            return self.evaluator.given(stamp_ns, self._order.arrange(sample))
        if sample.acceleration is not None:
            return self.evaluator.step(stamp_ns, self._order.arrange(sample))
        extras = self.extras
        if extras is not None and extras.take(sample):
            return None
        reading = self.readings.arrange(sample)
        if reading is None:
            return None
        result = self.evaluator.step(*reading)
        if extras is not None:
            result.extras = extras.at(result.stamp_ns, extras.newest)
        return result
