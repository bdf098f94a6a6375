"""What is shown now: one closed state, followed live; nothing of the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.assembly_modes import AssemblyMode, mode_of
from ..closed_state.state import ClosedState
from ..description.effects import Payload
from ..errors import HybridDynamicsError, StateError
from ..ground.arrays import Array
from ..robot.robot import Robot
from .motion import Motion
from .scale import EffortScale


@dataclass(frozen=True, eq=False)
class Efforts:
    """Efforts of the driven joints: `values` (k,) [N m or N] in the order of `joints`.

    full: (k,) what a full bar is [N m or N].
    recorded: (n,) of the active joints, where they were measured. problem: why there are none.
    """

    joints: tuple[str, ...]
    values: Array
    full: Array
    recorded: Array | None = None
    problem: str = ""

    @property
    def shares(self) -> list[float]:
        """Each relative to its full bar; beyond 1 where a drive cannot give it."""
        return list((self.values / self.full).tolist())

    @classmethod
    def none(cls, problem: str) -> Efforts:
        """Where there are none, and why."""
        return cls((), np.zeros(0), np.zeros(0), None, problem)


class Session:
    """A robot and the state it is in; every change either gives another closed state or leaves it and says why."""

    def __init__(self, robot: Robot, motion: Motion | None = None) -> None:
        self.robot, self.motion = robot, motion
        self.home = robot.close(robot.reference)
        self.state = self.home
        self.problem = ""  # why the last change was refused
        self.payload = 0.0  # [kg] at the end effector, besides the robot's own
        self.scale = EffortScale(robot)
        self.sample: int | None = None  # of the motion, while it is shown

    def move(self, u: ArrayLike) -> bool:
        """Follow the active coordinates (n,) from where they are; False where the loops do not close there."""
        try:
            self.take_state(self.robot.close(u, near=self.state))
        except StateError as error:
            self.problem = str(error)
            return False
        return True

    def reset(self) -> None:
        """Back to the reference, on the robot's own assembly mode, without payload."""
        self.take_state(self.home)
        self.payload = 0.0

    def lift(self, payload: float) -> None:
        """Take another payload [kg]."""
        self.payload, self.problem = payload, ""

    def take_state(self, state: ClosedState) -> None:
        """Jump to a closed state."""
        self.state, self.problem, self.sample = state, "", None

    def show_sample(self, index: int) -> None:
        """The state of one sample of the motion."""
        if self.motion is not None:
            self.state, self.problem, self.sample = self.motion.at(index), "", index

    def modes(self) -> tuple[AssemblyMode, ...]:
        """Every way in which the loops close at the present active coordinates."""
        return self.robot.assembly_modes(self.state.u)

    def take_mode(self, mode: AssemblyMode) -> None:
        """Jump to another assembly mode at the same active coordinates."""
        self.take_state(mode.state)

    def present(self, modes: Sequence[AssemblyMode]) -> int | None:
        """Which of the modes the present state is."""
        return mode_of(modes, self.state)

    def efforts(self) -> Efforts:
        """What the drives give: at rest, or with the rates and accelerations of the motion's sample."""
        robot, state, ddu = self.robot, self.state, np.zeros(len(self.robot.active))
        recorded = None
        if self.motion is not None and self.sample is not None:
            ddu = self.motion.ddu[self.sample]
            recorded = None if self.motion.recorded is None else self.motion.recorded[self.sample]
        if not np.isfinite(ddu).all():
            return Efforts.none("accelerations are not known at this sample")
        loads = (
            robot.loads.with_payload(Payload(self.payload), robot.end_effector)
            if self.payload
            else robot.loads
        )
        try:
            forces = robot.drive_forces(state, robot.inverse_dynamics(state, ddu, loads))
        except HybridDynamicsError as error:
            return Efforts.none(str(error))
        values = np.array([float(value) for value in forces.values()])
        return Efforts(tuple(forces), values, self.scale.full(tuple(forces), values), recorded)
