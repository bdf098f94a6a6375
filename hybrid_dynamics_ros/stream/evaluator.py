"""Evaluation of motions: from measured joints to the full state and the efforts.

The live node and the tools for recordings run the same code. Results depend only on the samples so
far, in order. This module does not depend on ROS.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Loads, Robot
from hybrid_dynamics_core.algebra.charts import FIRST
from hybrid_dynamics_core.robot.compiled_calls import Call

from ..messages.joint_samples import Calibration, FloatArray, OrderedMotion
from .filter.filter import StampEvent
from .filter.rate_estimator import MotionEstimator, RateRows
from .filter.routes import Kalman
from .floating.first_charts import (
    charts_of,
    in_first_charts,
    require_first_charts,
    require_first_reference,
    turned_to_first,
)
from .joint_groups import GroupedEstimator, State, stamp_of
from .results import MotionResult, OneOrRows
from .turns import TurnCounter, TurnRows, TurnState

RESTARTS = (StampEvent.FIRST, StampEvent.BACKWARD, StampEvent.GAP)


class MotionEvaluator:
    """Calibration, estimation of rates, closure and evaluation of the model for one stream.

    A call takes one sample, or rows of samples.

    Attributes:
        robot: the robot.
        measured: names of the measured coordinates.
        estimator: estimator of missing rates.
        calibration: calibration of the sensors; None if they read the coordinates themselves.
        mode: a closed state whose assembly modes are kept; None: those of the robot file.
        is_plain: whether the active joints are measured, on the modes of the robot file. Then only
            whole turns of passive joints depend on the sample before.
        last: all coordinates (n_s,) of the last sample [rad or m], for continuity of passive
            angles; None before the first.
        wraps: number of removed jumps of whole turns, by joint.
        gap: the newest gap between stamps that was too long [s].
        may_be_plain: whether `is_plain` is possible.
    """

    may_be_plain = True

    def __init__(
        self,
        robot: Robot,
        bandwidth: float,
        max_gap: float,
        measured: Sequence[str] | None = None,
        kalman: Kalman | None = None,
    ) -> None:
        """Make the evaluator of one robot.

        Args:
            robot: the robot.
            bandwidth: bandwidth of the rate estimates [Hz].
            max_gap: longer gaps between stamps restart the estimates [s].
            measured: measured coordinates, any independent set; None: the active ones.
            kalman: settings of a Kalman filter; None: polynomial filters.

        Raises:
            InputError: the measured coordinates do not determine the others, or a measured ball
                joint is in its second chart at the reference.
        """
        self.robot = robot
        self.measured = tuple(measured or robot.active)
        self._require_reference()
        self.calibration: Calibration | None = None
        self.mode: ClosedState | None = None
        self.gap = 0.0
        self.wraps: Counter[str] = Counter()
        self._measures_active = self.measured == robot.active
        self.may_be_plain = self.may_be_plain and not robot.depends_on_turns
        self.is_plain = self._measures_active and self.may_be_plain
        self.last: FloatArray | None = None
        self._near: ClosedState | None = None
        start = robot.close(robot.reference)
        self._branch = start.branch
        self._charts = charts_of(robot, start)
        self._is_in_second_charts = bool(np.any(self._charts != FIRST))
        # For readings, and for motions with given rates.
        self._turned: TurnState | None = None
        self._turned_given: TurnState | None = None
        self.loads = robot.loads
        self.set_filter(bandwidth, max_gap, kalman)
        if not self._measures_active:
            places = {name: robot.coordinates.index(name) for name in self.measured}
            robot.close_given({name: float(start.s[k]) for name, k in places.items()})

    def _require_reference(self) -> None:
        """Raise InputError if a measured ball joint is in its second chart at the reference."""
        require_first_reference(self.robot, self.measured)

    @property
    def loads(self) -> Loads:
        """The loads on the robot, effective from the next sample."""
        return self._loads

    @loads.setter
    def loads(self, loads: Loads) -> None:
        self._compiled = self._compiled_for(loads)
        self._loads = loads

    def _compiled_for(self, loads: Loads) -> Call | None:
        """The compiled call of one sample, if no loop is followed from the state before."""
        if not self.is_plain or self.robot.follows:
            return None
        return self.robot.kernels.under(loads).closed_inverse_dynamics

    def prepare(self, loads: Loads) -> None:
        """Compile the code for the pattern of some loads.

        Loads of this pattern then take effect without delay.
        """
        if not self.robot.follows:
            _ = self.robot.kernels.under(loads).closed_inverse_dynamics
        state = self.robot.close(self.robot.reference)
        self.robot.inverse_dynamics(state, np.zeros(state.n), loads)

    def set_filter(self, bandwidth: float, max_gap: float, kalman: Kalman | None = None) -> None:
        """Set bandwidth [Hz], largest gap [s] and filter; the estimates restart."""
        self.estimator = MotionEstimator(bandwidth, max_gap, kalman)
        is_angle = [self.robot.joint_types[name] == "revolute" for name in self.measured]
        self._turns = TurnCounter(self.measured, is_angle, max_gap)
        self._grouped = GroupedEstimator(self.estimator)
        self._memory: State | None = None

    def calibrate(self, calibration: Calibration | None) -> None:
        """Set the calibration of sensors; a change restarts the estimates."""
        if not _same(calibration, self.calibration):
            self.reset()
        self.calibration = calibration

    def set_mode(self, mode: ClosedState | None) -> None:
        """Set the assembly modes by a closed state; None for those of the robot file."""
        self.mode = self._near = mode
        self.is_plain = self._measures_active and self.may_be_plain and mode is None
        self._memory = self.last = None
        self._compiled = self._compiled_for(self._loads)

    def reset(self) -> None:
        """Discard the samples so far."""
        self._memory = self.last = None
        self._turned = self._turned_given = None
        self._near = self.mode

    def step(self, stamp_ns: int, motion: OrderedMotion) -> MotionResult:
        """The result of one sample.

        A sample with accelerations must have velocities too, and does not change the filter. A
        refused sample does not change it either.

        Args:
            stamp_ns: its stamp [ns].
            motion: readings of the measured joints.

        Raises:
            RejectedError: velocities are missing, or estimated rates are not finite.
            HybridDynamicsError: the model refuses the sample.
        """
        if self.calibration is not None:
            motion = motion.calibrated(self.calibration)
        if motion.acceleration is not None:
            motion.complete()
            return self.given(stamp_ns, motion)
        u, du, _ = motion
        turned, u = self._turns.step(self._turned, stamp_ns, u, du)
        memory, rates = self._grouped.step(self._memory, stamp_ns, u, du)
        motion = OrderedMotion(u, rates.velocity, rates.acceleration)
        result = self.evaluate(stamp_ns, motion, rates.event)
        if rates.event is StampEvent.GAP and self._memory is not None:
            self.gap = (stamp_ns - stamp_of(self._memory)) * 1e-9
        self._memory = memory  # stored last, so that a refused sample does not reach the filter
        if self._turned is not None and turned.turns is not self._turned.turns:
            self.wraps.update(self._turns.wraps(self._turned, turned))
        self._turned = turned
        return result

    def given(self, stamp_ns: int, motion: OrderedMotion) -> MotionResult:
        """The result of one sample with given rates; the filter is not changed.

        Args:
            stamp_ns: its stamp [ns].
            motion: motion of the measured joints, whose angles may be wrapped.

        Raises:
            HybridDynamicsError: the model refuses the sample.
        """
        before = self._turned_given
        turned, position = self._turns.step(before, stamp_ns, motion.position, motion.velocity)
        result = self.evaluate(stamp_ns, motion._replace(position=position))
        self.wraps.update(self._turns.wraps(before, turned))
        self._turned_given = turned
        return result

    def continued(
        self,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
        *,
        is_given: bool = False,
    ) -> TurnRows:
        """Positions of N samples without jumps of whole turns; `taken` stores the state.

        Args:
            stamps: (N,) [ns].
            position: (N, n) of the measured joints [rad or m].
            velocity: (N, n) [rad/s or m/s]; NaN if unknown.
            is_given: whether rates are given, as in `given`.
        """
        state = self._turned_given if is_given else self._turned
        return self._turns.run(state, stamps, position, velocity)

    def rates(
        self,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
    ) -> RateRows:
        """Rates of N samples by the filter; `taken` stores the state.

        Arguments are those of `GroupedEstimator.run`.

        Raises:
            RejectedError: rates are not finite.
        """
        return self._grouped.run(self._memory, stamps, position, velocity)

    def taken(self, turned: TurnRows, rates: RateRows | None) -> None:
        """Store the state after some rows; `rates` is None for rows with given rates."""
        self.wraps.update(turned.wraps)
        if rates is None:
            self._turned_given = turned.state
            return
        self._turned = turned.state
        if rates.state is not None:
            self._memory = rates.state

    def evaluate(
        self,
        stamp_ns: OneOrRows,
        motion: OrderedMotion,
        event: StampEvent | None = None,
    ) -> MotionResult:
        """Close the loops and evaluate the model, as far as rates are known.

        Args:
            stamp_ns: stamp [ns]; of rows (N,).
            motion: motion of the measured joints (n,), or rows (N, n) if the evaluator `is_plain`.
            event: event of the stamp.

        Raises:
            HybridDynamicsError: the model refuses the sample, or the first such row.
        """
        result = self._evaluate(stamp_ns, motion, event)
        position = result.position
        if self._is_in_second_charts:
            position = result.state.s  # angles continue in their own charts
        self.last = position[-1] if position.ndim == 2 else position
        return result

    def _evaluate(
        self, stamp_ns: OneOrRows, motion: OrderedMotion, event: StampEvent | None
    ) -> MotionResult:
        compiled = self._compiled
        _, du, ddu = motion
        if compiled is not None and du is not None and ddu is not None:
            return self._evaluate_compiled(compiled, stamp_ns, motion, event)
        state, acceleration = self._close(motion, event)
        efforts = None
        if du is not None and acceleration is not None:
            efforts = self.robot.inverse_dynamics(state, acceleration, self._loads)
        velocity = None if du is None else state.du
        active = OrderedMotion(state.u, velocity, acceleration)
        return self._result(stamp_ns, state, active, efforts, event)

    def _evaluate_compiled(
        self,
        compiled: Call,
        stamp_ns: OneOrRows,
        motion: OrderedMotion,
        event: StampEvent | None,
    ) -> MotionResult:
        """The result of `_evaluate` to the same bits, in one call of compiled code."""
        u, du, ddu = motion.complete()
        robot = self.robot
        if u.ndim == 2:
            efforts, state = self._rows_compiled(compiled, motion)
            return self._result(stamp_ns, state, motion, efforts, event)
        if self.last is None:
            efforts, *closed = compiled(u, du, ddu)
        else:
            efforts, *closed = compiled(u, du, ddu, guess=self.last)
        s, ds, _, _, residuals, distances = closed
        for array in (u, du, ddu, efforts, s, ds):
            array.flags.writeable = False
        position, velocity = s, ds
        if self._is_in_second_charts:
            position, velocity = turned_to_first(robot, self._charts, s, ds)
        return MotionResult(  # plain floats; the state is made on demand
            robot,
            self._loads,
            stamp_ns,
            motion,
            position,
            velocity,
            efforts,
            max(map(abs, residuals.tolist()), default=0.0),
            robot.loop_distances(distances),
            self._branch,
            event,
            partial(robot.closed_state, u, du, closed),
        )

    def _rows_compiled(
        self, compiled: Call, motion: OrderedMotion
    ) -> tuple[FloatArray, ClosedState]:
        """Efforts and states of consecutive rows."""
        u, du, ddu = motion.complete()
        efforts, *closed = compiled(u, du, ddu)
        state = self.robot.closed_state(u, du, closed)
        followed = self._followed(state)
        if followed is not state:
            efforts, *closed = compiled(u, du, ddu, guess=followed.s)
            state = self.robot.closed_state(u, du, closed)
        return efforts, state

    def _followed(self, state: ClosedState) -> ClosedState:
        """States with passive angles continued from the sample before."""
        before = self.last
        if before is None:
            before = state.s[0] if state.s.ndim == 2 else state.s
        return self.robot.follow_turns(state, before)

    def _result(
        self,
        stamp_ns: OneOrRows,
        state: ClosedState,
        active: OrderedMotion,
        efforts: FloatArray | None,
        event: StampEvent | None,
    ) -> MotionResult:
        position, velocity = in_first_charts(self.robot, state)
        return MotionResult(
            robot=self.robot,
            loads=self._loads,
            stamp_ns=stamp_ns,
            active=active,
            position=position,
            velocity=None if active.velocity is None else velocity,
            efforts=efforts,
            residual=state.residual,
            distances=state.distances,
            branch=state.branch,
            event=event,
            make_state=lambda: state,
        )

    def _close(
        self, motion: OrderedMotion, event: StampEvent | None
    ) -> tuple[ClosedState, FloatArray | None]:
        """The closed state, and the accelerations of the active joints, or None."""
        if self.is_plain:
            state = self.robot.close(motion.position, motion.velocity)
            return self._followed(state), motion.acceleration
        near = self.mode if event in RESTARTS else self._near
        if self._measures_active:
            state = self.robot.close(motion.position, motion.velocity, near=near)
        else:
            values, rates, accelerations = motion.by_name(self.measured)
            state = self.robot.close_given(values, rates, accelerations, near=near)
        require_first_charts(self.robot, state, self.measured)
        self._near = state
        if self._measures_active or motion.acceleration is None or state.dds is None:
            return state, motion.acceleration
        return state, state.dds[: state.n]


def _same(one: Calibration | None, other: Calibration | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one.offset, other.offset) and np.array_equal(one.factor, other.factor)
