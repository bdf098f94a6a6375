"""Start of the next call along a motion: the closed configuration of the last one."""

from __future__ import annotations

import numpy as np

from ..closed_state.continuation import Start
from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from .closure import Closure


class WarmStart:
    """Closed configuration from which a compiled call starts, and which it replaces by its result.

    It belongs to one motion and one thread. A call that raises does not change it.

    Attributes:
        signs: branch sign of each block of the closure plan, and the charts of ball joints.
        s: all coordinates (n_s,) [rad, m].
        start_map: R there, row by row (n_s * n,).
    """

    __slots__ = ("s", "signs", "start_map")

    def __init__(self, state: ClosedState) -> None:
        """Set the start to a closed state.

        Raises:
            InputError: the state is a batch, or not closed.
        """
        if state.u.ndim != 1:
            raise InputError(f"a motion starts at one state, not at a batch of {len(state.u)}")
        if state.status:
            raise InputError("the state is not closed (its status says why)")
        self.move_to(state)

    def move_to(self, state: ClosedState) -> None:
        """Set the start to a closed state; of a batch, to its last row."""
        s, start_map = Start(state.s, state.R).flat
        if s.ndim == 2:
            s, start_map = s[-1], start_map[-1]
        signs = state.signs
        if signs.ndim == 2:
            signs = signs[-1]
        self.signs: Array = signs
        self.s: Array = s.copy()
        self.start_map: Array = start_map.copy()

    def state(self, closure: Closure) -> ClosedState:
        """The closed state of the configuration, at rest."""
        return closure.state_at(self.s, np.zeros_like(self.s), self.signs)
