"""From the motion of the joints and that of a floating base to the full state and the efforts."""

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
from .first_charts import in_first_charts, require_first_charts, require_first_reference


class FloatingEvaluator(MotionEvaluator):
    """Evaluates one sample after the other, with the base wherever odometry has it.

    Ball and free joints are closed in the charts that suit the pose, so every orientation is as
    good as any other.

    Attributes:
        base: of the robot.
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
        """The evaluator of one robot; other arguments are those of `MotionEvaluator`."""
        self.base = base
        self.base_motion = base.at_rest(robot)
        super().__init__(robot, bandwidth, max_gap, measured, kalman)

    def _require_reference(self) -> None:
        require_first_reference(self.robot, self.base.joint)

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
        require_first_charts(robot, state, base.joint)
        self._near = state
        forces = self._forces(state, motion)
        velocity = None if du is None else state.du
        active = OrderedMotion(state.u, velocity, forces.acceleration)
        result = self._result(stamp_ns, state, active, forces.efforts, event)
        s, ds = in_first_charts(robot, state)
        result.position, result.base_wrench = s, forces.wrench
        result.velocity = None if du is None else ds
        return result

    def _forces(self, state: ClosedState, motion: OrderedMotion) -> _Forces:
        """Accelerations and what they take, as far as all rates are known."""
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
    """What the motion takes; None where it is not known.

    Attributes:
        acceleration: of the active coordinates (n,), in the charts of the state.
        efforts: along them (n,).
        wrench: on the base from outside (6,) [N, N m].
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
    """The evaluator of a robot, whose base moves by odometry or does not (None).

    Other arguments and errors are those of `MotionEvaluator`.
    """
    if base is None:
        return MotionEvaluator(robot, bandwidth, max_gap, measured, kalman)
    return FloatingEvaluator(robot, bandwidth, max_gap, measured, kalman, base=base)
