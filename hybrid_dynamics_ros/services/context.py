"""What an answer may look at besides its request: the robot and how it stands."""

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
from ..stream.floating.first_charts import require_first_charts
from ..stream.frames import FrameNames, frame_names
from ..stream.situation import Situation


class ServiceContext:
    """The robot in a situation."""

    def __init__(self, robot: Robot, situation: Situation | None = None) -> None:
        self.robot = robot
        self.situation = situation or Situation()

    @cached_property
    def loads(self) -> Loads:
        """Everything that acts on the robot now."""
        return loads_of(self.robot, self.situation.conditions)

    @property
    def frames(self) -> FrameNames:
        """What frames are called in messages."""
        return frame_names(self.robot, self.situation.settings)

    @property
    def mode(self) -> ClosedState | None:
        """State whose assembly modes are kept; None: those of the robot file."""
        return self.situation.conditions.mode

    def close(self, u: FloatArray, du: FloatArray | None = None) -> ClosedState:
        """The loops closed as the stream closes them.

        Args:
            u: active coordinates (n,) [rad or m].
            du: their rates (n,), zero if None.

        Raises:
            StateError: as `robot.close` does.
        """
        state = self.robot.close(u, du, near=self.mode)
        require_first_charts(self.robot, state)
        return state

    def active_motion(self, message: JointState) -> OrderedMotion:
        """Motion of the active joints in a message.

        Raises:
            RejectedError: as `JointOrder.arrange` does.
        """
        return active_order(self.robot).arrange(conversions.sample_of_state(message))

    def newest(self, otherwise: str = "") -> FloatArray:
        """Active joints at the newest input (n,) [rad or m].

        Args:
            otherwise: what else than sending joint states the caller can do.

        Raises:
            RejectedError: there was none.
        """
        if self.situation.newest is None:
            text = f"no input has come yet: send joint states to ~/active_joint_states{otherwise}"
            raise RejectedError(RejectionCode.NOT_READY, text)
        return self.situation.newest


def require_finite(*arrays: FloatArray | None) -> None:
    """Refuse an answer that would hold NaN or infinity.

    Raises:
        RejectedError: it would.
    """
    for values in arrays:
        if values is not None and not np.isfinite(values).all():
            raise RejectedError(
                RejectionCode.OVERFLOW, "the input is too large: the answer would not be finite"
            )
