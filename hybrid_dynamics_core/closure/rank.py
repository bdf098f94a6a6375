"""Over-determined but consistent closures: independent equations are found by rank at a closed configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree
from .constraints.equations import Equation, LoopEquations

MAX_ITERATIONS = 200
CLOSED = 1e-6  # residual, in lengths of the loop, up to which a configuration counts as closed
INDEPENDENT = 1e-7  # share of a row that must be left after the rows before it are taken out
STIRS = (
    0.07,
    0.02,
    -0.02,
    0.005,
    -0.005,
)  # [rad or m] moves of the given coordinates off symmetric places


@dataclass(frozen=True)
class Ranked:
    """Independent equations, the ones that follow from them, and unknowns that no equation holds (idle).

    `rank`: number of independent equations with no coordinate given; None where nothing closes.
    """

    independent: list[Equation]
    redundant: list[Equation]
    idle: list[int]
    residual: dict[str, float]  # by loop, at the configuration that closes best
    closest: Array  # that configuration
    rank: int | None
    rigid: bool = (
        False  # closes where it stands, but not where the given coordinates are moved a little
    )


def rank_equations(
    tree: Tree, loops: Sequence[LoopEquations], start: Sequence[float], unknowns: Sequence[int]
) -> Ranked:
    """Close all loops numerically from `start` (all coordinates), then sort the equations by rank."""
    equations = [Equation(loop, k) for loop in loops for k in range(loop.size)]
    closed, residual = close_numerically(tree, loops, start, unknowns)
    moved = _near_by(tree, loops, closed, unknowns)
    if moved is None:
        return Ranked([], [], [], residual, closed, _rank(tree, loops, closed), rigid=True)
    jacobian = jacobian_of(tree, loops, moved, unknowns)[1]
    chosen = _independent_rows(jacobian)
    idle = _idle(jacobian[chosen], unknowns)
    return Ranked(
        [equations[k] for k in chosen],
        [e for k, e in enumerate(equations) if k not in chosen],
        idle,
        residual,
        closed,
        _rank(tree, loops, moved),
    )


def _near_by(
    tree: Tree, loops: Sequence[LoopEquations], closed: Array, unknowns: Sequence[int]
) -> Array | None:
    """A closed configuration near one that may be special, with the given coordinates moved; None if there is none."""
    given = [k for k in range(len(closed)) if k not in unknowns]
    for size in STIRS:
        stirred = np.array(closed)
        stirred[given] += size * np.cos(1.0 + 2.0 * np.arange(len(given)))
        moved, residual = close_numerically(tree, loops, stirred, unknowns)
        if max(residual.values(), default=0.0) < 1e-9:
            return moved
    return None


def _rank(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> int | None:
    """Rank of all equations where they close with every coordinate free, from s."""
    everything = range(len(s))
    closed, residual = close_numerically(tree, loops, s, everything)
    if max(residual.values(), default=0.0) > CLOSED:
        return None
    return len(_independent_rows(jacobian_of(tree, loops, closed, everything)[1]))


AWAY = 0.05  # [rad or m] off a place where the equations have no value


def close_numerically(
    tree: Tree,
    loops: Sequence[LoopEquations],
    start: Sequence[float] | Array,
    unknowns: Sequence[int],
) -> tuple[Array, dict[str, float]]:
    """Gauss-Newton with minimum-norm steps on the unknowns: s, and the residual of each loop."""
    s = np.array(start, dtype=float)
    columns = list(unknowns)
    best, best_s = np.inf, s.copy()
    stalled = 0
    for k in range(MAX_ITERATIONS):
        try:
            residual, jacobian = jacobian_of(tree, loops, s, unknowns)
        except ZeroDivisionError:  # frames half a turn apart: any way to turn is as good as another
            s[columns] += AWAY * np.cos(1.0 + k + 2.0 * np.arange(len(columns)))
            best_s = s.copy() if best == np.inf else best_s
            continue
        size = float(np.abs(residual).max(initial=0.0))
        stalled = 0 if size < 0.9 * best else stalled + 1
        if size < best:
            best, best_s = size, s.copy()
        if size < 1e-15 or stalled > 20:
            break
        step = np.linalg.lstsq(jacobian, -residual, rcond=1e-10)[0]
        s[columns] += step * min(1.0, 0.3 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
    configuration = configuration_at(tree, best_s)
    residuals: dict[str, float] = {}
    for loop in loops:
        error = max(map(abs, loop.gaps(configuration)))
        residuals[loop.name] = max(residuals.get(loop.name, 0.0), error)
    return best_s, residuals


def jacobian_of(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, unknowns: Sequence[int]
) -> tuple[Array, Array]:
    """Gaps (m,) of all equations at s, and their Jacobian (m, unknowns)."""
    configuration = configuration_at(tree, s)
    residual, rows = [], []
    for loop in loops:
        block = loop.linearise(configuration)
        residual += loop.gaps(configuration)
        rows += [[float(row.get(k, 0.0)) for k in unknowns] for row in block.rows]
    return np.array(residual), np.array(rows).reshape(len(residual), len(unknowns))


def _independent_rows(jacobian: Array) -> list[int]:
    """Rows in order, each kept if enough of it is not in the span of the rows kept before (Gram-Schmidt)."""
    basis: list[Array] = []
    kept = []
    for k, row in enumerate(jacobian):
        size = float(np.linalg.norm(row))
        rest = row.copy()
        for _ in range(2):  # twice is enough for orthogonality to rounding
            for direction in basis:
                rest = rest - (direction @ rest) * direction
        left = float(np.linalg.norm(rest))
        if size > 0.0 and left > INDEPENDENT * max(size, 1e-3):
            basis.append(rest / left)
            kept.append(k)
    return kept


def _idle(jacobian: Array, unknowns: Sequence[int]) -> list[int]:
    """Unknowns left free: as many as the rank is short, taken where the null space is largest, last ones first."""
    idle: list[int] = []
    columns = list(range(len(unknowns)))
    while len(columns) > len(jacobian):
        _, _, vectors = np.linalg.svd(jacobian[:, columns])
        null = np.abs(vectors[len(jacobian) :]).max(axis=0)
        pick = max(range(len(columns)), key=lambda c: (round(float(null[c]), 6), c))
        idle.append(unknowns[columns.pop(pick)])
    return sorted(idle)
