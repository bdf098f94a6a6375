"""Singular places of a robot: the crossing ahead of a state, and states beside a place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...closed_state.assembly_modes import matching_signs
from ...closed_state.continuation import Start
from ...closed_state.passages.crossing import Crossing, Line, find_crossing
from ...closed_state.passages.record import Passage
from ...closed_state.passages.recorded import Passed, recorded
from ...closed_state.state import ClosedState, ClosureStatus
from ...closure.constraints.equations import LoopEquations
from ...ground.arrays import Array, frozen
from ...programs.model import SINGULAR
from ..closure import Closure
from ..model import RobotModel
from ..state_builder import StateBuilder


class SingularPlaces:
    """Change points and toggles of one robot.

    Args:
        model: the robot.
        closure: its closure.
    """

    def __init__(
        self,
        model: RobotModel,
        closure: Closure,
    ) -> None:
        self._model = model
        self._closure = closure
        self._states = StateBuilder(model)

    @property
    def loop_equations(self) -> tuple[LoopEquations, ...]:
        """The equations of all loops."""
        return self._model.plan.loops

    @property
    def block_names(self) -> list[str]:
        """The loop of each block of the closure plan."""
        return [block.name for block in self._model.plan.blocks]

    def crossing_ahead(
        self,
        state: ClosedState,
        way: Array,
    ) -> Crossing | None:
        """The first singular place on a straight motion, and the smooth way through it.

        Args:
            state: one closed state.
            way: change (n,) of the active coordinates [rad, m].

        Returns:
            The crossing; None if there is no such place, or no smooth way.
        """
        start = Start(state.s, state.R)
        line = Line(state.u, way)
        solver = self._closure.solver
        return find_crossing(solver, self._model.program_model, start, state.signs, line)

    def states_of(self, crossing: Crossing) -> list[ClosedState]:
        """The closed states at rest at the places beside a crossing, in order.

        Raises:
            SingularityError: one of them is singular.
        """
        states: list[ClosedState] = []
        for s, signs in zip(crossing.places.s, crossing.places.signs, strict=True):
            states.append(self._closure.state_at(s, np.zeros_like(s), frozen(signs)))
        return states

    def recorded(self, passed: Passed) -> Passage:
        """The record of a passage."""
        return recorded(self._model.program_model, passed)

    def signs_at(self, s: Array) -> Array:
        """Branch signs (blocks,) of a closed configuration s (n_s,)."""
        charts = self._closure.signs[len(self._model.plan.blocks) :]
        return frozen(matching_signs(self._model.program_model, s, charts))

    def state_of(
        self,
        s: Array,
        ds: Array,
    ) -> ClosedState:
        """The closed state of all coordinates s (n_s,) and rates ds (n_s,).

        Raises:
            SingularityError: a loop is singular there.
        """
        return self._closure.state_at(s, ds, self.signs_at(s))

    def states_beside(
        self,
        closed: ClosedState,
        signs: Array,
    ) -> ClosedState:
        """States at and beside singular places, whose s, ds, R and bias are known.

        Args:
            closed: a batch of N closed states with these fields, of this robot's shapes.
            signs: branch signs (N, blocks).

        Returns:
            The batch, with distances to singularities. Where rates have no finite answer by R, its
            status is `SINGULAR`, and R and bias are NaN.
        """
        values, codes = self._closure.run_closure(closed.u, closed.du, signs, closed.s)
        distances = np.where(codes[:, None] == 0, values["distances"], 0.0)
        values |= {"s": closed.s.copy(), "ds": closed.ds.copy()}
        values |= {"R": closed.R.copy(), "bias": closed.bias.copy()}
        values["distances"] = distances
        values["iterations"] = np.zeros((len(closed.u), 1))
        values["residuals"] = np.array(closed.residual)[:, None]
        singular = distances.min(axis=1, initial=1.0) < SINGULAR
        values["R"][singular] = np.nan
        values["bias"][singular] = np.nan
        state = self._states.build(closed.u, closed.du, signs, values, np.zeros_like(codes))
        status = np.where(singular, ClosureStatus.SINGULAR, ClosureStatus.OK)
        return replace(state, status=status)
