"""Pictures between two states: a browser reports a slider twenty times a second, which is jerky."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import HybridDynamicsError
from ..robot.robot import Robot

SPAN: Final = 0.05  # [s] viser's clients tell no more often of a control that is moved
FAR: Final = 0.5  # [rad or m] in an active coordinate: beyond it the picture jumps


class StateInterpolation:
    """The state that is drawn, on its way to the present one.

    It is closed at every moment, and arrives after SPAN.

    Args:
        robot: that moves.
        state: that is drawn first.
    """

    def __init__(self, robot: Robot, state: ClosedState) -> None:
        self.robot = robot
        self.state = state
        self.start = state
        self.end = state
        self.elapsed = SPAN  # [s] since the start

    @property
    def moving(self) -> bool:
        """Whether it is still on its way."""
        return self.state is not self.end

    def move_to(self, state: ClosedState, smoothly: bool) -> None:
        """Set out to a state.

        Args:
            state: the end of the way.
            smoothly: False, a state that is far, and one on another assembly mode are shown at
                once.
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
        """Go on by some seconds."""
        self.elapsed += elapsed
        if self.elapsed >= SPAN:
            self.state = self.end
            return
        share = self.elapsed / SPAN
        u = self.start.u + share * (self.end.u - self.start.u)
        try:
            self.state = self.robot.close(u, near=self.state)
        except HybridDynamicsError:  # the straight way leaves the range, the wanted state does not
            self.state = self.end
