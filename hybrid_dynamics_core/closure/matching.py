"""Which equation determines which unknown, and in which order: a block-triangular form.

Structure alone counts: which coordinate can occur in which equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from .constraints.equations import Equation

Indices = NDArray[np.int32]


class EquationBlock(NamedTuple):
    """Equations that determine as many unknowns together, given the blocks before."""

    equations: tuple[Equation, ...]
    unknowns: tuple[int, ...]


class Matching(NamedTuple):
    """Equations matched to unknowns.

    Attributes:
        blocks: blocks in solving order, where every equation and every unknown has its match.
        undetermined: unknowns that no equation remains for.
        surplus: equations that no unknown remains for.
    """

    blocks: list[EquationBlock]
    undetermined: list[int]
    surplus: list[Equation]


def match(equations: Sequence[Equation], unknowns: Sequence[int]) -> Matching:
    """Match equations to unknowns and order them into the smallest blocks."""
    if not any(equation.involved & set(unknowns) for equation in equations):
        return Matching([], list(unknowns), list(equations))
    incidence = _incidence(equations, unknowns)
    matched = maximum_bipartite_matching(incidence, perm_type="column")
    surplus = [equations[row] for row in np.flatnonzero(matched < 0).tolist()]
    undetermined = _undetermined(incidence, matched)
    if surplus or undetermined:
        return Matching([], [unknowns[k] for k in undetermined], surplus)
    # equation r needs the unknowns of the equations in its row
    depends = csr_array(incidence[:, matched])
    _, label = connected_components(depends, directed=True, connection="strong")
    blocks: list[EquationBlock] = []
    for rows in _ordered(depends, label):
        solved = sorted(unknowns[matched[row]] for row in rows)
        of_block = tuple(equations[row] for row in rows)
        blocks.append(EquationBlock(of_block, tuple(solved)))
    return Matching(blocks, [], [])


def _incidence(equations: Sequence[Equation], unknowns: Sequence[int]) -> csr_array:
    """Entries where an equation can depend on an unknown (equations, unknowns)."""
    column = {coordinate: k for k, coordinate in enumerate(unknowns)}
    pairs: list[tuple[int, int]] = []
    for row, equation in enumerate(equations):
        pairs += [(row, column[k]) for k in sorted(equation.involved) if k in column]
    indices = np.array(pairs, dtype=np.int32).T
    entries = np.ones(len(pairs))
    shape = (len(equations), len(unknowns))
    return csr_array(coo_array((entries, indices), shape=shape))


def _undetermined(incidence: csr_array, matched: Indices) -> list[int]:
    """Columns without an equation, and all that could be without one instead.

    They are on alternating paths from one another.
    """
    has_equation = set(matched[matched >= 0].tolist())
    columns = [c for c in range(incidence.shape[1]) if c not in has_equation]
    by_column = incidence.tocsc()
    for c in columns:  # grows while it is walked
        for row in by_column[:, [c]].indices:
            other = int(matched[row])
            if other >= 0 and other not in columns:
                columns.append(other)
    return sorted(columns)


def _ordered(depends: csr_array, label: Indices) -> list[list[int]]:
    """Rows of each block, such that each block needs only earlier ones; as given among equals."""
    waiting = list(dict.fromkeys(label.tolist()))
    members = {block: np.flatnonzero(label == block).tolist() for block in waiting}
    needs: dict[int, set[int]] = {}
    for block in waiting:
        needs[block] = _blocks_in(depends, members[block], label) - {block}
    ordered: list[list[int]] = []
    done = set[int]()
    while waiting:
        block = next(block for block in waiting if needs[block] <= done)
        waiting.remove(block)
        done.add(block)
        ordered.append(members[block])
    return ordered


def _blocks_in(depends: csr_array, rows: Sequence[int], label: Indices) -> set[int]:
    """The blocks whose unknowns some equations contain."""
    blocks = set[int]()
    for row in rows:
        blocks.update(label[depends[[row], :].indices].tolist())
    return blocks
