"""The charts of ball and free joints: which a state is in, and the same state in others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..algebra.charts import LEAVE, in_other_chart
from ..closed_state.closure_solver import ClosureResults
from ..closed_state.state import ClosedState
from ..ground.arrays import Array, frozen
from .model import RobotModel
from .state_builder import StateBuilder

# (u, du, signs, guess) -> results and codes
RunClosure = Callable[[Array, Array, Array, Array], ClosureResults]


class Charts:
    """Changes of charts of one robot.

    Args:
        model: names, tree and closure plan of the robot.
        run: the closure kernel.
        states: makes states of its results.
    """

    def __init__(self, model: RobotModel, run: RunClosure, states: StateBuilder) -> None:
        self._model = model
        self._run = run
        self._states = states
        self._blocks = len(model.plan.blocks)

    def of(self, state: ClosedState) -> Array:
        """Chart of each ball and free joint, (c,) or (N, c), +1 or -1."""
        charts = state.signs[..., self._blocks :]
        return np.broadcast_to(charts, (*state.u.shape[:-1], charts.shape[-1]))

    def change(self, state: ClosedState, charts: Array) -> ClosedState:
        """The same state with ball and free joints in given charts, (c,) or (N, c)."""
        before = self.of(state)
        if np.array_equal(before, charts):
            return state
        s = state.s.copy()
        ds = state.ds.copy()
        for k, turns in enumerate(self._model.tree.turns):
            s[..., turns], ds[..., turns] = in_other_chart(
                s[..., turns], ds[..., turns], before[..., k], charts[..., k]
            )
        of_blocks = np.broadcast_to(state.signs[..., : self._blocks], (*s.shape[:-1], self._blocks))
        signs = frozen(np.concatenate([of_blocks, charts], axis=-1))
        u, du = s[..., : state.n].copy(), ds[..., : state.n].copy()
        values, codes = self._run(u, du, signs, s)
        moved = self._states.build(u, du, signs, values, codes, check=False)
        return replace(moved, branch=state.branch)

    def recentred(self, state: ClosedState, leave: float = LEAVE) -> ClosedState:
        """The same state, each ball and free joint beyond `leave` [rad] in its other chart."""
        charts = self.of(state).copy()
        for k, (_, middle, _) in enumerate(self._model.tree.turns):
            far = np.abs(state.s[..., middle]) > leave
            charts[..., k] *= np.where(far, -1.0, 1.0)
        return self.change(state, charts)
