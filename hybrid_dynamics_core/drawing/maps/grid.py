"""Triangles between the states of a grid, in whichever axes they are drawn."""

from __future__ import annotations

import numpy as np
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from ...ground.arrays import Array


def triangles_of(x: Array, y: Array, good: NDArray[np.bool_]) -> Triangulation:
    """Triangles between neighbours of a grid.

    Args:
        x: (r, c) places across.
        y: (r, c) places up.
        good: (r, c) states that have an answer; triangles with others are left out.
    """
    rows, columns = x.shape
    index = np.arange(x.size).reshape(rows, columns)
    without_last = index[:-1]
    without_first = index[1:]
    a = without_last[:, :-1].ravel()
    b = without_first[:, :-1].ravel()
    c = without_first[:, 1:].ravel()
    d = without_last[:, 1:].ravel()
    first = np.stack([a, b, c], axis=1)
    second = np.stack([a, c, d], axis=1)
    triangles = np.concatenate([first, second])
    corners = good.ravel()[triangles]
    answered = corners.all(axis=1)
    across = np.nan_to_num(x.ravel())
    up = np.nan_to_num(y.ravel())
    chosen = triangles[answered]
    return Triangulation(across, up, chosen)
