"""How far a step of an integrator may go: no angle so far that its whole turns are in doubt."""

from __future__ import annotations

import numpy as np

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..robot.robot import Robot

LONGEST = 1.0  # [rad] that an angle goes in a step, as far as its rate tells before
ROOM = 0.5  # share of the way to where its chart is singular that a ball joint goes in a step
SINGULAR_CHART = 0.5 * np.pi  # [rad] of the middle one of three turns
DOUBT = 0.5 * np.pi  # [rad] off the prediction that the equations of motion follow loops by
APART = 0.1  # [rad] between places of a step that are looked at
MOST = 64  # places more than the least


class StepBound:
    """Bounds the steps of one simulation.

    Args:
        robot: whose angles are looked at.
        max_step: what the user allows [s].
    """

    def __init__(self, robot: Robot, max_step: float) -> None:
        is_angle = [robot.joint_types[name] == "revolute" for name in robot.coordinates]
        self._angles = np.flatnonzero(is_angle)
        self._middle_turns = robot.middle_turns
        self._max_step = max_step
        self._shortened = np.inf

    def longest(self, state: ClosedState) -> float:
        """The longest step from a state [s]."""
        rates = np.abs(state.ds[self._angles])
        fastest = float(rates.max(initial=0.0))
        allowed = min(self._max_step, self._shortened)
        if fastest * allowed > LONGEST:
            allowed = LONGEST / fastest
        for k in self._middle_turns:
            room = ROOM * (SINGULAR_CHART - abs(state.s[k]))
            if abs(state.ds[k]) * allowed > room:
                allowed = room / abs(state.ds[k])
        return float(allowed)

    def more_places(self, start: ClosedState, y: Array) -> int:
        """How many more places of a step are looked at.

        Args:
            start: state at the start of the step.
            y: (u, u', work) at some places of the step (N, 2 n + 1).
        """
        n = len(start.u)
        moves = np.abs(np.diff(y[:, :n], axis=0)) @ np.abs(start.R[self._angles]).T
        way = float(moves.sum(axis=0).max(initial=0.0))
        return int(min(way / APART, MOST)) if np.isfinite(way) else MOST

    def is_too_long(self, start: ClosedState, states: ClosedState) -> bool:
        """Whether some angle of a step leaves the prediction from its start by a quarter turn.

        Or a ball joint came to the end of its chart.
        """
        if (np.abs(states.s[:, self._middle_turns]) > SINGULAR_CHART).any():
            return True
        predicted = start.s + (states.u - start.u) @ start.R.T
        off = np.abs(states.s - predicted)[:, self._angles]
        return bool((np.nan_to_num(off) > DOUBT).any())

    def shorten(self, duration: float) -> None:
        """Let the next step be half of one that was too long [s]."""
        self._shortened = 0.5 * duration

    def relax(self) -> None:
        """Let steps grow again after one that was good."""
        self._shortened *= 2.0
