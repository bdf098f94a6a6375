"""Following a configuration along a motion: predict with R, correct with the closure.

On its assembly mode a mechanism moves smoothly. The move of a step is what R predicts at its start.
It is also what R at its end gives in hindsight. The shorter the step, the better both agree.

A step that does not agree is shortened. Where no step is short enough, the motion meets a singular
place (a toggle, a change point), or would have to jump to another assembly mode.

Both ends are compared, because R jumps at a change point where the coordinates do not. A step that
ends just beyond a change point is predicted well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import GOOD, JUMP

Values = Mapping[str, Array]
Rows = NDArray[np.intp]
# (u, guess, indices of these rows in the batch) -> results with s and R, status codes
Close = Callable[[Array, Array, Rows], tuple[Values, Codes]]
Mask = NDArray[np.bool_]

CORRECTION = 0.25  # largest part of the predicted step that the correction may be
SLACK = 1e-9  # [rad or m] rounding that a correction may always have
LARGEST = 0.5  # [rad or m] longest predicted step of a passive coordinate
SHORTEST = 1e-7  # of the way: a shorter step means that there is no smooth way on
# A longer way needs more steps, accepted or rejected: so many are tried at most.
BASE_ROUNDS = 400
ROUNDS_PER_LENGTH = 100  # [1/rad or 1/m] of the way of the given coordinates
MAX_EXTRA_ROUNDS = 1e6


@dataclass(frozen=True)
class Continuation:
    """Where each row ended.

    Attributes:
        s: all coordinates (N, n_s) [rad, m].
        codes: status codes (N,).
        progress: share of the way (N,) that each row came, in [0, 1].
    """

    s: Array
    codes: Codes
    progress: Array


def continue_to(
    close: Close,
    start_s: Array,
    start_u: Array,
    end_u: Array,
    passive: Mask,
) -> Continuation:
    """Follow each row along the straight line between given coordinates.

    Args:
        close: closes the loops at given coordinates, from a guess.
        start_s: closed configurations (N, n_s) to come from [rad, m].
        start_u: given coordinates (N, n) there [rad, m].
        end_u: given coordinates (N, n) to go to [rad, m].
        passive: which coordinates are not given (n_s,).
    """
    s = start_s.copy()
    progress = np.zeros(len(end_u))
    length = np.ones(len(end_u))
    values, codes = close(start_u, s, np.arange(len(end_u)))
    velocity_map = values["R"].copy()
    codes = codes.copy()
    working = codes == GOOD
    longest = float(np.abs(end_u - start_u).max(initial=0.0))
    extra_rounds = int(min(ROUNDS_PER_LENGTH * longest, MAX_EXTRA_ROUNDS))
    for _ in range(BASE_ROUNDS + extra_rounds):
        rows = np.flatnonzero(working & (progress < 1.0))
        if not len(rows):
            break
        way = end_u[rows] - start_u[rows]
        ahead = np.minimum(1.0, progress[rows] + length[rows])
        move = (ahead - progress[rows])[:, None] * way
        predicted = np.einsum("nij,nj->ni", velocity_map[rows], move)
        goal = start_u[rows] + ahead[:, None] * way
        values, trial_codes = close(goal, s[rows] + predicted, rows)
        hindsight = np.einsum("nij,nj->ni", values["R"], move)
        moved = values["s"] - s[rows]
        smooth = is_continuous(moved, predicted, hindsight, passive)
        accepted = (trial_codes == GOOD) & smooth
        forward = rows[accepted]
        s[forward] = values["s"][accepted]
        velocity_map[forward] = values["R"][accepted]
        progress[forward] = ahead[accepted]
        length[forward] *= 2.0
        rejected = rows[~accepted]
        length[rejected] *= 0.5
        reason = np.where(trial_codes == GOOD, JUMP, trial_codes)
        codes[rows] = np.where(accepted, GOOD, reason)
        working[rejected] = length[rejected] >= SHORTEST
    codes = np.where((codes == GOOD) & (progress < 1.0), JUMP, codes)
    return Continuation(s, codes, progress)


def is_continuous(moved: Array, predicted: Array, hindsight: Array, passive: Mask) -> Mask:
    """Whether a move is the one that R gives at both ends, but for a small correction.

    Args:
        moved: move (..., n_s) of all coordinates [rad, m].
        predicted: the move by R at the start.
        hindsight: the move by R at the end.
        passive: which coordinates are not given (n_s,). Given coordinates may go any way.
    """
    size = np.abs(predicted).max(axis=-1, initial=0.0, where=passive)
    with np.errstate(invalid="ignore"):
        error = np.abs(moved - predicted)
        error_in_hindsight = np.abs(moved - hindsight)
        errors = np.maximum(error, error_in_hindsight)
        correction = errors.max(axis=-1, initial=0.0, where=passive)
        bound = CORRECTION * size + SLACK
        small: Mask = (correction <= bound) & (size <= LARGEST)
    return small
