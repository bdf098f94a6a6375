"""The context of a service call: the robot and its situation."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from sensor_msgs.msg import JointState

from hybrid_dynamics_core import ClosedState, Loads, Robot

from ..messages import conversions
from ..messages.joint_samples import (
    FloatArray,
    OrderedMotion,
    RejectedError,
    RejectionCode,
    active_order,
)
from ..stream.conditions import loads_of
from ..stream.floating.first_charts import (
    CoordinateMotion,
    in_first_charts,
    motion_in_first,
)
from ..stream.frames import FrameNames, frame_names
from ..stream.situation import Situation


class ServiceContext:
    """The robot in a situation."""

    def __init__(self, robot: Robot, situation: Situation | None = None) -> None:
        self.robot = robot
        self.situation = situation or Situation()

    @cached_property
    def loads(self) -> Loads:
        """The present loads on the robot."""
        return loads_of(self.robot, self.situation.conditions)

    @property
    def frames(self) -> FrameNames:
        """Names of frames in messages."""
        return frame_names(self.robot, self.situation.settings)

    @property
    def mode(self) -> ClosedState | None:
        """A state whose assembly modes are kept; None for those of the robot file."""
        return self.situation.conditions.mode

    @cached_property
    def start(self) -> ClosedState | None:
        """A state near which loops are closed, in the angles of messages.

        None if those of the robot file are, and assembly modes are those of the robot file.
        """
        robot, mode = self.robot, self.mode
        if not robot.description.freely_turning:
            return mode
        state = robot.close(robot.reference) if mode is None else mode
        start = robot.in_urdf_angles(state)
        return mode if start is state else start

    @property
    def reference(self) -> FloatArray:
        """The active coordinates (n,) of the reference configuration, as in messages."""
        robot = self.robot
        s, _ = in_first_charts(robot, robot.close(robot.reference))
        return s[: len(robot.active)]

    def close(self, u: FloatArray, du: FloatArray | None = None) -> ClosedState:
        """Close the loops on the assembly modes of the stream.

        Args:
            u: active coordinates (n,) [rad or m].
            du: their rates (n,), zero if None.

        Raises:
            StateError: as in `robot.close`.
        """
        return self.robot.close(u, du, near=self.start)

    def motion_of(self, state: ClosedState, dds: FloatArray | None = None) -> CoordinateMotion:
        """The motion of a state as messages have it.

        Args:
            state: the state.
            dds: accelerations of all coordinates (n_s,) in its charts; None if unknown.

        Raises:
            SingularityError: as in `motion_in_first`.
            RejectedError: a number is not finite.
        """
        with np.errstate(invalid="ignore"):
            motion = motion_in_first(self.robot, state, dds)
        require_finite(*motion)
        return motion

    def active_motion(self, message: JointState) -> OrderedMotion:
        """The motion of the active joints in a message.

        Raises:
            RejectedError: as in `JointOrder.arrange`.
        """
        return active_order(self.robot).arrange(conversions.sample_of_state(message))

    def newest(self, otherwise: str = "") -> FloatArray:
        """Active joints (n,) at the newest input [rad or m].

        Args:
            otherwise: an alternative to sending joint states, for the error text.

        Raises:
            RejectedError: there was no input.
        """
        if self.situation.newest is None:
            text = f"no input has come yet: send joint states to ~/active_joint_states{otherwise}"
            raise RejectedError(RejectionCode.NOT_READY, text)
        return self.situation.newest


def require_finite(*arrays: FloatArray | None) -> None:
    """Check that a result is finite.

    Raises:
        RejectedError: it has NaN or infinity.
    """
    for values in arrays:
        if values is not None and not np.isfinite(values).all():
            raise RejectedError(
                RejectionCode.OVERFLOW, "the input is too large: the answer would not be finite"
            )
