"""Over-determined but consistent loops: independent equations by rank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..algebra.independence import independent_rows, norm
from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .constraints.equations import Equation, LoopEquations, equations_of
from .numeric_closure import CLOSED, close_numerically, fixed_perturbation, gaps_and_jacobian

INDEPENDENT = 1e-7  # share of a row that must remain after projection onto the rows before it
SHORTEST_ROW = 1e-3  # a shorter row counts as one of this length
CLOSED_NEARBY = 1e-9  # residual up to which a configuration near the reference counts as closed
DIGITS = 6  # of a null space; equal to these digits, entries count as equal
MISFIT_MOVE = 0.02  # [rad or m] move of the given coordinates at which an error states the gaps
# [rad or m] moves of the given coordinates away from symmetric configurations
MOVES = (0.07, 0.02, -0.02, 0.005, -0.005, 1e-3, -1e-3)


@dataclass(frozen=True)
class Ranked:
    """Equations sorted by rank.

    Attributes:
        independent: equations to solve.
        redundant: equations that follow from the independent ones.
        free: unknowns that no equation determines.
        residual: residuals by loop, at the configuration with the least gap.
        closest: the configuration (n_s,) of `residual` [rad or m].
        rank: number of independent equations if no coordinate is given; None if the loops do not
            close.
        rigid: whether the loops no longer close after a small move of the given coordinates.
            `residual` and `closest` are then those after a move of `MISFIT_MOVE`.
    """

    independent: list[Equation]
    redundant: list[Equation]
    free: list[int]
    residual: dict[str, float]
    closest: Array
    rank: int | None
    rigid: bool = False


def rank_equations(
    tree: Tree, loops: Sequence[LoopEquations], start: Sequence[float], unknowns: Sequence[int]
) -> Ranked:
    """Close all loops numerically, then sort the equations by rank.

    Args:
        tree: the spanning tree.
        loops: all equations.
        start: all coordinates (n_s,) [rad or m].
        unknowns: the coordinates that the equations are to determine.
    """
    closed, residual = close_numerically(tree, loops, start, unknowns)
    moved = _closed_nearby(tree, loops, closed, unknowns)
    if moved is None:
        rank = _rank(tree, loops, closed)
        if max(residual.values()) <= CLOSED:
            moved_start = _moved(closed, unknowns, MISFIT_MOVE)
            closed, residual = close_numerically(tree, loops, moved_start, unknowns)
            return Ranked([], [], [], residual, closed, rank, rigid=True)
        return Ranked([], [], [], residual, closed, rank)
    _, jacobian = gaps_and_jacobian(tree, loops, moved, unknowns)
    chosen = _independent(jacobian)
    equations = equations_of(loops)
    return Ranked(
        independent=[equations[k] for k in chosen],
        redundant=[equation for k, equation in enumerate(equations) if k not in chosen],
        free=_free(jacobian[chosen], unknowns),
        residual=residual,
        closest=closed,
        rank=_rank(tree, loops, moved),
    )


def _closed_nearby(
    tree: Tree, loops: Sequence[LoopEquations], closed: Array, unknowns: Sequence[int]
) -> Array | None:
    """A closed configuration near another, with given coordinates moved; None if none."""
    for size in MOVES:
        start = _moved(closed, unknowns, size)
        moved, residual = close_numerically(tree, loops, start, unknowns)
        if max(residual.values(), default=0.0) < CLOSED_NEARBY:
            return moved
    return None


def _moved(closed: Array, unknowns: Sequence[int], size: float) -> Array:
    """A configuration (n_s,) with the given coordinates moved by at most `size`."""
    given = [k for k in range(len(closed)) if k not in unknowns]
    start: Array = np.array(closed)
    start[given] += size * fixed_perturbation(len(given))
    return start


def _rank(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> int | None:
    """Rank of all equations at a closed configuration near s, with every coordinate free."""
    everything = range(len(s))
    closed, residual = close_numerically(tree, loops, s, everything)
    if max(residual.values(), default=0.0) > CLOSED:
        return None
    _, jacobian = gaps_and_jacobian(tree, loops, closed, everything)
    return len(_independent(jacobian))


def _independent(jacobian: Array) -> list[int]:
    """Independent rows of a Jacobian, the first ones preferred."""
    least = [INDEPENDENT * max(norm(row), SHORTEST_ROW) for row in jacobian]
    return independent_rows(jacobian, range(len(jacobian)), least)


def _free(jacobian: Array, unknowns: Sequence[int]) -> list[int]:
    """Unknowns that no equation determines: as many as the rank is short.

    Those with the largest parts in the null space are chosen, later ones first.
    """
    free: list[int] = []
    columns = list(range(len(unknowns)))
    while len(columns) > len(jacobian):
        _, _, vectors = np.linalg.svd(jacobian[:, columns])
        null = np.abs(vectors[len(jacobian) :]).max(axis=0)
        sizes = [round(float(size), DIGITS) for size in null]
        _, last = max((size, column) for column, size in enumerate(sizes))
        free.append(unknowns[columns.pop(last)])
    return sorted(free)
