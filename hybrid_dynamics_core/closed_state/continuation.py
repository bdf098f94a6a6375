"""Following a configuration along a motion: predict with R, correct with the closure.

On one assembly mode a mechanism moves smoothly. The change of s in a step is predicted with R at
its start, and again with R at its end. The shorter the step, the better both predictions agree with
it.

A step that disagrees is shortened. If no step is short enough, the motion meets a singularity (a
toggle or change point), or would jump to another assembly mode.

Both ends are needed: at a change point R jumps, but s does not. So a step that ends just beyond one
agrees with the prediction at its start.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import GOOD, JUMP

Values = Mapping[str, Array]
Rows = NDArray[np.intp]

SHORTEST = 1e-7  # share of the motion; if a step must be shorter, there is no continuous motion
# A longer motion needs more steps. This is the largest number of them, rejected ones included.
BASE_ROUNDS = 400
ROUNDS_PER_LENGTH = 100  # [1/rad or 1/m] per length of the path of the given coordinates
MAX_EXTRA_ROUNDS = 1e6


class Start(NamedTuple):
    """A closed configuration to come from.

    Attributes:
        s: all coordinates (n_s,) or (N, n_s) [rad, m].
        velocity_map: R there, (n_s, n) or (N, n_s, n).
    """

    s: Array
    velocity_map: Array

    @property
    def flat(self) -> tuple[Array, Array]:
        """All coordinates (..., n_s), and R row by row (..., n_s * n), as programs take them."""
        start_map = self.velocity_map.reshape(*self.s.shape[:-1], -1)
        return self.s, start_map

    def rows(self, rows: Rows) -> Start:
        """The starts of some rows; the same start if it is common to all rows."""
        if self.s.ndim == 1:
            return self
        return Start(self.s[rows], self.velocity_map[rows])


# (u, guess, indices of these rows in the batch) -> results with s and R, status codes
Close = Callable[[Array, Array, Rows], tuple[Values, Codes]]
# (u, start, indices of these rows) -> the same; the code is JUMP if R does not agree at both ends
Step = Callable[[Array, Start, Rows], tuple[Values, Codes]]


@dataclass(frozen=True)
class Continuation:
    """The result of following each row.

    Attributes:
        s: all coordinates (N, n_s) [rad, m].
        codes: status codes (N,).
        progress: share of the motion (N,) that each row completed, in [0, 1].
    """

    s: Array
    codes: Codes
    progress: Array


def continue_to(
    close: Close,
    step: Step,
    start_s: Array,
    start_u: Array,
    end_u: Array,
) -> Continuation:
    """Follow each row along the straight line between given coordinates.

    Args:
        close: closes the loops at given coordinates, from a guess.
        step: closes the loops at given coordinates, in one step from a start.
        start_s: closed configurations (N, n_s) to come from [rad, m].
        start_u: given coordinates (N, n) there [rad, m].
        end_u: given coordinates (N, n) to go to [rad, m].
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
        goal = start_u[rows] + ahead[:, None] * way
        values, trial_codes = step(goal, Start(s[rows], velocity_map[rows]), rows)
        accepted = trial_codes == GOOD
        forward = rows[accepted]
        s[forward] = values["s"][accepted]
        velocity_map[forward] = values["R"][accepted]
        progress[forward] = ahead[accepted]
        length[forward] *= 2.0
        rejected = rows[~accepted]
        length[rejected] *= 0.5
        codes[rows] = trial_codes
        working[rejected] = length[rejected] >= SHORTEST
    codes = np.where((codes == GOOD) & (progress < 1.0), JUMP, codes)
    return Continuation(s, codes, progress)
