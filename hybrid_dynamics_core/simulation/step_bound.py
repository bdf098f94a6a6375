"""Bounds of integration steps, so that whole turns of angles stay unambiguous."""

from __future__ import annotations

import numpy as np

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..robot.robot import Robot

LONGEST = 1.0  # [rad] largest change of an angle in a step, predicted by its rate
ROOM = 0.5  # largest move of a ball joint in a step, as a share of that to its singular chart
SINGULAR_CHART = 0.5 * np.pi  # [rad] middle angle of a ball joint at which its chart is singular
DOUBT = 0.5 * np.pi  # [rad] largest deviation from the prediction that loops are followed by
APART = 0.1  # [rad] largest change of an angle between sampled places of a step
MOST = 64  # largest number of additional places


class StepBound:
    """Step bound of one simulation.

    Args:
        robot: the model.
        max_step: longest step allowed by the user [s].
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
        """Number of additional places at which a step is sampled.

        Args:
            start: state at the start of the step.
            y: (N, 2 n + 1) rows (u, u', work) at some places of the step.
        """
        n = len(start.u)
        moves = np.abs(np.diff(y[:, :n], axis=0)) @ np.abs(start.R[self._angles]).T
        way = float(moves.sum(axis=0).max(initial=0.0))
        return int(min(way / APART, MOST)) if np.isfinite(way) else MOST

    def is_too_long(self, start: ClosedState, states: ClosedState) -> bool:
        """Whether an angle deviates by a quarter turn from the prediction at the start of a step.

        It is also true if a ball joint came too near to the singularity of its chart.
        """
        if (np.abs(states.s[:, self._middle_turns]) > SINGULAR_CHART).any():
            return True
        predicted = start.s + (states.u - start.u) @ start.R.T
        off = np.abs(states.s - predicted)[:, self._angles]
        return bool((np.nan_to_num(off) > DOUBT).any())

    def shorten(self, duration: float) -> None:
        """Limit the next step to half of one that was too long [s]."""
        self._shortened = 0.5 * duration

    def relax(self) -> None:
        """Let the limit grow again after an accepted step."""
        self._shortened *= 2.0
