"""What stiffness needs of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..description.model import JointType, RobotDescription
from ..dynamics.loads import Loads
from ..ground.arrays import Array


class Machine(Protocol):
    """A robot, as far as its stiffness uses it."""

    @property
    def description(self) -> RobotDescription:
        """The description."""

    @property
    def active(self) -> tuple[str, ...]:
        """Names of active coordinates."""

    @property
    def reference(self) -> Array:
        """Active coordinates (n,) of the reference configuration."""

    @property
    def limits(self) -> Array:
        """Limits (n, 2) of the active coordinates [rad, m]."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates."""

    @property
    def joint_types(self) -> Mapping[str, JointType]:
        """Type by coordinate."""

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of all frames and links."""

    @property
    def end_effector(self) -> str:
        """Name of the end effector."""

    @property
    def all_drives(self) -> tuple[str, ...]:
        """Names of all drives."""

    @property
    def loads(self) -> Loads:
        """Loads of the description."""

    def owns(self, state: ClosedState) -> bool:
        """Whether a state has this robot's coordinates and loops."""

    def close(self, u: ArrayLike, *, check: bool = True) -> ClosedState:
        """Close the loops."""
