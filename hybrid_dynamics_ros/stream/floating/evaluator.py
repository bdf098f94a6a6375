"""Evaluation of motions of robots with a floating base."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hybrid_dynamics_core import ClosedState, Robot

from ...messages.joint_samples import FloatArray, OrderedMotion
from ..evaluator import RESTARTS, MotionEvaluator
from ..filter.filter import StampEvent
from ..filter.routes import Kalman
from ..results import MotionResult, OneOrRows
from .base import FloatingBase
from .first_charts import require_first_charts, require_first_reference


class FloatingEvaluator(MotionEvaluator):
    """Evaluates samples one by one, with the base at its odometry.

    Ball and free joints are closed in charts that suit the pose, so no orientation is singular.

    Attributes:
        base: the robot's base.
        base_motion: its motion at the next sample; at rest at the reference until one is set.
    """

    may_be_plain = False

    def __init__(
        self,
        robot: Robot,
        bandwidth: float,
        max_gap: float,
        measured: Sequence[str] | None = None,
        kalman: Kalman | None = None,
        *,
        base: FloatingBase,
    ) -> None:
        """Make the evaluator of one robot; other arguments are those of `MotionEvaluator`."""
        self.base = base
        self.base_motion = base.at_rest(robot)
        super().__init__(robot, bandwidth, max_gap, measured, kalman)

    def _require_reference(self) -> None:
        require_first_reference(self.robot, self.measured, self.base.joint)

    def _evaluate(
        self, stamp_ns: OneOrRows, motion: OrderedMotion, event: StampEvent | None
    ) -> MotionResult:
        robot, base, moving = self.robot, self.base, self.base_motion
        u, du, _ = motion
        near = None
        if robot.follows or self.mode is not None:
            near = self.mode if event in RESTARTS else self._near
        poses, twists = {base.joint: moving.pose}, {base.joint: moving.twist}
        state = self._followed(robot.close_at_poses(poses, twists, u, du, near))
        require_first_charts(robot, state, self.measured, base.joint)
        self._near = state
        forces = self._forces(state, motion)
        velocity = None if du is None else state.du
        active = OrderedMotion(state.u, velocity, forces.acceleration)
        result = self._result(stamp_ns, state, active, forces.efforts, event)
        result.base_wrench = forces.wrench
        return result

    def _forces(self, state: ClosedState, motion: OrderedMotion) -> _Forces:
        """Accelerations, efforts and wrench, if all rates are known."""
        places, moving = list(self.base.places), self.base_motion
        _, du, ddu = motion
        if du is None or ddu is None or moving.acceleration is None:
            return _Forces(None, None, None)
        by_twists = self.robot.twist_map(state)
        of_twists = by_twists.acceleration(ddu)
        of_twists[places] = moving.acceleration
        acceleration = by_twists.rate_accelerations(of_twists)
        efforts = self.robot.inverse_dynamics(state, acceleration, self._loads)
        return _Forces(acceleration, efforts, by_twists.wrenches(efforts)[places])


class _Forces(NamedTuple):
    """Forces of a motion; None if unknown.

    Attributes:
        acceleration: accelerations of the active coordinates (n,), in the charts of the state.
        efforts: efforts along them (n,).
        wrench: external wrench on the base (6,) [N, N m].
    """

    acceleration: FloatArray | None
    efforts: FloatArray | None
    wrench: FloatArray | None


def evaluator_of(
    robot: Robot,
    bandwidth: float,
    max_gap: float,
    measured: Sequence[str] | None = None,
    kalman: Kalman | None = None,
    base: FloatingBase | None = None,
) -> MotionEvaluator:
    """Make the evaluator of a robot; `base` is None without odometry.

    Other arguments and errors are those of `MotionEvaluator`.
    """
    if base is None:
        return MotionEvaluator(robot, bandwidth, max_gap, measured, kalman)
    return FloatingEvaluator(robot, bandwidth, max_gap, measured, kalman, base=base)
