"""Jacobians by elimination of nodes, which takes fewer operations than tangents of every node.

An edge goes from each operand to each node that uses it, and has the derivative of the node. To
eliminate a node, each edge into it is joined with each edge out of it: their product is added to
the edge that spans both. Once all nodes between inputs and outputs are eliminated, the edges left
are the Jacobian. The order is free, and decides the number of operations. The node that leaves
fewest edges comes first. (Griewank and Walther, Evaluating Derivatives, 2nd ed., chapter 9.)
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence

from ...algebra.scalar import Scalar
from ..graph import Graph, Operand, Symbol
from .slopes import slopes_of

Operands = Sequence[Operand]
ORDERS = (1, -1)  # of nodes that leave as many edges: the first comes first, or the last


def jacobian_by_elimination(
    graph: Graph, outputs: Operands, inputs: Operands, order: int
) -> list[list[Scalar]]:
    """The derivatives of outputs with respect to inputs.

    Args:
        graph: the graph. Between inputs and outputs are no blocks.
        outputs: symbols of the graph, or constants.
        inputs: symbols of inputs of the graph, or constants.
        order: one of `ORDERS`.

    Returns:
        One row for each output, one column for each input.

    Raises:
        ValueError: a block depends on an input.
    """
    edges = _Edges(graph, outputs, inputs)
    edges.eliminate_all(order)
    return [[edges.derivative(k, x) for x in inputs] for k in range(len(outputs))]


class _Edges:
    """Edges between the inputs, the outputs, and the nodes that are not eliminated yet.

    The output k of a Jacobian has the number -1 - k, and an edge from the node that it is.
    """

    def __init__(self, graph: Graph, outputs: Operands, inputs: Operands) -> None:
        self._after: dict[int, dict[int, Operand]] = {}  # derivative of each user of a node
        self._before: dict[int, dict[int, None]] = {}  # operands of a node
        self._inputs = {x.index for x in inputs if isinstance(x, Symbol)}
        for index in self._inputs:
            self._after[index] = {}
        for index in graph.live(outputs):
            if index not in self._inputs:
                self._add_node(graph, index)
        for k, y in enumerate(outputs):
            if isinstance(y, Symbol):
                self._add(y.index, -1 - k, 1.0)

    def _add_node(self, graph: Graph, index: int) -> None:
        """Add the edges into a node, if it depends on an input."""
        if not any(operand in self._after for operand in graph.operands(index)):
            return
        op, *operands = graph.nodes[index]
        if op == "block":
            raise ValueError("a block lies between inputs and outputs")
        for x, slope in zip(operands, slopes_of(graph, index), strict=True):
            if isinstance(x, int):
                self._add(x, index, slope)
        if index in self._before:
            self._after[index] = {}

    def _add(self, operand: int, user: int, slope: Operand) -> None:
        """Add a derivative to the edge from an operand to its user."""
        if operand not in self._after or _is_zero(slope):
            return
        slopes_of_users = self._after[operand]
        if user in slopes_of_users:
            slope = slopes_of_users[user] + slope
        slopes_of_users[user] = slope
        self._before.setdefault(user, {})[operand] = None

    def derivative(self, output: int, x: Operand) -> Operand:
        """The derivative of an output by an input, when all nodes between are eliminated."""
        if isinstance(x, Symbol):
            return self._after[x.index].get(-1 - output, 0.0)
        return 0.0

    def eliminate_all(self, order: int) -> None:
        """Eliminate all nodes."""
        waiting: list[tuple[int, int, int]] = []

        def wait(node: int) -> None:
            if node >= 0 and node in self._before:
                heapq.heappush(waiting, (self._growth(node), order * node, node))

        for node in self._before:
            wait(node)
        while waiting:
            growth, _, node = heapq.heappop(waiting)
            if node not in self._before:
                continue
            if growth != self._growth(node):
                wait(node)
                continue
            for other in self._eliminate(node):
                wait(other)

    def _growth(self, node: int) -> int:
        """The number of edges that the elimination of a node adds, less those that it removes."""
        before, after = self._before[node], self._after[node]
        growth = -len(before) - len(after)
        for operand in before:
            present = self._after[operand]
            for user in after:
                if user not in present:
                    growth += 1
        return growth

    def _eliminate(self, node: int) -> list[int]:
        """Eliminate a node; returns its neighbours."""
        before, after = self._before.pop(node), self._after.pop(node)
        for user in after:
            del self._before[user][node]
        for operand in before:
            slope = self._after[operand].pop(node)
            for user, of_user in after.items():
                self._add(operand, user, of_user * slope)
        return [*before, *after]


def _is_zero(value: Operand) -> bool:
    return not isinstance(value, Symbol) and value == 0.0
