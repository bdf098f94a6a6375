"""The charts of ball and free joints: which a state is in, and the same state in others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..algebra.charts import LEAVE, in_other_chart
from ..closed_state.assembly_modes import matching_signs
from ..closed_state.closure_solver import ClosureResults
from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import StateError
from ..ground.arrays import Array, frozen
from .model import RobotModel
from .state_builder import StateBuilder

# (u, du, signs, guess) -> results and codes
RunClosure = Callable[[Array, Array, Array, Array], ClosureResults]
# (u, du, check, near) -> state
Close = Callable[[Array, Array, bool, ClosedState | None], ClosedState]
MOST_HALVINGS = 8  # of a way on which a ball joint in a loop changes its chart


class Charts:
    """Changes of charts of one robot.

    Attributes:
        change_in_loops: whether some ball or free joint is passive: the loops decide how it stands.

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
        passive = [turns[1] >= len(model.active) for turns in model.tree.turns]
        self._passive = tuple(passive)
        self.change_in_loops = any(passive)

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
        signs = frozen(self._signs(state, s, charts))
        u, du = s[..., : state.n].copy(), ds[..., : state.n].copy()
        values, codes = self._run(u, du, signs, s)
        moved = self._states.build(u, du, signs, values, codes, check=False)
        return replace(moved, branch=state.branch)

    def _signs(self, state: ClosedState, s: Array, charts: Array) -> Array:
        """Signs on which the plan gives s (n_s,) or (N, n_s) in charts (c,) or (N, c)."""
        if self.change_in_loops:
            # a leg on a ball joint may have another sign in another chart
            model = self._model.program_model
            if s.ndim == 1:
                return matching_signs(model, s, charts)
            pairs = zip(s, charts, strict=True)
            return np.array([matching_signs(model, row, chart) for row, chart in pairs])
        of_blocks = state.signs[..., : self._blocks]
        of_blocks = np.broadcast_to(of_blocks, (*s.shape[:-1], self._blocks))
        return np.concatenate([of_blocks, charts], axis=-1)

    def recentred(
        self, state: ClosedState, leave: float = LEAVE, active: bool = True
    ) -> ClosedState:
        """The same state, each ball and free joint beyond `leave` [rad] in its other chart.

        Args:
            state: closed state, or a batch of N.
            leave: angle of the second turn up to which a joint keeps its chart [rad].
            active: whether active joints change theirs too, which u depends on.
        """
        charts = self.of(state).copy()
        for k, (_, middle, _) in enumerate(self._model.tree.turns):
            far = np.abs(state.s[..., middle]) > leave
            if active or self._passive[k]:
                charts[..., k] *= np.where(far, -1.0, 1.0)
        return self.change(state, charts)

    def close(
        self, close: Close, u: Array, du: Array, check: bool, near: ClosedState | None
    ) -> ClosedState:
        """Close where ball joints in loops may have to change their charts on the way.

        Args:
            close: closes in the charts of the state that it comes from.
            u: active coordinates (n,) or (N, n) [rad, m].
            du: active rates of the same shape [rad/s, m/s].
            check: whether a state that does not close is an error.
            near: closed state to come from; the reference if None.
        """
        if near is not None:
            near = self.recentred(near, active=False)
        state = close(u, du, False, near)
        if not np.any(state.status):
            return state
        start = near
        if start is None:
            start = close(self._model.reference, np.zeros(state.n), True, None)
        if u.ndim == 1:
            state = self._by_halves(close, u, du, start)
        else:
            rows: list[ClosedState] = []
            for k, status in enumerate(np.atleast_1d(state.status)):
                row = state.rows(k)
                if status != ClosureStatus.OK:
                    begin = start.rows(k) if start.u.ndim == 2 else start
                    row = self._by_halves(close, u[k], du[k], begin)
                rows.append(row)
            state = ClosedState.joined(rows)
        if check and np.any(state.status):
            return close(u, du, True, near)  # for its error
        return state

    def close_path(
        self, close: Close, u: Array, du: Array, near: ClosedState | None
    ) -> ClosedState:
        """Close along a motion (N, n), each row from the one before, as `close` does.

        Raises:
            StateError: the first row that does not close; its `index` says which.
        """
        states: list[ClosedState] = []
        for k, row in enumerate(u):
            try:
                near = self.close(close, row, du[k], True, near)
            except StateError as error:
                error.place_in_row(k)
                raise
            states.append(near)
        return ClosedState.joined(states)

    def _by_halves(
        self, close: Close, u: Array, du: Array, start: ClosedState, depth: int = 0
    ) -> ClosedState:
        """Close at u (n,) from a start; by way of the middle where it cannot be done at once."""
        start = self.recentred(start, active=False)
        state = close(u, du, False, start)
        if state.status is ClosureStatus.OK or depth == MOST_HALVINGS:
            return state
        middle = self._by_halves(close, 0.5 * (start.u + u), np.zeros_like(u), start, depth + 1)
        if middle.status is not ClosureStatus.OK:
            return state
        return self._by_halves(close, u, du, middle, depth + 1)
