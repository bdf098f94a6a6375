"""The state of a viewer, independent of its picture: one closed state, followed live."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.assembly_modes import AssemblyMode, mode_of
from ..closed_state.state import ClosedState
from ..description.effects import Payload
from ..dynamics.hydraulics import CylinderState
from ..dynamics.loads import Loads
from ..dynamics.reactions import PinReaction
from ..errors import HybridDynamicsError, StateError
from ..ground.arrays import Array
from ..kinematics.inverse_kinematics import follow_position
from ..robot.robot import Robot
from ..stiffness import Modes
from .effort_scale import EffortScale
from .motion import Motion


@dataclass(frozen=True, eq=False)
class DriveEfforts:
    """Efforts of the driven joints.

    Attributes:
        joints: their names.
        values: (k,) efforts [N m or N].
        full: (k,) efforts of full bars [N m or N].
        recorded: (n,) measured efforts of the active joints [N m or N], or None.
        problem: why there are no efforts; or empty.
    """

    joints: tuple[str, ...]
    values: Array
    full: Array
    recorded: Array | None = None
    problem: str = ""

    @property
    def shares(self) -> list[float]:
        """Efforts relative to full bars; above 1 if a drive cannot give it."""
        return list((self.values / self.full).tolist())

    @classmethod
    def none(cls, problem: str) -> DriveEfforts:
        """No efforts, with the reason."""
        return cls((), np.zeros(0), np.zeros(0), None, problem)


class ViewSession:
    """A robot and its present state.

    A change either leads to another closed state, or is refused with the reason in `problem`.

    Args:
        robot: the robot.
        motion: a motion for playback, or None.

    Attributes:
        reference: the state of the reference configuration.
        state: the present state.
        problem: why the last change was refused.
        payload: additional payload at the end effector [kg].
        scale: scale of the effort bars.
        sample: index of the shown sample of the motion, or None.
    """

    def __init__(self, robot: Robot, motion: Motion | None = None) -> None:
        self.robot = robot
        self.motion = motion
        self.reference = robot.close(robot.reference)
        self.state = self.reference
        self.problem = ""
        self.payload = 0.0
        self.scale = EffortScale(robot)
        self.sample: int | None = None

    def move(self, u: ArrayLike) -> bool:
        """Follow the active coordinates (n,) from the present state [rad or m].

        Returns:
            False if the loops do not close there.
        """
        try:
            self.take_state(self.robot.close(u, near=self.state))
        except StateError as error:
            self.problem = str(error)
            return False
        return True

    def tool(self) -> Array:
        """(3,) place of the end effector, base axes [m]."""
        return np.asarray(self.robot.forward_kinematics(self.state).position)

    def reach(self, place: ArrayLike) -> bool:
        """Bring the end effector to a place (3,) [m], or as near to it as the robot can.

        Returns:
            False if no closed state was found.
        """
        state = follow_position(self.robot, place, self.state)
        if state is None:
            self.problem = "the loops do not close at the nearest place that was found"
            return False
        self.take_state(state)
        return True

    def reset(self) -> None:
        """Return to the reference, on the robot's own assembly mode, without payload."""
        self.take_state(self.reference)
        self.payload = 0.0

    def lift(self, payload: float) -> None:
        """Set the payload [kg]."""
        self.payload = payload
        self.problem = ""

    def take_state(self, state: ClosedState) -> None:
        """Jump to a closed state."""
        self.state = state
        self.problem = ""
        self.sample = None

    def show_sample(self, index: int) -> None:
        """Show one sample of the motion."""
        if self.motion is not None:
            self.state = self.motion.at(index)
            self.problem = ""
            self.sample = index

    def modes(self) -> tuple[AssemblyMode, ...]:
        """The assembly modes at the present active coordinates."""
        return self.robot.assembly_modes(self.state.u)

    def take_mode(self, mode: AssemblyMode) -> None:
        """Jump to another assembly mode at the same active coordinates."""
        self.take_state(mode.state)

    def present(self, modes: Sequence[AssemblyMode]) -> int | None:
        """The index of the present state's mode, or None."""
        return mode_of(modes, self.state)

    def efforts(self) -> DriveEfforts:
        """Efforts of the drives: static, or with the accelerations of the motion's sample."""
        ddu = self._accelerations()
        if not np.isfinite(ddu).all():
            return DriveEfforts.none("accelerations are not known at this sample")
        robot = self.robot
        try:
            tau = robot.inverse_dynamics(self.state, ddu, self._loads())
            forces = robot.drive_forces(self.state, tau)
        except HybridDynamicsError as error:
            return DriveEfforts.none(str(error))
        joints = tuple(forces)
        values = np.array([float(force) for force in forces.values()])
        full = self.scale.full(joints, values)
        return DriveEfforts(joints, values, full, self._recorded())

    def hydraulics(self) -> Mapping[str, CylinderState]:
        """Pressures and flows of the cylinders, as for `efforts`.

        Raises:
            HybridDynamicsError: there are no efforts.
        """
        tau = self.robot.inverse_dynamics(self.state, self._accelerations(), self._loads())
        return self.robot.hydraulics(self.state, tau)

    def pins(self) -> Mapping[str, PinReaction]:
        """The reactions in the pins of loops, as for `efforts`.

        Raises:
            HybridDynamicsError: they cannot be computed.
        """
        return self.robot.reactions(self.state, self._accelerations(), self._loads()).pins

    def natural_modes(self) -> Modes:
        """Natural modes at the present state, with the payload and drives locked.

        Raises:
            HybridDynamicsError: there are none.
        """
        return self.robot.stiffness(self.state).modes(self._loads())

    def _accelerations(self) -> Array:
        """(n,) accelerations of the active joints."""
        if self.motion is None or self.sample is None:
            return np.zeros(len(self.robot.active))
        return np.asarray(self.motion.ddu[self.sample])

    def _recorded(self) -> Array | None:
        """(n,) measured efforts of the shown sample."""
        if self.motion is None or self.sample is None or self.motion.recorded is None:
            return None
        return np.asarray(self.motion.recorded[self.sample])

    def _loads(self) -> Loads:
        loads = self.robot.loads
        if self.payload:
            return loads.with_payload(Payload(self.payload), self.robot.end_effector)
        return loads
