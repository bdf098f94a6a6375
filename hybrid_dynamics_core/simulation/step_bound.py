"""Bounds of integration steps, so that whole turns of angles stay unambiguous."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..robot.robot import Robot

LONGEST = 1.0  # [rad] largest change of an angle in a step, predicted by its rate
ROOM = 0.5  # largest move of a ball joint in a step, as a share of that to its singular chart
SINGULAR_CHART = 0.5 * np.pi  # [rad] middle angle of a ball joint at which its chart is singular
LARGEST_DEVIATION = 0.5 * np.pi  # [rad] of a loop from its prediction, by which it is followed
PLACES = 9  # least number of samples in a step: the degree of DOP853's output plus one
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

    @property
    def allowed(self) -> float:
        """The longest step that the user, and steps that were too long before, allow [s]."""
        return min(self._max_step, self._shortened)

    @property
    def is_short(self) -> bool:
        """Whether a step was too long not many steps ago."""
        return self._shortened < self._max_step

    def longest(self, state: ClosedState) -> float:
        """The longest step from a state [s]."""
        rates = np.abs(state.ds[self._angles])
        fastest = float(rates.max(initial=0.0))
        allowed = self.allowed
        if fastest * allowed > LONGEST:
            allowed = LONGEST / fastest
        for k in self._middle_turns:
            room = ROOM * (SINGULAR_CHART - abs(state.s[k]))
            if abs(state.ds[k]) > room / allowed:
                allowed = room / abs(state.ds[k])
        return float(allowed)

    def more_places(self, start: ClosedState, y: Array) -> int:
        """Number of additional places at which a step is sampled.

        Args:
            start: state at the start of the step.
            y: (N, 2 n + 1) rows (u, u', work) at some places of the step.
        """
        return self.more_places_of(y[None, :, : len(start.u)], start.R[None])

    def more_places_of(self, u: Array, R: Array) -> int:
        """The same for K steps: the number for the one that moves most.

        Args:
            u: (K, N, n), active coordinates at some places of each step.
            R: (K, n_s, n), at the starts of the steps.
        """
        moves = np.abs(np.diff(u, axis=1)).sum(axis=1)
        angles = np.einsum("kij,kj->ki", np.abs(R[:, self._angles]), moves)
        largest = float(angles.max(initial=0.0))
        return int(min(largest / APART, MOST)) if np.isfinite(largest) else MOST

    def is_too_long(self, start: ClosedState, states: ClosedState) -> bool:
        """Whether an angle deviates by a quarter turn from the prediction at the start of a step.

        It is also true if a ball joint came too near to the singularity of its chart.
        """
        one = len(states.s)
        return bool(self.are_too_long(states, start.s[None], start.R[None], one)[0])

    def are_too_long(
        self, states: ClosedState, s: Array, R: Array, places: int
    ) -> NDArray[np.bool_]:
        """The same for each of K steps, (K,).

        Args:
            states: at places of each step, a batch of K times `places`.
            s: (K, n_s), closed configurations at the starts of the steps.
            R: (K, n_s, n), R there.
            places: number of places of a step.
        """
        by_step = (len(s), places, -1)
        at_places = states.s.reshape(by_step)
        middle = np.abs(at_places[:, :, self._middle_turns]) > SINGULAR_CHART
        n = R.shape[2]
        moves = states.u.reshape(by_step) - s[:, None, :n]
        off = np.abs(at_places - s[:, None] - moves @ R.transpose(0, 2, 1))[:, :, self._angles]
        is_far = np.where(np.isnan(off), 0.0, off) > LARGEST_DEVIATION
        return np.asarray(middle.any(axis=(1, 2)) | is_far.any(axis=(1, 2)))

    def shorten(self, duration: float) -> None:
        """Limit the next step to half of one that was too long [s]."""
        self._shortened = 0.5 * duration

    def relax(self, steps: int = 1) -> None:
        """Let the limit grow again after accepted steps."""
        self._shortened *= 2.0**steps
