"""Interval arithmetic over the traced graph of a program."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ...ground.arrays import Array
from ...kernels.graph import Graph, Operand, Symbol
from ..interval import Interval
from .interval_matrix import IntervalMatrix

_UNARY: Mapping[str, Callable[[Interval], Interval]] = {
    "neg": lambda a: -a,
    "sin": Interval.sin,
    "cos": Interval.cos,
    "sqrt": Interval.sqrt,
    "abs": Interval.absolute,
    "rint": Interval.rint,
}
_BINARY: Mapping[str, Callable[[Interval, Interval], Interval]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "atan2": Interval.atan2,
}


class GraphValues:
    """Values of a graph for N boxes of its inputs at once.

    Args:
        graph: the graph; of its blocks, only inverses are supported.
        outputs: the wanted nodes, or constants.
    """

    def __init__(
        self,
        graph: Graph,
        outputs: Sequence[Operand],
    ) -> None:
        self._graph = graph
        self._outputs = list(outputs)
        self._live = graph.live(self._outputs)

    def at(
        self,
        inputs: Mapping[tuple[int, int], Interval],
        count: int,
    ) -> list[Interval]:
        """The outputs.

        Args:
            inputs: by vector and component, arrays (count,) or numbers.
            count: number of boxes.
        """
        nodes: dict[int, Interval] = {}
        blocks: dict[int, list[Interval]] = {}
        for index in self._live:
            op, a, b = self._graph.nodes[index]
            if op == "input":
                nodes[index] = inputs[int(a), int(b)]
            elif op == "block":
                if a not in blocks:
                    blocks[int(a)] = self._inverse(
                        int(a),
                        nodes,
                        count,
                    )
                nodes[index] = blocks[int(a)][int(b)]
            elif op in _UNARY:
                nodes[index] = _UNARY[op](_value(a, nodes))
            else:
                nodes[index] = _BINARY[op](
                    _value(a, nodes),
                    _value(b, nodes),
                )
        return [_output(x, nodes) for x in self._outputs]

    def _inverse(
        self,
        number: int,
        nodes: dict[int, Interval],
        count: int,
    ) -> list[Interval]:
        """The inverse of a matrix row by row."""
        block = self._graph.blocks[number]
        (operands,) = block.arguments
        entries = [_output(x, nodes) for x in operands]
        matrix = IntervalMatrix.of(entries, block.size, count)
        return matrix.inverse().entries()


def _value(
    x: int | float,
    nodes: Mapping[int, Interval],
) -> Interval:
    if isinstance(x, int):
        return nodes[x]
    return Interval(x)


def _output(
    x: Operand,
    nodes: Mapping[int, Interval],
) -> Interval:
    if isinstance(x, Symbol):
        return nodes[x.index]
    return Interval(x)


def columns(lower: Array, upper: Array) -> list[Interval]:
    """The components of N boxes (N, n), each an interval of arrays (N,)."""
    return [Interval(a, b) for a, b in zip(lower.T, upper.T, strict=True)]
