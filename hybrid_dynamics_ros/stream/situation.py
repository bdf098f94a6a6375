"""What an answer may look at besides its request: the robot and how it stands."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Robot

from ..messages.joint_samples import FloatArray, RejectedError, RejectionCode
from ..parameters import Settings
from .conditions import Conditions, loads_of


@dataclass(frozen=True, eq=False)
class Situation:
    """How things stand when a call comes in. Plain values: they travel to the process that answers.

    Attributes:
        conditions: gravity, payloads, assembly modes.
        settings: the parameters.
        measured: joints that the stream gives.
        newest: active joints at the newest input (n,) [rad or m], or None before the first.
        moving: whether they moved then.
    """

    conditions: Conditions = field(default_factory=Conditions)
    settings: Settings = field(default_factory=Settings)
    measured: tuple[str, ...] = ()
    newest: FloatArray | None = None
    moving: bool = False


class Context:
    """The robot in a situation."""

    def __init__(self, robot: Robot, situation: Situation | None = None) -> None:
        self.robot = robot
        self.situation = situation or Situation()

    @cached_property
    def loads(self) -> Loads:
        """Everything that acts on the robot now."""
        return loads_of(self.robot, self.situation.conditions)

    def close(self, u: FloatArray, du: FloatArray | None = None) -> ClosedState:
        """The loops closed as the stream closes them. Raises StateError as `robot.close` does."""
        return self.robot.close(u, du, near=self.situation.conditions.mode)

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
    if not all(values is None or np.isfinite(values).all() for values in arrays):
        raise RejectedError(
            RejectionCode.OVERFLOW, "the input is too large: the answer would not be finite"
        )
