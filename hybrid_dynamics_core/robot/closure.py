"""Closure of a robot, from active or other independent coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .. import programs
from ..closed_state.assembly_modes import (
    AssemblyMode,
    AssemblyModes,
    matching_signs,
    signs_of_names,
)
from ..closed_state.closure_solver import ClosureResults, ClosureSolver
from ..closed_state.continuation import Start
from ..closed_state.diagnosis import error_for
from ..closed_state.mode_search import ModeSearch
from ..closed_state.passages.path import follow_through
from ..closed_state.state import ClosedState
from ..closed_state.turns import FreeTurns
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import finite_vectors
from ..ground.lazy import lazy
from .charts import Charts
from .closure_runs import QuickClosure, closure_runs
from .given import GivenMotion, close_rows
from .kernel_store import KernelStore
from .model import RobotModel
from .state_builder import StateBuilder

# results of `kernels.closed_inverse_dynamics` after tau
CLOSED_RESULTS = ("s", "ds", "R", "bias", "residuals", "distances")


class Closure:
    """Closes the loops of a robot.

    Attributes:
        model: names, tree and closure plan of the robot.
        kernels: store of the closure kernels.
        signs: branch sign of each block in the robot's assembly modes, then the chart of each ball
            or free joint at the reference; all are +1 or -1.
        start: all coordinates (n_s,) of the reference configuration [rad, m].
        turns: passive angles whose whole turns are not fixed by the loops.
        charts: charts of ball and free joints.
        solver: solver from the active coordinates.
        iterates: whether some loop has no closed form.
        is_followed: whether compiled calls come from the reference in one move, if they can.
    """

    def __init__(self, model: RobotModel, kernels: KernelStore) -> None:
        self.model = model
        self.kernels = kernels
        self.signs = frozen(model.plan.signs)
        self.start = model.reference_s
        self.turns = FreeTurns(model.program_model)
        self._states = StateBuilder(model)
        self.charts = Charts(model, self.run_closure, self._states)
        self.solver = self._solver_of("close", model.program_model)
        self.iterates = self.solver.iterates
        # charts of ball joints may change on the way
        self.is_followed = self.iterates and not self.charts.change_in_loops

    def close(
        self,
        u: ArrayLike,
        du: ArrayLike | None = None,
        check: bool = True,
        near: ClosedState | None = None,
        branch: Mapping[str, str] | None = None,
    ) -> ClosedState:
        """Close all loops at the active coordinates u and rates du.

        Without `near` the loops close on the robot's own assembly modes. Loops without a closed
        form are followed from the reference configuration. Passive angles are those nearest to the
        reference's. With `near` they are continuous from there, and `state.turns` counts their
        whole turns.

        Args:
            u: active coordinates (n,) or (N, n) [rad, m].
            du: active rates of the same shape [rad/s, m/s]; zero if None.
            check: whether a state that does not close is an error. If False, its row is NaN and
                its `status` says why.
            near: closed state from which the motion is followed, one or one for each row, in small
                steps on its assembly modes.
            branch: assembly modes by loop name, for loops that differ from the robot's modes; not
                together with `near`.

        Returns:
            The closed state, or a batch of N closed states.

        Raises:
            ClosureError: a loop cannot close at u.
            SingularityError: a loop is singular, or the motion from `near` would jump to another
                assembly mode.
            InputError: a shape is wrong, or a value is not finite.
        """
        if type(u) is not np.ndarray:
            u = finite_vectors("u", u, self.model.active)
        if branch is None and not self.charts.change_in_loops:
            state = self.quick.close(u, du, near)
            if state is not None:
                return state
        u = finite_vectors("u", u, self.model.active)
        rows = len(u) if u.ndim == 2 else -1
        du = self._rates(u, du, rows)
        if self.charts.change_in_loops and branch is None:
            self._start_at(near, rows)
            return self.charts.close(self._close, u, du, check, near)
        return self._close(u, du, check, near, branch)

    def _close(
        self,
        u: Array,
        du: Array,
        check: bool,
        near: ClosedState | None,
        branch: Mapping[str, str] | None = None,
    ) -> ClosedState:
        """Close at checked arguments."""
        start = self._start_at(near, len(u) if u.ndim == 2 else -1)
        signs = self._signs_for(near, branch)
        values, codes = self.solver.close(u, du, signs, start)
        state = self._states.build(u, du, signs, values, codes, check)
        return state if near is None else self._states.on_modes_of(near, state)

    def close_path(
        self,
        u: ArrayLike,
        du: ArrayLike | None = None,
        near: ClosedState | None = None,
        through_change_points: bool = False,
    ) -> ClosedState:
        """Close along a motion: each row is followed from the previous one.

        Args:
            u: active coordinates (N, n) along the motion [rad, m].
            du: active rates (N, n) [rad/s, m/s]; zero if None.
            near: closed state from which the first row is followed; the reference if None.
            through_change_points: whether the motion passes change points, without a jump of its
                rates. A path that touches a turning value of u passes that toggle to the other
                mode. `passages` of the result has these places; see `docs/dynamics.md`.

        Returns:
            A batch of N closed states.

        Raises:
            ClosureError: a row is out of reach.
            SingularityError: a row is at a toggle or change point, or only a jump to another
                assembly mode would reach it. The `index` of both errors is that of the first such
                row.
            InputError: a shape is wrong, or a value is not finite.
        """
        u = finite_vectors("u", u, self.model.active)
        if u.ndim == 1:
            raise InputError(f"u has shape {u.shape}; expected a motion (N, {len(u)})")
        du = self._rates(u, du, len(u))
        start = self._start_at(near, -1)
        signs = self._signs_for(near, None)
        if self.charts.change_in_loops:
            self.charts.require_no_passage(through_change_points)
            return self.charts.close_path(self._close, u, du, near)
        if through_change_points:
            path = follow_through(self.solver, self.model.program_model, u, signs, start)
            state = self._states.build_through(u, du, path, self.run_closure)
        else:
            values, codes = self.solver.path(u, du, signs, start)
            state = self._states.build(u, du, signs, values, codes)
        return state if near is None else self._states.on_modes_of(near, state)

    def follow_turns(self, state: ClosedState, before: ArrayLike) -> ClosedState:
        """Make passive angles continuous along states that were closed one by one.

        Args:
            state: closed state, or a batch of N along the motion.
            before: all coordinates (n_s,) before the first state [rad, m].

        Returns:
            The same configurations, with each angle within half a turn of the previous one.

        Raises:
            InputError: the state is of another robot, a shape is wrong, or a value is not finite.
        """
        self.check_state(state)
        before = finite_vectors("before", before, self.model.coordinates, -1)
        for _ in self.model.plan.blocks:  # a follower that turned moves the loops behind it
            s = self.turns.along(np.atleast_2d(state.s), before).reshape(state.s.shape)
            if np.array_equal(s, state.s, equal_nan=True):
                break
            values, codes = self.run_closure(state.u, state.du, state.signs, s)
            build = self._states.build
            followed = build(state.u, state.du, state.signs, values, codes, check=False)
            state = replace(followed, branch=state.branch)
        return state

    def close_given(
        self,
        values: Mapping[str, ArrayLike],
        rates: Mapping[str, ArrayLike] | None = None,
        accelerations: Mapping[str, ArrayLike] | None = None,
        near: ClosedState | None = None,
    ) -> ClosedState:
        """Close from any independent set of n coordinates.

        Args:
            values: given coordinates by name [rad, m], each a number, or (N,) for a batch.
            rates: their rates by name [rad/s, m/s]; zero where left out.
            accelerations: their accelerations by name [rad/s^2, m/s^2]; zero where left out.
            near: closed state from which the motion is followed, one or one for each row; the
                reference if None. Its configuration also decides whether the coordinates are
                independent, if they are not at the reference (as at a dead centre).

        Returns:
            The closed state, or a batch of N. Its `dds` are the accelerations of all coordinates.

        Raises:
            InputError: the coordinates do not determine the other ones, or a value is not finite.
            ClosureError: a loop cannot close there.
            SingularityError: a loop is singular there, or the motion leaves the assembly mode.
        """
        motion = GivenMotion.by_name(values, rates, accelerations, self.model.coordinates)
        self._start_at(near, motion.rows)
        if motion.rows < 0:
            return self._close_one_given(motion, near)
        return close_rows(self._close_one_given, motion, near)

    def _close_one_given(self, motion: GivenMotion, near: ClosedState | None) -> ClosedState:
        given = motion.names
        start = None if near is None else near.s
        charts = np.array(self.model.tree.charts, dtype=float)
        if near is not None:
            charts = self.charts.of(near)
        model = self.model.program_model_from(given, start, charts)
        if start is None:
            start = self.start
        signs = matching_signs(model, start, charts)
        solver = self._solver_of(f"close {given}", model)
        here, _ = solver.at(start, signs)
        closed, code = solver.close(motion.values, motion.rates, signs, Start(here["s"], here["R"]))
        if code != 0:
            raise error_for(programs.Outcome.decode(int(code)), model, motion.values, signs)
        inputs = {"u": motion.values, "du": motion.rates, "ddu": motion.accelerations}
        inputs |= {"branch": signs, "guess": closed["s"]}
        key = f"accelerations {given}"
        moving, _ = self.kernels.run(key, programs.ACCELERATIONS, inputs, model)
        modes = frozen(matching_signs(self.model.program_model, closed["s"], charts))
        state = self.state_at(closed["s"], closed["ds"], modes)
        return replace(state, dds=moving["dds"])

    def closed_state(self, u: Array, du: Array, results: Sequence[Array]) -> ClosedState:
        """Build a state from results of `kernels.closed_inverse_dynamics`, without a closure.

        Args:
            u: active coordinates (n,) or (N, n) [rad, m].
            du: active rates of the same shape [rad/s, m/s].
            results: results of the kernel after tau: s, ds, R, bias, residuals, distances.
        """
        values = dict(zip(CLOSED_RESULTS, results, strict=True))
        rows = u.shape[:-1]
        values["iterations"] = np.zeros((*rows, 1))
        codes = np.zeros(rows, dtype=np.int64)
        return self._states.build(u, du, self.signs, values, codes)

    def assembly_modes(self, u: ArrayLike) -> AssemblyModes:
        """The assembly modes at the active coordinates u.

        Loops without a closed form are searched from many starts. Modes next to a singular place
        are left out. `completeness` and `reason` of the result say how reliable the list is.

        The second solution of a universal joint is not listed, since it puts the leg in the same
        pose.

        Args:
            u: active coordinates (n,) [rad, m].

        Returns:
            A tuple of modes, each with its names by loop and its closed state.

        Raises:
            InputError: the shape is wrong, or a value is not finite.
        """
        u = finite_vectors("u", u, self.model.active, -1)
        du = np.zeros_like(u)
        modes = []
        search = ModeSearch(self.model.program_model, u, self.signs, self.start)
        for signs, s, names in search.solutions:
            values, codes = self.run_closure(u, du, signs, s)
            search.note(int(codes))
            if codes == 0:
                state = self._states.build(u, du, frozen(signs), values, codes)
                modes.append(AssemblyMode(names, replace(state, branch=names)))
        return AssemblyModes(modes, *search.verdict())

    def close_on(self, u: Array, du: Array, signs: Array) -> ClosedState:
        """Close on given signs: those of the blocks, then the charts of ball and free joints."""
        values, codes = self.solver.close(u, du, signs, None)
        return self._states.build(u, du, signs, values, codes)

    @lazy
    def reference_start(self) -> Start:
        """The reference configuration, and R there."""
        return self.solver.reference(self.signs)

    @lazy
    def quick(self) -> QuickClosure:
        """Closure where compiled code alone is enough; not if charts change in loops."""
        start = self.reference_start if self.iterates else self.start
        return QuickClosure(self.kernels, self._states, self.signs, start)

    def owns(self, state: ClosedState) -> bool:
        """Whether a state has this robot's coordinates and loops."""
        if state.s.shape[-1] != len(self.model.coordinates):
            return False
        return state.loops == self.model.loops

    def owns_one(self, state: object) -> bool:
        """Whether this is one state, not a batch, with this robot's coordinates and loops."""
        return type(state) is ClosedState and state.u.ndim == 1 and self.owns(state)

    def check_state(self, state: object) -> None:
        """Check a state that a caller gives.

        Raises:
            InputError: it is no closed state, or belongs to another robot.
        """
        if not isinstance(state, ClosedState):
            kind = type(state).__name__
            raise InputError(f"expected a ClosedState from robot.close(u, du), got {kind}")
        if not self.owns(state):
            raise InputError("the state belongs to another robot")

    def vector_like(self, state: ClosedState, name: str, value: ArrayLike) -> Array:
        """Check a vector over the active coordinates that belongs to a state.

        Args:
            state: closed state (n,) or batch (N, n).
            name: name of the vector in errors.
            value: (n,), or (N, n) for a batch.

        Raises:
            InputError: the state is of another robot, the shape is wrong, or a value is not finite.
        """
        self.check_state(state)
        rows = len(state.u) if state.u.ndim == 2 else -1
        return finite_vectors(name, value, self.model.active, rows)

    # -- arguments

    def _rates(self, u: Array, du: ArrayLike | None, rows: int) -> Array:
        if du is None:
            return np.zeros_like(u)
        return finite_vectors("du", du, self.model.active, rows)

    def _signs_for(self, near: ClosedState | None, branch: Mapping[str, str] | None) -> Array:
        """The branch signs to close on."""
        if near is not None and branch is not None:
            raise InputError("give near or branch, not both: the branch of near is kept")
        if near is not None:
            return near.signs
        if branch is not None:
            return frozen(signs_of_names(self.model.plan, self.signs, branch))
        return self.signs

    def _start_at(self, near: ClosedState | None, rows: int) -> Start | None:
        if near is None:
            return None
        self.check_state(near)
        if near.status if near.u.ndim == 1 else np.any(near.status):
            raise InputError(
                "near: the state is not closed (its status says why); come from one that is"
            )
        if near.s.ndim == 2 and near.s.shape[0] != rows:
            raise InputError(
                f"near holds {near.s.shape[0]} states; expected one, or one a row of u"
            )
        return Start(near.s, near.R)

    # -- solvers

    def _solver_of(self, key: str, model: programs.Model) -> ClosureSolver:
        return ClosureSolver(model, closure_runs(self.kernels, key, model))

    def run_closure(self, u: Array, du: Array, signs: Array, guess: Array) -> ClosureResults:
        """Results and status codes of the closure kernel."""
        inputs = {"u": u, "du": du, "branch": signs, "guess": guess}
        return self.kernels.run("close", programs.CLOSE, inputs)

    # -- results

    def state_at(self, s: Array, ds: Array, signs: Array) -> ClosedState:
        """The closed state of all coordinates s (n_s,) and rates on given branch signs."""
        u, du = s[: len(self.model.active)].copy(), ds[: len(self.model.active)].copy()
        values, codes = self.run_closure(u, du, signs, s)
        return self._states.build(u, du, signs, values, codes)
