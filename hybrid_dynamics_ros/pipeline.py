"""From a sample of the active joints to the full state, the efforts and the end-effector pose.

Knows no ROS: a live node and a tool that reads recordings run the same code. What comes out depends on
nothing but the samples that went in before, in their order.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_ros.estimator import Estimate, EstimatorState, MotionEstimator
from hybrid_dynamics_ros.filters import StampEvent
from hybrid_dynamics_ros.samples import (
    ActiveMotion,
    FloatArray,
    JointOrder,
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
    rejection_of,
)


@dataclass(frozen=True, eq=False)
class MotionResult:
    """All that one sample says about the robot. Coordinates are in the order of ``robot.coordinates``.

    Attributes:
        stamp_ns: stamp of the sample [ns].
        position: all coordinates, active then passive, (n_s,) [rad or m].
        velocity: their rates, (n_s,) [rad/s or m/s]; None until the filter has its samples, where the
            sample carried none.
        active_position, active_velocity, active_acceleration: what the efforts were computed for, (n,) each
            [rad or m, per s, per s^2]; the last two None until the filter has its samples.
        efforts: what the active joints must give, (n,) [N m or N]; None until the filter has its samples.
        tool_position: end-effector point in the base frame, (3,) [m].
        tool_quaternion: end-effector orientation in the base frame, (4,), x y z w.
        residual: largest gap left in a loop [m or rad].
        event: what the stamp meant to the filter; None where it was not asked.
    """

    stamp_ns: int
    position: FloatArray
    velocity: FloatArray | None
    active_position: FloatArray
    active_velocity: FloatArray | None
    active_acceleration: FloatArray | None
    efforts: FloatArray | None
    tool_position: FloatArray
    tool_quaternion: FloatArray
    residual: float
    event: StampEvent | None


@dataclass
class Counts:
    """What happened to the samples so far."""

    received: int = 0
    with_efforts: int = 0
    rejected: Counter[RejectionCode] = field(default_factory=Counter)
    events: Counter[StampEvent] = field(default_factory=Counter)

    @property
    def accepted(self) -> int:
        """Samples that gave a result."""
        return self.received - self.rejected.total()

    def summary(self) -> str:
        """One line for people: totals, rejections and restarts by kind."""
        parts = [
            f"{self.received} received",
            f"{self.accepted} accepted",
            f"{self.with_efforts} with efforts",
        ]
        parts += [f"{count} rejected: {code.value}" for code, count in self.rejected.items()]
        quiet = (StampEvent.NEXT, StampEvent.FIRST)
        parts += [f"{count} {event.value}" for event, count in self.events.items() if event not in quiet]
        return ", ".join(parts)


class Pipeline:
    """One robot, one stream of samples."""

    def __init__(self, robot: Robot, bandwidth: float, max_gap: float) -> None:
        """Robot, bandwidth of the rate estimates [Hz], and the gap between stamps that restarts them [s]."""
        self.robot = robot
        self.counts = Counts()
        self._order = JointOrder(robot.active)
        self._estimator = MotionEstimator(bandwidth, max_gap)
        self._state: EstimatorState | None = None

    def reset(self) -> None:
        """Forget the samples so far; the counts stay."""
        self._state = None

    def process(self, sample: JointSample) -> MotionResult | Rejection:
        """The result of one sample, or why there is none.

        A sample with accelerations is taken as it is and needs velocities too; it leaves the filter alone. A
        rejected sample leaves the filter alone as well. Raises nothing for any content of the sample.
        """
        self.counts.received += 1
        try:
            # Numbers near the end of the range overflow somewhere in the model: the result is checked.
            with np.errstate(all="ignore"):
                result = self._process(sample)
        except RejectedError as error:
            return self._reject(error.rejection)
        except HybridDynamicsError as error:
            return self._reject(rejection_of(error))
        self.counts.with_efforts += result.efforts is not None
        if result.event is not None:
            self.counts.events[result.event] += 1
        return result

    def _reject(self, rejection: Rejection) -> Rejection:
        self.counts.rejected[rejection.code] += 1
        return rejection

    def _process(self, sample: JointSample) -> MotionResult:
        if sample.stamp_ns < 0:
            raise RejectedError(RejectionCode.BAD_STAMP, f"stamp is {sample.stamp_ns} ns, expected 0 or more")
        motion = self._order.arrange(sample)
        if motion.acceleration is not None:
            motion.complete()
            return self._evaluate(sample.stamp_ns, motion, None)
        state, estimate = self._estimate(sample.stamp_ns, motion)
        motion = ActiveMotion(motion.position, estimate.velocity, estimate.acceleration)
        result = self._evaluate(sample.stamp_ns, motion, estimate.event)
        self._state = state  # only now: a sample that the model refused must not reach the filter
        return result

    def _estimate(self, stamp_ns: int, motion: ActiveMotion) -> tuple[EstimatorState, Estimate]:
        state, estimate = self._estimator.step(self._state, stamp_ns, motion.position, motion.velocity)
        if not np.isfinite(state.filter.derivatives).all():
            raise RejectedError(RejectionCode.OVERFLOW, "estimated rates of the active joints are not finite")
        return state, estimate

    def _evaluate(self, stamp_ns: int, motion: ActiveMotion, event: StampEvent | None) -> MotionResult:
        state = self.robot.close(motion.position, motion.velocity)
        pose = self.robot.forward_kinematics(state)
        result = MotionResult(
            stamp_ns=stamp_ns,
            position=state.s,
            velocity=None if motion.velocity is None else state.ds,
            active_position=motion.position,
            active_velocity=motion.velocity,
            active_acceleration=motion.acceleration,
            efforts=self._efforts(state, motion),
            tool_position=pose.position,
            tool_quaternion=pose.quaternion,
            residual=float(np.max(state.residual)),
            event=event,
        )
        _require_finite(result)
        return result

    def _efforts(self, state: ClosedState, motion: ActiveMotion) -> FloatArray | None:
        if motion.velocity is None or motion.acceleration is None:
            return None
        return self.robot.inverse_dynamics(state, motion.acceleration)


def _require_finite(result: MotionResult) -> None:
    for name in ("position", "velocity", "efforts", "tool_position", "tool_quaternion"):
        values = getattr(result, name)
        if values is not None and not np.isfinite(values).all():
            raise RejectedError(RejectionCode.OVERFLOW, f"{name.replace('_', ' ')} would not be finite")
