"""Gauss-Newton closure of all loops from many starts at once, on arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..ground.arrays import Array
from ..mechanism.configuration import given_configuration
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations, coefficients
from .numeric_closure import LARGEST_STEP, RANK_TOLERANCE, ROUNDING, SUFFICIENT_DECREASE

MOST_STEPS = 60  # from each start
PATIENCE = 10  # consecutive steps without progress after which a start is abandoned
TINY = 1e-300  # avoids division by zero for a step of zero


def close_from_starts(
    tree: Tree, loops: Sequence[LoopEquations], starts: Array, unknowns: Sequence[int]
) -> tuple[Array, Array]:
    """Close the loops from each start with the least gap, as `close_numerically` does.

    Args:
        tree: the spanning tree.
        loops: the equations.
        starts: all coordinates (B, n_s) [rad or m].
        unknowns: the coordinates that may change.

    Returns:
        Coordinates (B, n_s) with the least largest gap, and that gap (B,), which is infinite if the
        equations were undefined.
    """
    columns = list(unknowns)
    best = starts.copy()
    least = np.full(len(starts), np.inf)
    idle = np.zeros(len(starts), dtype=int)
    rows = np.arange(len(starts))
    s = starts.copy()
    for _ in range(MOST_STEPS):
        gaps, jacobian = _gaps_and_jacobian(tree, loops, s[rows], columns)
        largest = np.abs(gaps).max(axis=-1, initial=0.0)
        idle[rows] = np.where(largest < SUFFICIENT_DECREASE * least[rows], 0, idle[rows] + 1)
        better = largest < least[rows]
        best[rows[better]] = s[rows[better]]
        least[rows[better]] = largest[better]
        goes_on = (largest >= ROUNDING) & np.isfinite(largest) & (idle[rows] <= PATIENCE)
        rows = rows[goes_on]
        if not len(rows):
            break
        s[np.ix_(rows, columns)] += _steps(gaps[goes_on], jacobian[goes_on])
    return best, least


def _steps(gaps: Array, jacobian: Array) -> Array:
    """Steps (B, k) of least norm, bounded in each coordinate."""
    inverse = np.linalg.pinv(jacobian, rcond=RANK_TOLERANCE)
    steps = -(inverse @ gaps[..., None])[..., 0]
    longest = np.abs(steps).max(axis=-1, initial=0.0, keepdims=True)
    shortened: Array = steps * np.minimum(1.0, LARGEST_STEP / np.maximum(longest, TINY))
    return shortened


def _gaps_and_jacobian(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, unknowns: Sequence[int]
) -> tuple[Array, Array]:
    """Gaps (B, m), infinite where undefined, and J_s (B, m, k) by the unknowns."""
    values = {k: np.ascontiguousarray(column) for k, column in enumerate(s.T)}
    configuration = given_configuration(tree, values)
    gaps: list[Array] = []
    entries: list[list[Array]] = []
    shape = (len(s),)
    with np.errstate(all="ignore"):
        for loop in loops:
            rows, residual = loop.linearise(configuration)
            of_loop = loop.gaps(configuration, residual)
            gaps += [np.broadcast_to(gap, shape) for gap in of_loop]
            for row in rows:
                of_row = coefficients(row, unknowns)
                entries.append([np.broadcast_to(entry, shape) for entry in of_row])
    jacobian = np.array(entries, dtype=float).reshape(len(gaps), len(unknowns), len(s))
    jacobian = np.moveaxis(jacobian, -1, 0)
    of_all = np.stack(gaps, axis=-1)
    has_values = np.isfinite(of_all).all(axis=-1) & np.isfinite(jacobian).all(axis=(-1, -2))
    return np.where(has_values[:, None], of_all, np.inf), jacobian
