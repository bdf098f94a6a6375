"""Interpolation between states, since a browser reports sliders only twenty times a second."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import HybridDynamicsError
from ..robot.robot import Robot

SPAN: Final = 0.05  # [s] interval at which viser's clients report a moving control
FAR: Final = 0.5  # [rad or m] change of an active coordinate beyond which the picture jumps


class StateInterpolation:
    """The drawn state, which moves to the present state within SPAN.

    It is always closed.

    Args:
        robot: the robot.
        state: the first state.
    """

    def __init__(self, robot: Robot, state: ClosedState) -> None:
        self.robot = robot
        self.state = state
        self.start = state
        self.end = state
        self.elapsed = SPAN  # [s] since the start

    @property
    def moving(self) -> bool:
        """Whether it is still moving."""
        return self.state is not self.end

    def move_to(self, state: ClosedState, smoothly: bool) -> None:
        """Start moving to a state.

        Args:
            state: the target.
            smoothly: whether to interpolate. A far state, or one on another assembly mode, is shown
                at once in any case.
        """
        if state is self.end:
            return
        is_near = self._is_near(state)
        self.start = self.state
        self.end = state
        self.elapsed = 0.0
        if not (smoothly and is_near):
            self.state = state

    def _is_near(self, state: ClosedState) -> bool:
        steps = np.abs(state.u - self.state.u)
        distance = float(steps.max(initial=0.0))
        return distance < FAR and state.branch == self.state.branch

    def tick(self, elapsed: float) -> None:
        """Advance by some time [s]."""
        self.elapsed += elapsed
        if self.elapsed >= SPAN:
            self.state = self.end
            return
        share = self.elapsed / SPAN
        u = self.start.u + share * (self.end.u - self.start.u)
        try:
            self.state = self.robot.close(u, near=self.state)
        except HybridDynamicsError:  # the straight line leaves the range, although its end does not
            self.state = self.end
