"""What retiming needs of a robot. `Robot` implements it."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..limits.robot_interfaces import LimitedRobot


class RetimedRobot(LimitedRobot, Protocol):
    """A robot, as far as retiming uses it."""

    @property
    def name(self) -> str:
        """Name of the robot."""

    def close(
        self,
        u: ArrayLike,
        du: ArrayLike | None = None,
        *,
        check: bool = True,
        near: ClosedState | None = None,
    ) -> ClosedState:
        """Closed states of active coordinates (n,) or (N, n)."""
