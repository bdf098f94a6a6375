"""The interface of robots for inverse kinematics and workspaces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..description.actuators import HydraulicCylinder
from ..description.model import JointType, RobotDescription
from ..ground.arrays import Array
from .pose import Pose
from .pose_chain import PoseChain


class PoseKernels(Protocol):
    """Compiled calls from active coordinates to a pose."""

    @property
    def pose_and_jacobian(self) -> Callable[..., Any]:
        """(u, check=True) -> position (3,), rotation (3, 3) and Jacobian (6, n)."""


class ClosedKinematics(Protocol):
    """Closed kinematics of a robot in its active coordinates u (n,) or (N, n).

    `Robot` implements it, with more detailed docstrings.
    """

    @property
    def name(self) -> str:
        """Name of the robot."""

    @property
    def description(self) -> RobotDescription:
        """The joints and their limits."""

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the active coordinates u."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates s = [u; z]."""

    @property
    def joint_types(self) -> Mapping[str, JointType]:
        """'revolute' or 'prismatic' by coordinate name."""

    @property
    def cylinders(self) -> Mapping[str, HydraulicCylinder]:
        """The hydraulic cylinders, by joint."""

    @property
    def end_effector(self) -> str:
        """Name of the end-effector frame."""

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loops."""

    @property
    def reference(self) -> Array:
        """Active coordinates (n,) of the reference configuration [rad, m]."""

    @property
    def limits(self) -> Array:
        """Lower and upper limit (n, 2) of each active coordinate [rad, m]."""

    @property
    def closing_range(self) -> Array:
        """Range (n, 2) of each active coordinate in which its loop closes [rad, m]."""

    @property
    def follows(self) -> bool:
        """Whether a loop has no closed form, so that its mode follows from a nearby state."""

    @property
    def pose_chain(self) -> PoseChain | None:
        """The end effector's coordinates, if its pose determines them in closed form."""

    @property
    def kernels(self) -> PoseKernels:
        """Compiled calls."""

    def owns(self, state: ClosedState) -> bool:
        """Whether a state has this robot's coordinates and loops."""

    def close(
        self,
        u: ArrayLike,
        du: ArrayLike | None = None,
        check: bool = True,
        near: ClosedState | None = None,
        branch: Mapping[str, str] | None = None,
    ) -> ClosedState:
        """Close all loops at u."""

    def close_given(
        self,
        values: Mapping[str, ArrayLike],
        rates: Mapping[str, ArrayLike] | None = None,
        accelerations: Mapping[str, ArrayLike] | None = None,
        near: ClosedState | None = None,
    ) -> ClosedState:
        """Close from any independent set of n coordinates."""

    def forward_kinematics(
        self,
        state: ClosedState,
        frame: str | None = None,
    ) -> Pose:
        """Pose of a frame in the base frame."""

    def jacobian(
        self,
        state: ClosedState,
        frame: str | None = None,
    ) -> Array:
        """Jacobian (6, n) or (N, 6, n) of a frame's origin, base axes."""
