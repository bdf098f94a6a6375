"""Which equation determines which unknown, and in which order: a block-triangular form of the loop equations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from .constraints.equations import Equation


class EquationBlock(NamedTuple):
    """Equations that determine as many unknowns together, given the blocks before."""

    equations: tuple[Equation, ...]
    unknowns: tuple[int, ...]


class Matching(NamedTuple):
    """Blocks in solving order; unknowns that no equation is left for; equations that no unknown is left for."""

    blocks: list[EquationBlock]
    undetermined: list[int]
    surplus: list[Equation]


def match(equations: Sequence[Equation], unknowns: Sequence[int]) -> Matching:
    """Match by structure (which coordinate can occur in which equation); blocks only where the match is perfect."""
    column = {coordinate: k for k, coordinate in enumerate(unknowns)}
    pairs = [
        (row, column[k])
        for row, e in enumerate(equations)
        for k in sorted(e.involved)
        if k in column
    ]
    shape = (len(equations), len(unknowns))
    if not pairs:
        return Matching([], list(unknowns), list(equations))
    incidence = csr_array(
        coo_array((np.ones(len(pairs)), np.array(pairs, dtype=np.int32).T), shape=shape)
    )
    matched = maximum_bipartite_matching(incidence, perm_type="column")
    surplus = [e for e, m in zip(equations, matched.tolist(), strict=True) if m < 0]
    loose = _loose(incidence, matched)
    if surplus or loose:
        return Matching([], [unknowns[k] for k in loose], surplus)
    depends = csr_array(
        incidence[:, matched]
    )  # equation r needs the unknowns of the equations in its row
    _, label = connected_components(depends, directed=True, connection="strong")
    blocks = [
        EquationBlock(
            tuple(equations[r] for r in rows), tuple(sorted(unknowns[matched[r]] for r in rows))
        )
        for rows in _ordered(depends, label)
    ]
    return Matching(blocks, [], [])


def _loose(incidence: csr_array, matched: np.ndarray) -> list[int]:
    """Columns without an equation, and all that could be without one instead (alternating paths)."""
    owner = {int(c): row for row, c in enumerate(matched) if c >= 0}
    loose = [c for c in range(incidence.shape[1]) if c not in owner]
    by_column = incidence.tocsc()
    for c in loose:  # grows while it is walked
        for row in by_column[:, [c]].indices:
            other = int(matched[row])
            if other >= 0 and other not in loose:
                loose.append(other)
    return sorted(loose)


def _ordered(depends: csr_array, label: np.ndarray) -> list[list[int]]:
    """Rows of each block, such that each block needs only earlier ones; the given order among equals."""
    waiting = list(dict.fromkeys(label.tolist()))
    members = {block: np.flatnonzero(label == block).tolist() for block in waiting}
    needs = {
        block: {int(label[k]) for r in members[block] for k in depends[[r], :].indices} - {block}
        for block in waiting
    }
    result, done = [], set[int]()
    while waiting:
        block = next(b for b in waiting if needs[b] <= done)
        waiting.remove(block)
        done.add(block)
        result.append(members[block])
    return result
