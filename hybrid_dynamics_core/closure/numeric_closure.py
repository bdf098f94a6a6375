"""Closing all loops together on floats, by Gauss-Newton, for plans and searches.

A gap is the value of one equation of a loop, a length in lengths of the loop or an angle in rad. It
is zero where the loop is closed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations, coefficients

CLOSED = 1e-6  # [lengths of the loop, or rad] gap up to which a configuration counts as closed
ROUNDING = 1e-15  # [lengths of the loop, or rad] a smaller gap is rounding
MAX_ITERATIONS = 200
LARGEST_STEP = 0.3  # [rad or m] of any coordinate in one iteration
RANK_TOLERANCE = 1e-10  # singular values below this share of the largest count as zero
SUFFICIENT_DECREASE = 0.9  # it is progress if the gap falls below this share of the least
PATIENCE = 20  # iterations without such progress before the search ends
PERTURBATION = 0.05  # [rad or m] steps away from a configuration where the equations are undefined
TINY = 1e-300  # keeps a division by a step of zero finite


def close_numerically(
    tree: Tree,
    loops: Sequence[LoopEquations],
    start: Sequence[float] | Array,
    unknowns: Sequence[int],
) -> tuple[Array, dict[str, float]]:
    """Close the loops as far as possible, with minimum-norm steps of Gauss-Newton.

    Loops that stay open raise nothing: compare the gaps with CLOSED.

    Args:
        tree: the spanning tree.
        loops: the equations.
        start: all coordinates (n_s,) [rad or m].
        unknowns: the coordinates that may change.

    Returns:
        All coordinates (n_s,) where the largest gap was least, and the largest gap of each loop
        there, by name.

    Raises:
        ZeroDivisionError: the equations are undefined wherever the search went.
    """
    s = np.array(start, dtype=float)
    columns = list(unknowns)
    least = np.inf
    best = s.copy()
    without_gain = 0
    for k in range(MAX_ITERATIONS):
        try:
            gaps, jacobian = gaps_and_jacobian(tree, loops, s, unknowns)
        except ZeroDivisionError:  # frames half a turn apart: any direction of turning is as good
            s[columns] += PERTURBATION * fixed_perturbation(len(columns), k)
            if least == np.inf:
                best = s.copy()
            continue
        largest = float(np.abs(gaps).max(initial=0.0))
        without_gain += 1
        if largest < SUFFICIENT_DECREASE * least:
            without_gain = 0
        if largest < least:
            least = largest
            best = s.copy()
        if largest < ROUNDING or without_gain > PATIENCE:
            break
        step = np.linalg.lstsq(jacobian, -gaps, rcond=RANK_TOLERANCE)[0]
        longest = float(np.abs(step).max(initial=0.0))
        s[columns] += step * min(1.0, LARGEST_STEP / max(longest, TINY))
    return best, largest_gaps(tree, loops, best)


def fixed_perturbation(size: int, k: int = 0) -> Array:
    """The k-th vector (size,) of pseudo-random numbers in [-1, 1], the same in every run."""
    numbers: Array = np.cos(1.0 + k + 2.0 * np.arange(size))
    return numbers


def largest_gaps(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> dict[str, float]:
    """The largest gap of each loop by name, at s (n_s,)."""
    configuration = configuration_at(tree, s)
    largest: dict[str, float] = {}
    for loop in loops:
        residual = loop.linearise(configuration).residual
        gap = max(map(abs, loop.gaps(configuration, residual)))
        largest[loop.name] = max(largest.get(loop.name, 0.0), gap)
    return largest


def gaps_and_jacobian(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, unknowns: Sequence[int]
) -> tuple[Array, Array]:
    """Gaps of all equations, and the rows of J_s.

    At a closed configuration the rows are the exact Jacobian of the gaps. Elsewhere they are an
    approximation that is good enough for a search.

    Args:
        tree: the spanning tree.
        loops: the equations.
        s: all coordinates (n_s,) [rad or m].
        unknowns: the coordinates of the columns to return.

    Returns:
        Gaps (m,) and rows (m, unknowns).

    Raises:
        ZeroDivisionError: two frames are exactly half a turn apart.
    """
    configuration = configuration_at(tree, s)
    gaps: list[float] = []
    entries: list[list[float]] = []
    for loop in loops:
        rows, residual = loop.linearise(configuration)
        gaps += loop.gaps(configuration, residual)
        entries += [coefficients(row, unknowns) for row in rows]
    jacobian = np.array(entries, dtype=float)
    return np.array(gaps), jacobian.reshape(len(gaps), len(unknowns))
