"""From a sample of the measured joints to the full state and the efforts.

Knows no ROS: a live node and a tool that reads recordings run the same code. What comes out depends
on nothing but the samples that went in before, in their order.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError, InputError
from hybrid_dynamics_core.ground.check_arrays import all_finite
from hybrid_dynamics_core.robot.compiled_calls import Call

from ..messages.joint_samples import (
    ActiveMotion,
    Calibration,
    FloatArray,
    JointOrder,
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
    rejection_of,
)
from .filter.filter import StampEvent
from .filter.rate_estimator import Estimate, EstimatorState, MotionEstimator
from .results import MotionResult

_RESTARTS = (StampEvent.FIRST, StampEvent.BACKWARD, StampEvent.GAP)


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
        parts += [
            f"{count} {_plural(event, count)}"
            for event, count in self.events.items()
            if event not in quiet
        ]
        return ", ".join(parts)


def _plural(event: StampEvent, count: int) -> str:
    return event.value if count == 1 or event is StampEvent.REPEATED else f"{event.value}s"


class Pipeline:
    """One robot, one stream of samples."""

    def __init__(
        self, robot: Robot, bandwidth: float, max_gap: float, measured: Sequence[str] | None = None
    ) -> None:
        """The pipeline of one robot.

        Args:
            robot: the robot.
            bandwidth: of the rate estimates [Hz].
            max_gap: between stamps, restarts them [s].
            measured: coordinates that the samples give, any independent set; None: the active ones.

        Raises:
            InputError: the measured coordinates do not determine the others.
        """
        self.robot = robot
        self.measured = tuple(measured or robot.active)
        self.calibration: Calibration | None = None
        self.mode: ClosedState | None = None
        self.counts = Counts()
        self.gap = 0.0  # [s] the newest that was too long, between stamps
        self._direct = self.measured == robot.active
        self._order = JointOrder(self.measured)
        self._near: ClosedState | None = None
        self._state: EstimatorState | None = None
        self._branch = robot.close(robot.reference).branch
        self.loads = robot.loads
        self.set_filter(bandwidth, max_gap)
        if not self._direct:
            start = robot.close(robot.reference)
            robot.close_given(
                {name: float(start.s[robot.coordinates.index(name)]) for name in self.measured}
            )

    @property
    def loads(self) -> Loads:
        """Everything that acts on the robot, from the next sample on."""
        return self._loads

    @loads.setter
    def loads(self, loads: Loads) -> None:
        self._loads, self._fused = loads, self._chosen(loads)

    def _chosen(self, loads: Loads) -> Call | None:
        """One call for all, where nothing has to be followed from the sample before."""
        plain = self._direct and self.mode is None and not self.robot.follows
        return self._fused_under(loads) if plain else None

    def _fused_under(self, loads: Loads) -> Call:
        return self.robot.kernels.under(loads).closed_inverse_dynamics

    def prepare(self, loads: Loads) -> None:
        """Have the code for such loads generated, whatever their values: then `loads` are taken without delay."""
        if not self.robot.follows:
            self._fused_under(loads)
        state = self.robot.close(self.robot.reference)
        self.robot.inverse_dynamics(state, np.zeros(state.n), loads)

    def set_filter(self, bandwidth: float, max_gap: float) -> None:
        """Another bandwidth [Hz] and gap [s] from now on; the estimates start anew."""
        self._estimator = MotionEstimator(bandwidth, max_gap)
        self._state = None

    def acceleration_lag(self, *, measured: bool) -> float:
        """How late the filter's accelerations are [s], with velocities measured or without."""
        return self._estimator.lag(measured=measured)

    def calibrate(self, calibration: Calibration | None) -> None:
        """Read the sensors so from now on; where that is another way than before, the estimates start anew."""
        if not _same(calibration, self.calibration):
            self.reset()
        self.calibration = calibration

    def set_mode(self, mode: ClosedState | None) -> None:
        """Keep the assembly modes of a closed state from now on; None: those of the robot file."""
        self.mode = self._near = mode
        self._state = None
        self._fused = self._chosen(self._loads)

    def reset(self) -> None:
        """Forget the samples so far; the counts stay."""
        self._state, self._near = None, self.mode

    def process(self, sample: JointSample, *, estimate: bool = True) -> MotionResult | Rejection:
        """The result of one sample, or why there is none.

        A sample with accelerations is taken as it is and needs velocities too; it leaves the filter
        alone. A rejected sample leaves the filter alone as well. Raises nothing for any content of
        the sample. estimate: whether the filter tells the rates that the sample lacks; if not, they
        stay unknown.
        """
        self.counts.received += 1
        try:
            result = self._process(sample, estimate=estimate)
        except RejectedError as error:
            return self.reject(error.rejection)
        except HybridDynamicsError as error:
            return self.reject(rejection_of(error))
        self.counts.with_efforts += result.efforts is not None
        if result.event is not None:
            self.counts.events[result.event] += 1
        return result

    def reject(self, rejection: Rejection) -> Rejection:
        """Count a rejection of a sample that `process` was given."""
        self.counts.rejected[rejection.code] += 1
        return rejection

    def withdraw(self, result: MotionResult, rejection: Rejection) -> Rejection:
        """Count a result of `process` as a rejection after all, since it could not be told."""
        self.counts.with_efforts -= result.efforts is not None
        return self.reject(rejection)

    def reject_unread(self, rejection: Rejection) -> Rejection:
        """Count a message that never became a sample for `process`."""
        self.counts.received += 1
        return self.reject(rejection)

    def _process(self, sample: JointSample, *, estimate: bool) -> MotionResult:
        if self._direct and self.mode is None and self.calibration is None:
            return self._answer(sample, estimate=estimate)  # without NumPy's arithmetic
        # Numbers near the end of the range overflow somewhere in the model: the result is checked.
        with np.errstate(all="ignore"):
            return self._answer(sample, estimate=estimate)

    def _answer(self, sample: JointSample, *, estimate: bool) -> MotionResult:
        if sample.stamp_ns < 0:
            raise RejectedError(
                RejectionCode.BAD_STAMP, f"stamp is {sample.stamp_ns} ns, expected 0 or more"
            )
        motion = self._order.arrange(sample)
        if self.calibration is not None:
            motion = motion.calibrated(self.calibration)
        if motion.acceleration is not None:
            motion.complete()
        if motion.acceleration is not None or not estimate:
            return self._evaluate(sample.stamp_ns, motion, None)
        state, rates = self._estimate(sample.stamp_ns, motion)
        motion = ActiveMotion(motion.position, rates.velocity, rates.acceleration)
        result = self._evaluate(sample.stamp_ns, motion, rates.event)
        if rates.event is StampEvent.GAP and self._state is not None:
            self.gap = (sample.stamp_ns - self._state.filter.stamp_ns) * 1e-9
        self._state = state  # only now: a sample that the model refused must not reach the filter
        return result

    def _estimate(self, stamp_ns: int, motion: ActiveMotion) -> tuple[EstimatorState, Estimate]:
        state, estimate = self._estimator.step(
            self._state, stamp_ns, motion.position, motion.velocity
        )
        if not all_finite(state.filter.derivatives):
            raise RejectedError(
                RejectionCode.OVERFLOW, "estimated rates of the measured joints are not finite"
            )
        return state, estimate

    def _evaluate(
        self, stamp_ns: int, motion: ActiveMotion, event: StampEvent | None
    ) -> MotionResult:
        if (
            self._fused is not None
            and motion.velocity is not None
            and motion.acceleration is not None
        ):
            return self._evaluate_fused(self._fused, stamp_ns, motion, event)
        state, acceleration = self._close(motion, event)
        velocity = None if motion.velocity is None else state.du
        efforts = None
        if velocity is not None and acceleration is not None:
            efforts = self.robot.inverse_dynamics(state, acceleration, self.loads)
        return MotionResult(
            robot=self.robot,
            loads=self.loads,
            stamp_ns=stamp_ns,
            active=ActiveMotion(state.u, velocity, acceleration),
            position=state.s,
            velocity=None if velocity is None else state.ds,
            efforts=efforts,
            residual=float(state.residual),
            distances=state.distances,
            branch=state.branch,
            event=event,
            make_state=lambda: state,
        )

    def _evaluate_fused(
        self, fused: Call, stamp_ns: int, motion: ActiveMotion, event: StampEvent | None
    ) -> MotionResult:
        """The same to the last bit, in one call of compiled code."""
        u, du, ddu = motion.complete()
        efforts, *closed = fused(u, du, ddu)
        s, ds, _, _, residuals, distances = closed
        for array in (u, du, ddu, efforts, s, ds):
            array.flags.writeable = False
        robot = self.robot
        return MotionResult(
            robot,
            self._loads,
            stamp_ns,
            motion,
            s,
            ds,
            efforts,
            max(map(abs, residuals.tolist()), default=0.0),
            robot.loop_distances(distances),
            self._branch,
            event,
            partial(robot.closed_state, u, du, closed),
        )

    def _close(
        self, motion: ActiveMotion, event: StampEvent | None
    ) -> tuple[ClosedState, FloatArray | None]:
        """The closed state, and the accelerations of the active joints where they are known."""
        if self._direct and self.mode is None:
            return self.robot.close(motion.position, motion.velocity), motion.acceleration
        near = self.mode if event in _RESTARTS else self._near
        if self._direct:
            state = self.robot.close(motion.position, motion.velocity, near=near)
        else:
            state = self._close_measured(motion, near)
        self._near = state
        if self._direct or motion.acceleration is None or state.dds is None:
            return state, motion.acceleration
        return state, state.dds[: state.n]

    def _close_measured(self, motion: ActiveMotion, near: ClosedState | None) -> ClosedState:
        values, rates, accelerations = (
            None if part is None else dict(zip(self.measured, part.tolist(), strict=True))
            for part in (motion.position, motion.velocity, motion.acceleration)
        )
        if values is None:
            raise InputError("the positions are missing")
        return self.robot.close_given(values, rates, accelerations, near=near)


def _same(one: Calibration | None, other: Calibration | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one.offset, other.offset) and np.array_equal(one.factor, other.factor)
