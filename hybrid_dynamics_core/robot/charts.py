"""Charts of ball and free joints, and conversion of states between charts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..algebra.charts import FIRST, LEAVE, in_other_chart
from ..closed_state.assembly_modes import matching_signs
from ..closed_state.closure_solver import ClosureResults
from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError, StateError
from ..ground.arrays import Array, frozen
from .model import RobotModel
from .state_builder import StateBuilder

# (u, du, signs, guess) -> results and codes
RunClosure = Callable[[Array, Array, Array, Array], ClosureResults]
# (u, du, check, near) -> state
Close = Callable[[Array, Array, bool, ClosedState | None], ClosedState]
MOST_HALVINGS = 8  # largest number of bisections of a motion with a change of charts


class Charts:
    """Changes of charts of one robot.

    Attributes:
        change_in_loops: whether a ball or free joint is passive, so that closure decides its chart.

    Args:
        model: names, tree and closure plan of the robot.
        run: the closure kernel.
        states: builds states from its results.
    """

    def __init__(self, model: RobotModel, run: RunClosure, states: StateBuilder) -> None:
        self._model = model
        self._run = run
        self._states = states
        self._blocks = len(model.plan.blocks)
        # active coordinates come first
        passive = [middle >= len(model.active) for _, middle, _ in model.tree.turns]
        self._passive = tuple(passive)
        self.change_in_loops = any(passive)

    def of(self, state: ClosedState) -> Array:
        """Chart of each ball and free joint, (c,) or (N, c), +1 or -1."""
        charts = state.signs[..., self._blocks :]
        return np.broadcast_to(charts, (*state.u.shape[:-1], charts.shape[-1]))

    def change(self, state: ClosedState, charts: Array) -> ClosedState:
        """The same state in given charts of ball and free joints, (c,) or (N, c)."""
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
        """Branch signs of s (n_s,) or (N, n_s) in charts (c,) or (N, c)."""
        if self.change_in_loops:
            # the sign of a leg on a ball joint may depend on the chart
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
        """The same state, with a change of chart for each ball and free joint beyond `leave`.

        Args:
            state: closed state, or a batch of N.
            leave: second angle of a joint, above which the chart changes [rad].
            active: whether charts of active joints change too, and with them u.
        """
        charts = self.of(state).copy()
        for k, (_, middle, _) in enumerate(self._model.tree.turns):
            far = np.abs(state.s[..., middle]) > leave
            if active or self._passive[k]:
                charts[..., k] *= np.where(far, -1.0, 1.0)
        return self.change(state, charts)

    def in_first(self, state: ClosedState) -> ClosedState:
        """The same state, with the active ball and free joints in the first chart."""
        charts = self.of(state)
        return self.change(state, np.where(self._passive, charts, FIRST))

    def close(
        self, close: Close, u: Array, du: Array, check: bool, near: ClosedState | None
    ) -> ClosedState:
        """Close a robot whose ball joints in loops may change their charts during the motion.

        Args:
            close: closes in the charts of the state `near`.
            u: active coordinates (n,) or (N, n) [rad, m].
            du: active rates of the same shape [rad/s, m/s].
            check: whether a state that does not close is an error.
            near: closed state from which the motion is followed; the reference if None.
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
            return close(u, du, True, near)  # raises its error
        return state

    def close_path(
        self, close: Close, u: Array, du: Array, near: ClosedState | None
    ) -> ClosedState:
        """Close along a motion (N, n), each row from the previous one.

        Raises:
            StateError: a row does not close; `index` is that of the first one.
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

    def require_no_passage(self, through_change_points: bool) -> None:
        """Raise InputError if a motion should pass change points of a robot whose charts change."""
        if through_change_points:
            raise InputError(
                "through_change_points: this robot has ball joints in loops, whose angles change"
                " their chart on the way; expected a robot without them"
            )

    def _by_halves(
        self, close: Close, u: Array, du: Array, start: ClosedState, depth: int = 0
    ) -> ClosedState:
        """Close at u (n,) from a start, with bisection of the motion if needed."""
        start = self.recentred(start, active=False)
        state = close(u, du, False, start)
        if state.status is ClosureStatus.OK or depth == MOST_HALVINGS:
            return state
        middle = self._by_halves(close, 0.5 * (start.u + u), np.zeros_like(u), start, depth + 1)
        if middle.status is not ClosureStatus.OK:
            return state
        return self._by_halves(close, u, du, middle, depth + 1)
