"""Whole turns of passive angles: zero for a single state, without a jump along a motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..mechanism.configuration import TURN, with_turns
from ..programs import Model

Mask = NDArray[np.bool_]


class FreeTurns:
    """The passive angles of a model whose whole turns are free: no loop equation counts them.

    Args:
        model: tree and closure plan.
    """

    def __init__(self, model: Model) -> None:
        self._free = _free(model)
        self._given_free = _given_free(model)

    def nearest(self, s: Array, near: Array) -> Array:
        """The same configurations, with each free angle within half a turn of a given one.

        Args:
            s: coordinates (..., n_s) [rad, m].
            near: coordinates (n_s,) or (..., n_s) [rad, m].
        """
        return np.where(self._free, with_turns(s, near), s)

    def nearest_given(self, u: Array, near: Array) -> Array:
        """Given coordinates, with each free angle within half a turn of another one.

        Args:
            u: given coordinates (..., n) [rad, m].
            near: given coordinates (n,) [rad, m].
        """
        return np.where(self._given_free, with_turns(u, near), u)

    def along(self, s: Array, start: Array) -> Array:
        """The same configurations as one motion: each row is nearest to the row before.

        Args:
            s: coordinates (N, n_s) [rad, m].
            start: coordinates (n_s,) before the first row.
        """
        before = np.concatenate([start[None], s[:-1]])
        steps = np.nan_to_num(np.rint((before - s) / TURN))  # rows that do not close count none
        turns = np.cumsum(steps, axis=0)
        return s + np.where(self._free, turns * TURN, 0.0)


def _free(model: Model) -> Mask:
    coordinates = range(len(model.tree.coordinates))
    free = np.array([model.tree.is_revolute(k) for k in coordinates], dtype=bool)
    free[list(model.plan.given)] = False
    for block in model.plan.blocks:
        counted = block.counted_turns
        if not block.iterates:
            # the angle that it follows is free, its own is not
            counted = counted & frozenset(block.unknowns)
        free[list(counted)] = False
    return free


def _given_free(model: Model) -> Mask:
    """Mask (n,) of given angles with period 2 pi; all False if followers have gear ratios."""
    counts = any(block.counted_turns for block in model.plan.blocks)
    free = [model.tree.is_revolute(k) and not counts for k in model.plan.given]
    return np.array(free, dtype=bool)
