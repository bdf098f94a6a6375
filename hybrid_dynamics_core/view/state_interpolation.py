"""Pictures between two states: a browser tells of a slider twenty times a second, which the eye sees as jerks."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import HybridDynamicsError
from ..robot.robot import Robot

SPAN: Final = 0.05  # [s] viser's clients tell no more often of a control that is moved
FAR: Final = 0.5  # [rad or m] in an active coordinate: beyond it the picture jumps


class Glide:
    """The state that is drawn, on its way to the present one: closed at every moment, and there after SPAN."""

    def __init__(self, robot: Robot, state: ClosedState) -> None:
        self.robot = robot
        self.state = self.start = self.end = state
        self.since = SPAN

    @property
    def moving(self) -> bool:
        """Whether it is still on its way."""
        return self.state is not self.end

    def to(self, state: ClosedState, smoothly: bool) -> None:
        """Set out to a state; at once where it is far, on another assembly mode, or not `smoothly`."""
        if state is self.end:
            return
        near = (
            float(np.abs(state.u - self.state.u).max(initial=0.0)) < FAR
            and state.branch == self.state.branch
        )
        self.start, self.end, self.since = self.state, state, 0.0
        if not (smoothly and near):
            self.state = state

    def tick(self, elapsed: float) -> None:
        """Go on by some seconds."""
        self.since += elapsed
        if self.since >= SPAN:
            self.state = self.end
            return
        u = self.start.u + self.since / SPAN * (self.end.u - self.start.u)
        try:
            self.state = self.robot.close(u, near=self.state)
        except HybridDynamicsError:  # the straight way leaves the range, the wanted state does not
            self.state = self.end
