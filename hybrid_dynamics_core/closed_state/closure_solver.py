"""Closing on the right branch: at once where the closure has a closed form, followed from a known state where not."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import JUMP
from ..programs import Model
from .continuation import Tracked, smooth, track

Values = dict[str, Array]
RunClose = Callable[
    [Array, Array, Array, Array], tuple[Values, Codes]
]  # (u, du, branch signs, guess)


class Start(NamedTuple):
    """A closed configuration s (n_s,) or (N, n_s) to come from, and R there."""

    s: Array
    velocity_map: Array


class Closer:
    """Closes one model; `run` is its closure kernel.

    Rates of the iteration's trial states are zero.
    """

    def __init__(self, model: Model, run: RunClose) -> None:
        self.given = list(model.plan.given)
        self.iterates = any(step.iterates for step in model.plan.blocks)
        self._reference = np.array(model.plan.reference.q, dtype=float)
        self._turns = np.array([model.tree.is_revolute(k) for k in range(len(self._reference))])
        self._passive = np.array([k not in self.given for k in range(len(self._reference))])
        self._run = run

    def close(self, u: Array, du: Array, signs: Array, start: Start | None) -> tuple[Values, Codes]:
        """At u (n,) or (N, n): directly without `start` where no step iterates; otherwise followed from there."""
        if start is None and not self.iterates:
            return self._run(u, du, signs, self._reference)
        start = start or self.reference(signs)
        move = u - start.s[..., self.given]
        predicted = _mapped(start.velocity_map, move)
        values, codes = self._run(u, du, signs, start.s + predicted)
        rough = ~smooth(
            values["s"] - start.s, predicted, _mapped(values["R"], move), self._turns, self._passive
        )
        # a closed form that fails has no answer; an iteration may only have been started too far
        # off
        rough = rough | (codes != 0) if self.iterates else rough & (codes == 0)
        if not np.any(rough):
            return values, codes
        if u.ndim == 1:
            found = self._follow(start.s[None], u[None], signs)
            values, codes = self._run(u, du, signs, found.s[0])
            return values, _code(found.codes, codes)[0]
        rows = np.flatnonzero(rough)
        found = self._follow(
            np.broadcast_to(start.s, (len(u), len(self._reference)))[rows], u[rows], signs
        )
        again, at_end = self._run(u[rows], du[rows], signs, found.s)
        for key, value in values.items():
            value[rows] = again[key]
        codes = codes.copy()
        codes[rows] = _code(found.codes, at_end)
        return values, codes

    def path(self, u: Array, du: Array, signs: Array, start: Start | None) -> tuple[Values, Codes]:
        """Along u (N, n), each row followed from the one before; after a row that fails all codes are that row's."""
        s = np.empty((len(u), len(self._reference)))
        failed = np.zeros(len(u), dtype=np.int64)
        for k, row in enumerate(u):
            values, code = self.close(row, np.zeros_like(row), signs, start)
            if code != 0:
                s[k:], failed[k:] = s[k - 1] if k else self._reference, code
                break
            s[k], start = values["s"], Start(values["s"], values["R"])
        values, codes = self._run(u, du, signs, s)
        return values, np.where(failed != 0, failed, codes)

    def at(self, s: Array, signs: Array) -> tuple[Values, Codes]:
        """The closure at a closed configuration s (n_s,)."""
        u = s[self.given]
        return self._run(u, np.zeros_like(u), signs, s)

    def reference(self, signs: Array) -> Start:
        """The reference configuration."""
        values, _ = self.at(self._reference, signs)
        return Start(values["s"], values["R"])

    def _follow(self, start: Array, ends: Array, signs: Array) -> Tracked:
        def close(at: Array, guess: Array) -> tuple[Values, Codes]:
            return self._run(at, np.zeros_like(at), signs, guess)

        return track(close, start, start[:, self.given], ends, self._turns, self._passive)


def _code(on_the_way: Codes, at_end: Codes) -> Codes:
    """Status of rows that were followed: why the end does not close or, where it does, that the way was lost."""
    lost = np.where(at_end == 0, JUMP, at_end)
    return np.atleast_1d(np.where(on_the_way == 0, at_end, lost))


def _mapped(velocity_map: Array, move: Array) -> Array:
    """R du, one state or many."""
    moved: Array = np.einsum("...ij,...j->...i", velocity_map, move)
    return moved
