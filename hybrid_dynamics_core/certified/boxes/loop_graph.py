"""The equations of loops, traced once and evaluated for many boxes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.scalar import Scalar
from ...closure.blocks.block_solver import BlockSolver
from ...closure.constraints.equations import loops_of
from ...ground.arrays import Array
from ...kernels.differentiate import jacobian
from ...kernels.graph import Graph
from ...mechanism.configuration import given_configuration
from ...mechanism.tree import Tree
from ..interval import Interval
from ..rounding import down, up
from .graph_values import GraphValues, columns
from .interval_matrix import IntervalMatrix

# operations whose value is unbounded where they are not smooth
SMOOTH = frozenset({"input", "neg", "add", "sub", "mul", "div", "sin", "cos"})


class Cells(NamedTuple):
    """N boxes of given coordinates, with a configuration near the middle of each.

    Attributes:
        lower: lower bounds of the given coordinates (N, n) [rad, m].
        upper: upper bounds (N, n).
        near: values of the other coordinates (N, m) [rad, m].
    """

    lower: Array
    upper: Array
    near: Array


class LoopGraph:
    """The equations of loops as a traced graph, with their exact Jacobian.

    Attributes:
        given: the given coordinates.
        unknown: the other ones.
        is_square: whether there are as many equations as unknowns.
        is_smooth: whether the equations are smooth wherever their enclosure is bounded.
    """

    def __init__(
        self,
        tree: Tree,
        blocks: Sequence[BlockSolver],
        given: Iterable[int],
        charts: Sequence[float],
    ) -> None:
        """Trace the equations.

        Args:
            tree: the spanning tree.
            blocks: the blocks whose equations they are.
            given: the given coordinates.
            charts: chart of each ball or free joint.
        """
        self.given = list(given)
        self.unknown = list(chain.from_iterable(block.unknowns for block in blocks))
        graph = Graph()
        size = len(tree.coordinates)
        symbols = [graph.input(0, k) for k in range(size)]
        configuration = given_configuration(
            tree,
            dict(enumerate(symbols)),
            tuple(charts),
        )
        residuals: list[Scalar] = []
        guards: list[Scalar] = []
        for block in blocks:
            linear = {}
            for loop in loops_of(block.equations):
                linear[loop] = loop.linearise(configuration).residual
                guards += loop.guards(configuration)
            residuals += [linear[e.loop][e.index] for e in block.equations]
        self.is_square = len(residuals) == len(self.unknown)
        slopes = jacobian(
            residuals,
            [symbols[k] for k in self.unknown],
        )
        live = graph.live(residuals)
        self.is_smooth = all(graph.nodes[index][0] in SMOOTH for index in live)
        self._residuals = GraphValues(graph, residuals)
        self._jacobian = GraphValues(graph, list(chain.from_iterable(slopes)))
        self._guards = GraphValues(graph, guards)

    def residuals(self, cells: Cells) -> IntervalMatrix:
        """f(U, y), as columns (N, m, 1)."""
        count = len(cells.near)
        values = self._residuals.at(self._inputs(cells, cells.near, cells.near), count)
        return IntervalMatrix.of(values, 1, count)

    def may_vanish(self, cells: Cells, radius: Array) -> NDArray[np.bool_]:
        """Whether all equations may hold in boxes of this radius (N, m) about `near` (N,)."""
        count = len(cells.near)
        lower, upper = down(cells.near - radius), up(cells.near + radius)
        result = np.ones(count, dtype=bool)
        for value in self._residuals.at(self._inputs(cells, lower, upper), count):
            result &= ~((value.lower > 0.0) | (value.upper < 0.0))
        return result

    def jacobian(self, cells: Cells, radius: Array) -> IntervalMatrix:
        """J(U, X) for boxes of this radius (N, m) about `near`."""
        count = len(cells.near)
        lower, upper = down(cells.near - radius), up(cells.near + radius)
        inputs = self._inputs(cells, lower, upper)
        entries = self._jacobian.at(inputs, count)
        return IntervalMatrix.of(entries, len(self.unknown), count)

    def guards(self, cells: Cells, lower: Array, upper: Array) -> Interval:
        """The least guard of each box (N,), which is negative where frames are opposed."""
        count = len(cells.near)
        least = Interval(np.ones(count))
        for guard in self._guards.at(self._inputs(cells, lower, upper), count):
            least = Interval(
                np.minimum(least.lower, guard.lower),
                np.minimum(least.upper, guard.upper),
            )
        return least

    def _inputs(
        self,
        cells: Cells,
        lower: Array,
        upper: Array,
    ) -> dict[tuple[int, int], Interval]:
        inputs: dict[tuple[int, int], Interval] = {}
        for k, value in zip(
            self.given,
            columns(cells.lower, cells.upper),
            strict=True,
        ):
            inputs[0, k] = value
        for k, value in zip(
            self.unknown,
            columns(lower, upper),
            strict=True,
        ):
            inputs[0, k] = value
        return inputs
