"""Following a configuration along a motion: predict with R, correct with the closure, refuse a jump.

A mechanism on its branch moves smoothly, so the move of a step is what R foretells at its start and
what R tells in hindsight at its end, the nearer the shorter the step. Where it is not, the step is
shortened; where no step is short enough, the motion meets a singular place (a toggle, a change
point) or would have to jump to another assembly mode, and is refused. Both ends are asked, because
at a change point R jumps where the coordinates do not: a step that ends just beyond it is foretold
well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..kernels.status import JUMP

Values = Mapping[str, Array]
Close = Callable[
    [Array, Array], tuple[Values, NDArray[np.int64]]
]  # (u, guess) -> values with s and R, status codes

Mask = NDArray[np.bool_]
CORRECTION = 0.25  # largest part of the predicted step that the correction may be
SLACK = 1e-9  # [rad or m] rounding that a correction may always have
LARGEST = 0.5  # [rad or m] longest predicted step of a passive coordinate
SHORTEST = 1e-7  # of the way: a shorter step means that there is no smooth way on
MAX_ROUNDS = 400


@dataclass(frozen=True)
class Tracked:
    """Where each row ended: all coordinates (N, n_s), status code (N,), and how far it came (N,) in [0, 1]."""

    s: Array
    codes: NDArray[np.int64]
    progress: Array


def track(
    close: Close, start_s: Array, start_u: Array, end_u: Array, turns: Mask, passive: Mask
) -> Tracked:
    """Follow each row (N, ...) along the straight line from start_u to end_u, beginning at the closed s there.

    `turns`, `passive`: which coordinates are angles, and which are not given (n_s,).
    """
    n = len(end_u)
    s, done, length = start_s.copy(), np.zeros(n), np.ones(n)
    values, codes = close(start_u, s)
    velocity_map = values["R"].copy()
    codes = codes.copy()
    working = codes == 0
    for _ in range(MAX_ROUNDS):
        rows = np.flatnonzero(working & (done < 1.0))
        if not len(rows):
            break
        ahead = np.minimum(1.0, done[rows] + length[rows])
        move = (ahead - done[rows])[:, None] * (end_u[rows] - start_u[rows])
        predicted = np.einsum("nij,nj->ni", velocity_map[rows], move)
        goal = start_u[rows] + ahead[:, None] * (end_u[rows] - start_u[rows])
        values, tried = close(goal, s[rows] + predicted)
        hindsight = np.einsum("nij,nj->ni", values["R"], move)
        good = (tried == 0) & smooth(values["s"] - s[rows], predicted, hindsight, turns, passive)
        kept = rows[good]
        s[kept], velocity_map[kept], done[kept] = values["s"][good], values["R"][good], ahead[good]
        length[kept] *= 2.0
        lost = rows[~good]
        length[lost] *= 0.5
        codes[rows] = np.where(good, 0, np.where(tried == 0, JUMP, tried))
        working[lost] = length[lost] >= SHORTEST
    codes = np.where((codes == 0) & (done < 1.0), JUMP, codes)
    return Tracked(s, codes, done)


def smooth(moved: Array, predicted: Array, hindsight: Array, turns: Mask, passive: Mask) -> Mask:
    """Whether the move (..., n_s) is the one that R foretells and tells in hindsight, but for a small correction.

    Whole turns of an angle are no move.
    """
    size = np.abs(predicted).max(
        axis=-1, initial=0.0, where=passive
    )  # given coordinates may go any way
    with np.errstate(invalid="ignore"):
        whole = np.where(turns, 2.0 * np.pi * np.round((moved - predicted) / (2.0 * np.pi)), 0.0)
        correction = np.maximum(
            np.abs(moved - whole - predicted), np.abs(moved - whole - hindsight)
        ).max(axis=-1, initial=0.0, where=passive)
        near: Mask = (correction <= CORRECTION * size + SLACK) & (size <= LARGEST)
    return near
