"""What capabilities and lifting charts need of a robot. `Robot` implements it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from ..limits.robot_interfaces import DrivenRobot


class CapableRobot(DrivenRobot, Protocol):
    """A robot, as far as its capability uses it."""

    @property
    def end_effector(self) -> str:
        """Name of the end effector."""

    @property
    def effort_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Least and greatest effort by drive [N m, N]."""

    @property
    def rate_ranges(self) -> Mapping[str, float]:
        """Largest rate by coordinate [rad/s, m/s]."""

    def drive_rates(self, state: ClosedState) -> Array:
        """Rates (m, n) of the drives, each column at unit rate of an active coordinate."""

    def jacobian(self, state: ClosedState, frame: str | None = None) -> Array:
        """Jacobian (6, n) of a frame, linear before angular."""

    def inverse_dynamics(
        self, state: ClosedState, ddu: ArrayLike, loads: Loads | None = None
    ) -> Array:
        """Efforts (n,) of the active coordinates [N m, N]."""

    def minimal_form(
        self, state: ClosedState, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """Mass matrix (n, n), then the terms of rates and of gravity (n,)."""
