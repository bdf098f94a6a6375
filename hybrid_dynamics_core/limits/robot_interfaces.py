"""What limits, and all that comes from limits, need of a robot. `Robot` implements it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..description.model import JointType, RobotDescription
from ..dynamics.loads import Loads
from ..ground.arrays import Array


class DrivenRobot(Protocol):
    """Names, limits, drives and loads of a robot."""

    @property
    def description(self) -> RobotDescription:
        """The description."""

    @property
    def active(self) -> tuple[str, ...]:
        """Names of active coordinates."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates."""

    @property
    def joint_types(self) -> Mapping[str, JointType]:
        """Type by coordinate."""

    @property
    def limits(self) -> Array:
        """Limits (n, 2) of the active coordinates [rad, m]."""

    @property
    def all_drives(self) -> tuple[str, ...]:
        """Names of all drives."""

    @property
    def loads(self) -> Loads:
        """Loads of the description."""


class LimitedRobot(DrivenRobot, Protocol):
    """A robot, as far as its limits use it."""

    @property
    def idle(self) -> tuple[str, ...]:
        """Names of active coordinates without a drive."""

    @property
    def drives(self) -> tuple[str, ...]:
        """Driven joints that determine the motion."""

    def drive_rates(self, state: ClosedState) -> Array:
        """Rates (m, n) of all drives, each column at unit rate of an active coordinate."""

    def drive_forces(self, state: ClosedState, tau: ArrayLike) -> Mapping[str, Array]:
        """Force of each of `drives` that gives tau [N m, N]."""

    def accelerations(self, state: ClosedState, ddu: ArrayLike) -> Array:
        """Accelerations (n_s,) of all coordinates [rad/s^2, m/s^2]."""

    def inverse_dynamics(
        self, state: ClosedState, ddu: ArrayLike, loads: Loads | None = None
    ) -> Array:
        """Efforts (n,) of the active coordinates [N m, N]."""
