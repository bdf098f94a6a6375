"""Closing all loops together on floats, by Gauss-Newton: what plans and searches begin with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations, coefficients

MAX_ITERATIONS = 200
CLOSED = 1e-6  # residual, in lengths of the loop, up to which a configuration counts as closed
ROUNDING = 1e-15  # residual that is nothing but rounding
LARGEST_STEP = 0.3  # [rad or m]
RANK = 1e-10  # singular values below this share of the largest count as zero
GAIN = 0.9  # an iteration that leaves more of the residual than this has gained nothing
PATIENCE = 20  # iterations without a gain
AWAY = 0.05  # [rad or m] off a place where the equations have no value
TINY = 1e-300


def close_numerically(
    tree: Tree,
    loops: Sequence[LoopEquations],
    start: Sequence[float] | Array,
    unknowns: Sequence[int],
) -> tuple[Array, dict[str, float]]:
    """Close the loops as far as they go, with minimum-norm steps of Gauss-Newton.

    Args:
        tree: the spanning tree.
        loops: the equations.
        start: all coordinates (n_s,) [rad or m].
        unknowns: the coordinates that may change.

    Returns:
        All coordinates (n_s,) where the residual is least, and there the largest residual of each
        loop by name.
    """
    s = np.array(start, dtype=float)
    columns = list(unknowns)
    least = np.inf
    best = s.copy()
    without_gain = 0
    for k in range(MAX_ITERATIONS):
        try:
            residual, jacobian = gaps_and_jacobian(tree, loops, s, unknowns)
        except ZeroDivisionError:  # frames half a turn apart: any way to turn is as good as another
            s[columns] += AWAY * irregular(len(columns), k)
            if least == np.inf:
                best = s.copy()
            continue
        size = float(np.abs(residual).max(initial=0.0))
        without_gain += 1
        if size < GAIN * least:
            without_gain = 0
        if size < least:
            least = size
            best = s.copy()
        if size < ROUNDING or without_gain > PATIENCE:
            break
        step = np.linalg.lstsq(jacobian, -residual, rcond=RANK)[0]
        longest = float(np.abs(step).max(initial=0.0))
        s[columns] += step * min(1.0, LARGEST_STEP / max(longest, TINY))
    return best, _largest_gaps(tree, loops, best)


def irregular(size: int, k: int = 0) -> Array:
    """Numbers between -1 and 1 without a pattern, always the same: the k-th such vector (size,)."""
    numbers: Array = np.cos(1.0 + k + 2.0 * np.arange(size))
    return numbers


def _largest_gaps(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> dict[str, float]:
    """The largest residual of each loop by name."""
    configuration = configuration_at(tree, s)
    largest: dict[str, float] = {}
    for loop in loops:
        gap = max(map(abs, loop.gaps(configuration)))
        largest[loop.name] = max(largest.get(loop.name, 0.0), gap)
    return largest


def gaps_and_jacobian(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, unknowns: Sequence[int]
) -> tuple[Array, Array]:
    """Gaps (m,) of all equations at s (n_s,), and their Jacobian (m, unknowns)."""
    configuration = configuration_at(tree, s)
    gaps: list[float] = []
    entries: list[list[float]] = []
    for loop in loops:
        gaps += loop.gaps(configuration)
        rows = loop.linearise(configuration).rows
        entries += [coefficients(row, unknowns) for row in rows]
    jacobian = np.array(entries, dtype=float)
    return np.array(gaps), jacobian.reshape(len(gaps), len(unknowns))
