"""Redundant equations that are solved with a block, so that it is singular only where all are.

A block with as many equations as unknowns may be singular where all equations together are not. It
is as good as all of them if the ratio of the determinants is constant. Then it stays as it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .constraints.equations import Equation, LoopEquations, equations_of
from .matching import EquationBlock, match
from .numeric_closure import close_numerically, fixed_perturbation, gaps_and_jacobian

# moves of the given coordinates to the configurations that are compared [rad, m]
MOVES = (0.07, -0.11, 0.23, -0.31, 0.02, -0.005)
CLOSED_NEARBY = 1e-9  # largest gap of a configuration that counts as closed [rad, m]
CONSTANT = 1e-5  # relative change of a ratio of determinants that counts as none
REGULAR = 1e-6  # least singular value, over the largest, of equations that are compared
PART = 1e-7  # share of one equation in another that counts
Blocks = Sequence[EquationBlock]


def joined_blocks(
    tree: Tree,
    loops: Sequence[LoopEquations],
    near: Mapping[int, float],
    blocks: Blocks,
    redundant: Sequence[Equation],
    is_exact: Sequence[bool],
) -> list[EquationBlock]:
    """Blocks with redundant equations, singular only where all equations together are.

    Args:
        tree: the spanning tree.
        loops: all equations.
        near: a configuration near which the loops close, by coordinate [rad, m].
        blocks: blocks of the independent equations in solving order.
        redundant: equations that follow from the independent ones.
        is_exact: for each block, whether it has a closed form. Such a block stays as it is if
            redundant equations do not change where it is singular.
    """
    start = [float(near.get(k, 0.0)) for k in range(len(tree.coordinates))]
    unknowns = sorted(chain.from_iterable(block.unknowns for block in blocks))
    samples = _jacobians(tree, loops, start, unknowns)
    rows = {equation: row for row, equation in enumerate(equations_of(loops))}
    comparison = _Comparison(rows, samples)
    equations = list(chain.from_iterable(block.equations for block in blocks))
    everything = EquationBlock((*equations, *redundant), tuple(unknowns))
    joined = _with_redundant(blocks, redundant)
    for k, block in enumerate(blocks):
        if is_exact[k] and comparison.is_constant([block], [joined[k]]):
            joined[k] = block
    if comparison.is_constant(joined, [everything]):
        return joined
    ties = comparison.ties(equations, redundant, unknowns)
    return _with_redundant(match(equations, unknowns, ties).blocks, redundant)


def _with_redundant(blocks: Blocks, redundant: Sequence[Equation]) -> list[EquationBlock]:
    """The blocks with redundant equations; each joins the last block that has an unknown of it."""
    more: list[list[Equation]] = [[] for _ in blocks]
    for equation in redundant:
        for block, equations in zip(reversed(blocks), reversed(more), strict=True):
            if equation.involved & set(block.unknowns):
                equations.append(equation)
                break
    result: list[EquationBlock] = []
    for block, equations in zip(blocks, more, strict=True):
        result.append(EquationBlock((*block.equations, *equations), block.unknowns))
    return result


@dataclass(frozen=True)
class _Comparison:
    """Comparison of blocks at closed configurations.

    Attributes:
        rows: row of each equation in the Jacobians.
        samples: Jacobians (all equations, all coordinates).
    """

    rows: Mapping[Equation, int]
    samples: Sequence[Array]

    def is_constant(self, some: Blocks, others: Blocks) -> bool:
        """Whether the determinants of two sets of blocks have a constant ratio."""
        ratios: list[float] = []
        for sample in self.samples:
            ratio = self._size(sample, some) - self._size(sample, others)
            if math.isfinite(ratio):
                ratios.append(ratio)
        return bool(ratios) and max(ratios) - min(ratios) < CONSTANT

    def ties(
        self,
        equations: Sequence[Equation],
        redundant: Sequence[Equation],
        unknowns: Sequence[int],
    ) -> list[list[Equation]]:
        """For each redundant equation, the independent ones of which it is a combination."""
        independent = EquationBlock(tuple(equations), tuple(unknowns))
        dependent = EquationBlock(tuple(redundant), tuple(unknowns))
        shares = np.zeros((len(redundant), len(equations)))
        for sample in self.samples:
            rows = self._matrix(sample, independent)
            others = self._matrix(sample, dependent)
            factors, *_ = np.linalg.lstsq(rows.T, others.T, rcond=None)
            shares = np.maximum(shares, np.abs(factors.T))
        ties: list[list[Equation]] = []
        for row in shares:
            indices = np.flatnonzero(row > PART).tolist()
            ties.append([equations[k] for k in indices])
        return ties

    def _size(self, sample: Array, blocks: Blocks) -> float:
        """Logarithm of the product of all singular values of blocks; NaN near a singular place."""
        total = 0.0
        for block in blocks:
            values = np.linalg.svd(self._matrix(sample, block), compute_uv=False)
            if values[-1] < REGULAR * values[0]:
                return math.nan
            total += float(np.log(values).sum())
        return total

    def _matrix(self, sample: Array, block: EquationBlock) -> Array:
        """The rows and columns of a Jacobian that are those of a block."""
        chosen = [self.rows[equation] for equation in block.equations]
        matrix: Array = sample[np.ix_(chosen, list(block.unknowns))]
        return matrix


def _jacobians(
    tree: Tree, loops: Sequence[LoopEquations], start: Sequence[float], unknowns: Sequence[int]
) -> list[Array]:
    """Jacobians at closed configurations near a start, with the given coordinates moved."""
    given = [k for k in range(len(start)) if k not in unknowns]
    closed, _ = close_numerically(tree, loops, start, unknowns)
    samples: list[Array] = []
    for k, size in enumerate(MOVES):
        moved = closed.copy()
        moved[given] += size * fixed_perturbation(len(given), k)
        s, gaps = close_numerically(tree, loops, moved, unknowns)
        if max(gaps.values(), default=0.0) < CLOSED_NEARBY:
            _, jacobian = gaps_and_jacobian(tree, loops, s, range(len(start)))
            samples.append(jacobian)
    return samples
