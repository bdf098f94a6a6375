"""Closing on the right assembly mode.

A closure in closed form is evaluated directly. Any other is followed by continuation from a closed
configuration.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import GOOD, JUMP
from ..programs import Model
from .continuation import Continuation, Mask, Rows, continue_to, is_continuous
from .turns import FreeTurns

Values = dict[str, Array]
# results by name, and the status codes () or (N,)
ClosureResults = tuple[Values, Codes]
# (u, du, branch signs, guess) -> results
RunClose = Callable[[Array, Array, Array, Array], ClosureResults]


class Start(NamedTuple):
    """A closed configuration to come from.

    Attributes:
        s: all coordinates (n_s,) or (N, n_s) [rad, m].
        velocity_map: R there, (n_s, n) or (N, n_s, n).
    """

    s: Array
    velocity_map: Array


class ClosureSolver:
    """Closes one model.

    Args:
        model: tree and closure plan.
        run: the closure kernel of the model.

    Attributes:
        given: indices of the given coordinates.
        iterates: whether some loop has no closed form.
    """

    def __init__(self, model: Model, run: RunClose) -> None:
        self.given = list(model.plan.given)
        self.iterates = any(block.iterates for block in model.plan.blocks)
        self._reference = np.array(model.plan.reference.q, dtype=float)
        indices = range(len(self._reference))
        passive = [k not in self.given for k in indices]
        self._passive = np.array(passive)
        self._turns = FreeTurns(model)
        self._run = run

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
            return self._close_from(u, du, signs, start)
        if not self.iterates:
            return self._run(u, du, signs, self._reference)
        # at most half a turn from the reference: whole turns give the same configuration
        within_a_turn = self._turns.nearest_given(u, self._reference[self.given])
        values, codes = self._close_from(within_a_turn, du, signs, self.reference(signs))
        nearest = self._turns.nearest(values["s"], self._reference)
        nearest[..., self.given] = u
        if np.array_equal(nearest, values["s"], equal_nan=True):
            return values, codes
        turned, turned_codes = self._run(u, du, signs, nearest)
        return turned, np.where(codes == GOOD, turned_codes, codes)

    def _close_from(self, u: Array, du: Array, signs: Array, start: Start) -> ClosureResults:
        """Close at u, followed from a start."""
        move = u - start.s[..., self.given]
        predicted = _mapped(start.velocity_map, move)
        values, codes = self._run(u, du, signs, start.s + predicted)
        moved = values["s"] - start.s
        hindsight = _mapped(values["R"], move)
        smooth = is_continuous(moved, predicted, hindsight, self._passive)
        must_follow = self._must_follow(smooth, codes)
        if not np.any(must_follow):
            return values, codes
        if u.ndim == 1:
            return self._follow_one(u, du, signs, start)
        return self._follow_rows(u, du, signs, start, must_follow, (values, codes))

    def path(
        self,
        u: Array,
        du: Array,
        signs: Array,
        start: Start | None,
    ) -> ClosureResults:
        """Close along a motion, each row followed from the one before.

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
        for k, row in enumerate(u):
            values, code = self.close(row, np.zeros_like(row), signs, start)
            if code != GOOD:
                s[k:] = previous
                failed[k:] = code
                break
            previous = values["s"]
            s[k] = previous
            start = Start(previous, values["R"])
        values, codes = self._run(u, du, signs, s)
        return values, np.where(failed != GOOD, failed, codes)

    def at(self, s: Array, signs: Array) -> ClosureResults:
        """The closure at a closed configuration s (n_s,), at rest."""
        u = s[self.given]
        return self._run(u, np.zeros_like(u), signs, s)

    def reference(self, signs: Array) -> Start:
        """The reference configuration."""
        values, _ = self.at(self._reference, signs)
        return Start(values["s"], values["R"])

    def _must_follow(self, smooth: Mask, codes: Codes) -> Mask:
        """Mask (N,) of the states that need continuation."""
        failed: Mask = codes != GOOD
        if self.iterates:
            # an iteration may fail because its guess was too far off
            rows: Mask = ~smooth | failed
        else:
            # a closed form that fails has no solution
            rows = ~smooth & ~failed
        return rows

    def _follow_one(
        self,
        u: Array,
        du: Array,
        signs: Array,
        start: Start,
    ) -> ClosureResults:
        path = self._follow(start.s[None], u[None], signs)
        values, code = self._run(u, du, signs, path.s[0])
        return values, _code_after(path.codes, code)[0]

    def _follow_rows(
        self,
        u: Array,
        du: Array,
        signs: Array,
        start: Start,
        must_follow: Mask,
        direct: ClosureResults,
    ) -> ClosureResults:
        """The results of one evaluation, with some rows replaced by continuation."""
        values, codes = direct
        rows = np.flatnonzero(must_follow)
        shape = (len(u), len(self._reference))
        starts = np.broadcast_to(start.s, shape)
        path = self._follow(starts[rows], u[rows], _of_rows(signs, rows))
        followed, codes_at_end = self._run(u[rows], du[rows], _of_rows(signs, rows), path.s)
        for name, value in values.items():
            value[rows] = followed[name]
        codes = codes.copy()
        codes[rows] = _code_after(path.codes, codes_at_end)
        return values, codes

    def _follow(self, start: Array, ends: Array, signs: Array) -> Continuation:
        def close(u: Array, guess: Array, rows: Rows) -> ClosureResults:
            return self._run(u, np.zeros_like(u), _of_rows(signs, rows), guess)

        return continue_to(close, start, start[:, self.given], ends, self._passive)


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


def _mapped(velocity_map: Array, move: Array) -> Array:
    """R times a move, for one state or for each row."""
    moved: Array = np.einsum("...ij,...j->...i", velocity_map, move)
    return moved
