"""Closure on a given assembly mode.

A closure in closed form is evaluated directly. Any other is followed by continuation from a closed
configuration.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..closure.closed_motion import ClosedMotion
from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import GOOD, JUMP, any_failed
from ..programs import Model
from .continuation import Continuation, Rows, Start, continue_to
from .turns import FreeTurns

Values = dict[str, Array]
# results by name, and the status codes () or (N,)
ClosureResults = tuple[Values, Codes]
# (u, du, branch signs, guess) -> results
RunClose = Callable[[Array, Array, Array, Array], ClosureResults]
# (u, du, branch signs, start) -> results
RunStep = Callable[[Array, Array, Array, Start], ClosureResults]
# (u (N, n), branch signs, start of the first row) -> closed configurations of rows, status codes
RunPath = Callable[[Array, Array, Start], tuple[Start, Codes]]


def reference_start(model: Model, signs: Array) -> Start:
    """The reference configuration of a model, on branch signs (blocks,).

    Its R is computed on floats, without compiled code.
    """
    plan = model.plan
    u = [plan.reference.q[k] for k in plan.given]
    motion = ClosedMotion(model.tree, plan, u, signs.tolist(), plan.reference.q)
    s = np.array(motion.configuration.q, dtype=float)
    return Start(s, np.array(motion.velocity_map(), dtype=float).reshape(len(s), len(u)))


class ClosureRuns(NamedTuple):
    """The closure kernels of a model.

    Attributes:
        at: function that closes from a guess.
        step: function that closes from a start, in one move. The status `JUMP` means that the move
            is not smooth.
        path: function that closes rows, each started from the previous one.
    """

    at: RunClose
    step: RunStep
    path: RunPath


class ClosureSolver:
    """Solver of the loops of one model.

    Args:
        model: tree and closure plan.
        runs: its closure kernels.

    Attributes:
        given: indices of the given coordinates.
        iterates: whether some loop has no closed form.
    """

    def __init__(self, model: Model, runs: ClosureRuns) -> None:
        self.given = list(model.plan.given)
        self.iterates = any(block.iterates for block in model.plan.blocks)
        self._reference = np.array(model.plan.reference.q, dtype=float)
        self._turns = FreeTurns(model)
        self._model = model
        self._run = runs.at
        self._runs = runs
        self._references: dict[bytes, Start] = {}

    def close(
        self,
        u: Array,
        du: Array,
        signs: Array,
        start: Start | None,
    ) -> ClosureResults:
        """Close at u: directly, or followed from a start.

        Args:
            u: given coordinates (n,) or (N, n) [rad, m].
            du: given rates of the same shape [rad/s, m/s].
            signs: branch signs (blocks,), or (N, blocks).
            start: the configuration to follow the motion from. If None, closed forms are evaluated
                directly, and other closures are followed from the reference. Passive angles are
                then those nearest to the reference's.

        Returns:
            Results by name, and the status codes () or (N,).
        """
        if start is not None:
            return self._from_start(u, du, signs, start)
        if not self.iterates:
            return self._run(u, du, signs, self._reference)
        # a short move from the reference keeps its turns
        values, codes = self._runs.step(u, du, signs, self.reference(signs))
        if not any_failed(codes):
            return values, codes
        if u.ndim == 1:
            return self._from_reference(u, du, signs)
        rows = np.flatnonzero(codes)
        replacement = self._from_reference(u[rows], du[rows], _of_rows(signs, rows))
        return _with_rows((values, codes), rows, replacement)

    def _from_reference(self, u: Array, du: Array, signs: Array) -> ClosureResults:
        """Close at u, however far from the reference."""
        # at most half a turn from the reference: whole turns give the same configuration
        within_a_turn = self._turns.nearest_given(u, self._reference[self.given])
        values, codes = self._from_start(within_a_turn, du, signs, self.reference(signs))
        nearest = self._turns.nearest(values["s"], self._reference)
        nearest[..., self.given] = u
        if np.array_equal(nearest, values["s"], equal_nan=True):
            return values, codes
        turned, turned_codes = self._run(u, du, signs, nearest)
        return turned, np.where(codes == GOOD, turned_codes, codes)

    def _from_start(self, u: Array, du: Array, signs: Array, start: Start) -> ClosureResults:
        """Close at u, followed from a start."""
        values, codes = self._runs.step(u, du, signs, start)
        must_follow = self._must_follow(codes)
        if not must_follow.any():
            return values, codes
        if u.ndim == 1:
            return self._follow(u, du, signs, start)
        rows = np.flatnonzero(must_follow)
        starts = start.rows(rows)
        replacement = self._follow(u[rows], du[rows], _of_rows(signs, rows), starts)
        return _with_rows((values, codes), rows, replacement)

    def path(
        self,
        u: Array,
        du: Array,
        signs: Array,
        start: Start | None,
    ) -> ClosureResults:
        """Close along a motion, each row followed from the previous one.

        All rows after one that fails get its code.

        Args:
            u: given coordinates (N, n) [rad, m].
            du: given rates (N, n) [rad/s, m/s].
            signs: branch signs (blocks,).
            start: the configuration before the first row; the reference if None.

        Returns:
            Results by name, and the status codes (N,).
        """
        s = np.empty((len(u), len(self._reference)))
        failed = np.zeros(len(u), dtype=np.int64)
        previous = self._reference
        done = 0
        while done < len(u):
            if start is not None:
                steps, codes = self._runs.path(u[done:], signs, start)
                good = _first_failure(codes)
                s[done : done + good] = steps.s[:good]
                done += good
                if good:
                    previous = s[done - 1]
                    start = Start(previous, steps.velocity_map[good - 1])
            if done == len(u):
                break
            # the first row, or one that is not near the previous one
            values, code = self.close(u[done], np.zeros_like(u[done]), signs, start)
            if code != GOOD:
                s[done:] = previous
                failed[done:] = code
                break
            previous = values["s"]
            s[done] = previous
            start = Start(previous, values["R"])
            done += 1
        values, codes = self._run(u, du, signs, s)
        return values, np.where(failed != GOOD, failed, codes)

    def share_reached(self, u: Array, signs: Array, start: Start) -> float:
        """Share of the straight motion to u (n,) that continuation reaches, in [0, 1]."""
        return float(self._continued(u, signs, start).progress[0])

    def from_guess(self, u: Array, signs: Array, guess: Array) -> ClosureResults:
        """Close at u (n,) or (N, n), at rest, near a guess of all coordinates."""
        return self._run(u, np.zeros_like(u), signs, guess)

    def at(self, s: Array, signs: Array) -> ClosureResults:
        """The closure at a closed configuration s (n_s,), at rest."""
        u = s[self.given]
        return self._run(u, np.zeros_like(u), signs, s)

    def reference(self, signs: Array) -> Start:
        """The reference configuration."""
        if signs.ndim == 2:
            values, _ = self.at(self._reference, signs)
            return Start(values["s"], values["R"])
        key = signs.tobytes()
        start = self._references.get(key)
        if start is None:
            start = self._references[key] = reference_start(self._model, signs)
        return start

    def _must_follow(self, codes: Codes) -> NDArray[np.bool_]:
        """Mask (N,) of the states that need continuation."""
        if self.iterates:
            # an iteration may fail because its guess was too far off
            return np.not_equal(codes, GOOD)
        # a closed form that fails has no solution
        return np.equal(codes, JUMP)

    def _follow(self, u: Array, du: Array, signs: Array, start: Start) -> ClosureResults:
        """Close at u (n,) or (N, n) by continuation from a start."""
        path = self._continued(u, signs, start)
        values, at_end = self._run(u, du, signs, path.s.reshape(*u.shape[:-1], -1))
        codes = _code_after(path.codes, at_end)
        return values, codes.reshape(np.shape(at_end))

    def _continued(self, u: Array, signs: Array, start: Start) -> Continuation:
        """Follow the motion from a start to u (n,) or (N, n)."""
        ends = np.atleast_2d(u)
        starts = np.broadcast_to(start.s, (len(ends), len(self._reference)))

        def close(u: Array, guess: Array, rows: Rows) -> ClosureResults:
            return self._run(u, np.zeros_like(u), _of_rows(signs, rows), guess)

        def step(u: Array, start: Start, rows: Rows) -> ClosureResults:
            return self._runs.step(u, np.zeros_like(u), _of_rows(signs, rows), start)

        return continue_to(close, step, starts, starts[:, self.given], ends)


def _with_rows(direct: ClosureResults, rows: Rows, replacement: ClosureResults) -> ClosureResults:
    """Results with those of some rows replaced."""
    values, codes = direct
    values_of_rows, codes_of_rows = replacement
    for name, value in values.items():
        value[rows] = values_of_rows[name]
    codes = codes.copy()
    codes[rows] = codes_of_rows
    return values, codes


def _first_failure(codes: Codes) -> int:
    """Index of the first bad code; their number if all are good."""
    failures = np.flatnonzero(codes)
    if len(failures):
        return int(failures[0])
    return len(codes)


def _code_after(on_the_way: Codes, at_end: Codes) -> Codes:
    """Status of rows that were followed.

    It is the code at the end. An end that closes, but was not reached, gets the code of a jump.
    """
    lost = np.where(at_end == GOOD, JUMP, at_end)
    return np.atleast_1d(np.where(on_the_way == GOOD, at_end, lost))


def _of_rows(signs: Array, rows: Rows) -> Array:
    """Branch signs of some rows; signs (blocks,) hold for every row."""
    if signs.ndim == 1:
        return signs
    return signs[rows]
