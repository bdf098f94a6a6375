"""Coordinates in which a motion is integrated, and what is recorded of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...closed_state.passages.recorded import Passed
from ...closed_state.state import ClosedState
from ...dynamics.energy import Energy
from ...dynamics.loads import Loads
from ...ground.arrays import Array
from ...robot.robot import Robot
from ..search import Step
from .anchors import Anchors


class Recorded(NamedTuple):
    """What is known of N samples, in the coordinates of the robot that is simulated.

    Attributes:
        state: their closed states, a batch.
        ddu: active accelerations (N, n) [rad/s^2, m/s^2].
        energy: their energies.
    """

    state: ClosedState
    ddu: Array
    energy: Energy


class Coordinates:
    """The active coordinates of a robot.

    Args:
        robot: the robot.
        anchor: closed state to follow from.
        loads: loads besides the actuators; those of the description if None.
    """

    def __init__(
        self,
        robot: Robot,
        anchor: ClosedState,
        loads: Loads | None,
    ) -> None:
        self.robot = robot
        self.loads = loads
        self.move_to(anchor)

    @property
    def simulated(self) -> Robot:
        """The robot that is simulated."""
        return self.robot

    def move_to(self, anchor: ClosedState) -> None:
        """Follow from another state."""
        self.anchor = anchor
        self.motion_from_anchor = self.robot.motion_near(anchor, self.loads)

    def near(
        self,
        u: Array,
        du: Array,
    ) -> ClosedState:
        """The states at u and u', (n,) or (N, n); their status says whether they close."""
        return self.robot.close(u, du, check=False, near=self.anchor)

    def ordered(self, values: Array) -> Array:
        """Values of all coordinates (..., n_s), in the order of the simulated robot."""
        return values

    def efforts(
        self,
        _state: ClosedState,
        tau: Array,
    ) -> Array:
        """Efforts along these coordinates, from those of the simulated robot; (n,) or (N, n)."""
        return tau

    def simulated_state(self, state: ClosedState) -> ClosedState:
        """A state of these coordinates, or a batch, in the active ones of the simulated robot."""
        return state

    def motion(
        self,
        u: Array,
        du: Array,
        tau: Array,
    ) -> tuple[Array, float]:
        """u'' (n,) and power [W] at u, u' and efforts tau (n,) of the simulated robot."""
        return self.motion_from_anchor(u, du, tau)

    def longest(self, _du: Array) -> float:
        """The longest step at rates du [s], besides the usual bound."""
        return float(np.inf)

    def passed(self, _step: Step) -> list[tuple[float, Passed]]:
        """The singular places that are passed in a step, with their times [s]."""
        return []

    def recorded(
        self,
        y: Array,
        anchors: Anchors,
        tau: Array,
    ) -> Recorded:
        """What is recorded of samples.

        Args:
            y: u, u' and work of the samples (N, 2 n + 1).
            anchors: closed configuration to follow each sample from.
            tau: efforts (N, n) of the simulated robot.
        """
        state = self.closed(y, anchors)
        ddu = self.robot.forward_dynamics(state, tau, self.loads)
        return Recorded(state, ddu, self.robot.energy(state, self.loads))

    def closed(
        self,
        y: Array,
        anchors: Anchors,
    ) -> ClosedState:
        """The states of samples, as a batch of these coordinates."""
        n = len(self.anchor.u)
        return self.robot.close(y[:, :n], y[:, n : 2 * n], near=anchors.as_near(self.anchor))
