"""Evaluation of motions of robots whose ball and free joints are measured by poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hybrid_dynamics_core import ClosedState, Robot

from ...messages.joint_samples import FloatArray, OrderedMotion
from ..evaluator import RESTARTS, MotionEvaluator
from ..filter.filter import StampEvent
from ..filter.routes import Kalman
from ..results import MotionResult, OneOrRows
from .base import PosedJoint, PosedMotion, floating_base
from .first_charts import require_first_charts, require_first_reference


class FloatingEvaluator(MotionEvaluator):
    """Evaluates samples one by one, with ball and free joints at measured poses.

    They are closed in charts that suit the pose, so no orientation is singular.

    Attributes:
        posed: the joints with measured poses.
        motions: motion of each at the next sample, by name; at rest at the reference until set.
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
        posed: Sequence[PosedJoint],
    ) -> None:
        """Make the evaluator of one robot; other arguments are those of `MotionEvaluator`."""
        self.posed = tuple(posed)
        self.motions: dict[str, PosedMotion] = {}
        for joint in posed:
            self.motions[joint.joint] = joint.at_rest(robot)
        base = floating_base(robot)
        self._base = None
        if base is not None and base.joint in self.motions:
            self._base = base
        super().__init__(robot, bandwidth, max_gap, measured, kalman)

    def _require_reference(self) -> None:
        require_first_reference(self.robot, self.measured, self.motions)

    def _evaluate(
        self, stamp_ns: OneOrRows, motion: OrderedMotion, event: StampEvent | None
    ) -> MotionResult:
        robot = self.robot
        u, du, _ = motion
        near = None
        if robot.follows or self.mode is not None:
            near = self.mode if event in RESTARTS else self._near
        poses = {name: moving.pose for name, moving in self.motions.items()}
        twists = {name: moving.twist for name, moving in self.motions.items()}
        state = self._followed(robot.close_at_poses(poses, twists, u, du, near))
        require_first_charts(robot, state, self.measured, self.motions)
        self._near = state
        forces = self._forces(state, motion)
        velocity = None if du is None else state.du
        active = OrderedMotion(state.u, velocity, forces.acceleration)
        result = self._result(stamp_ns, state, active, forces.efforts, event)
        if self._base is not None and forces.wrenches is not None:
            result.base_wrench = forces.wrenches[list(self._base.places)]
        return result

    def _forces(self, state: ClosedState, motion: OrderedMotion) -> _Forces:
        """Accelerations, efforts and wrenches, if all rates are known."""
        _, du, ddu = motion
        if du is None or ddu is None:
            return _Forces(None, None, None)
        by_twists = self.robot.twist_map(state)
        of_twists = by_twists.acceleration(ddu)
        for joint in self.posed:
            acceleration = self.motions[joint.joint].acceleration
            if acceleration is None:
                return _Forces(None, None, None)
            of_twists[list(joint.places)] = acceleration
        acceleration = by_twists.rate_accelerations(of_twists)
        efforts = self.robot.inverse_dynamics(state, acceleration, self._loads)
        return _Forces(acceleration, efforts, by_twists.wrenches(efforts))


class _Forces(NamedTuple):
    """Forces of a motion; None if unknown.

    Attributes:
        acceleration: accelerations of the active coordinates (n,), in the charts of the state.
        efforts: efforts along them (n,).
        wrenches: the same (n,), with wrenches on links of ball and free joints [N, N m].
    """

    acceleration: FloatArray | None
    efforts: FloatArray | None
    wrenches: FloatArray | None


def evaluator_of(
    robot: Robot,
    bandwidth: float,
    max_gap: float,
    measured: Sequence[str] | None = None,
    kalman: Kalman | None = None,
    posed: Sequence[PosedJoint] = (),
) -> MotionEvaluator:
    """Make the evaluator of a robot; `posed` are its joints with measured poses.

    Other arguments and errors are those of `MotionEvaluator`.
    """
    if not posed:
        return MotionEvaluator(robot, bandwidth, max_gap, measured, kalman)
    return FloatingEvaluator(robot, bandwidth, max_gap, measured, kalman, posed=posed)
