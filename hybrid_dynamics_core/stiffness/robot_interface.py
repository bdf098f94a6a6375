"""What stiffness needs of a robot. `Robot` implements it."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..limits.robot_interfaces import DrivenRobot


class ElasticRobot(DrivenRobot, Protocol):
    """A robot, as far as its stiffness uses it."""

    @property
    def reference(self) -> Array:
        """Active coordinates (n,) of the reference configuration [rad, m]."""

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of all frames and links."""

    @property
    def end_effector(self) -> str:
        """Name of the end effector."""

    def owns(self, state: ClosedState) -> bool:
        """Whether a state has this robot's coordinates and loops."""

    def close(self, u: ArrayLike, *, check: bool = True) -> ClosedState:
        """Close the loops."""
