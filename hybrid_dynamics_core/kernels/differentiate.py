"""Exact derivatives of what a program computes: forward differentiation of its graph, node by node.

Each node gets its derivatives in the directions asked, as further nodes of the same graph;
directions in which it does
not change are left out, so structural zeros cost nothing. An iteration is differentiated as the
equations it solves:
with residuals phi(x, p) = 0,  dx = -(d phi/dx)^-1 (d phi/dp) dp,  where d phi/dx is the Jacobian it
iterates with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ..algebra.linear import Inverse
from ..algebra.numerics import invert, newton
from ..algebra.scalar import Scalar, absolute, atan2, cos, sin, sqrt
from .graph import Block, Graph, Operand, Symbol

Tangent = dict[int, Operand]  # direction -> derivative, zeros left out
_UNARY: Mapping[str, Callable[[Scalar], Scalar]] = {
    "neg": lambda a: -a,
    "sin": sin,
    "cos": cos,
    "sqrt": sqrt,
    "abs": absolute,
}
_BINARY: Mapping[str, Callable[[Scalar, Scalar], Scalar]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "atan2": atan2,
}


def jacobian(outputs: Sequence[Operand], inputs: Sequence[Operand]) -> list[list[Operand]]:
    """d outputs / d inputs (rows by output); all symbols of one graph, the inputs being inputs of it."""
    seeds: dict[int, Tangent] = {
        x.index: {k: 1.0} for k, x in enumerate(inputs) if isinstance(x, Symbol)
    }
    found = _Tangents(outputs, seeds)
    return [[found.of(y).get(k, 0.0) for k in range(len(inputs))] for y in outputs]


def substitute(outputs: Sequence[Operand], replaced: Mapping[Operand, Scalar]) -> list[Scalar]:
    """The outputs with input symbols replaced; what does not depend on them stays as it is."""
    values = {
        symbol.index: value for symbol, value in replaced.items() if isinstance(symbol, Symbol)
    }
    graph = next((y.graph for y in outputs if isinstance(y, Symbol)), None)
    if graph is None:
        return list(outputs)
    for index in graph.live(outputs):
        if graph.nodes[index][0] == "input":
            values.setdefault(index, Symbol(graph, index))
    return evaluate(graph, outputs, values)


def evaluate(
    graph: Graph, outputs: Sequence[Operand], inputs: Mapping[int, Scalar]
) -> list[Scalar]:
    """The outputs over any scalars, given those of the live input nodes by index."""
    values = dict(inputs)
    blocks: dict[int, list[Scalar]] = {}

    def operand(x: Operand | int) -> Scalar:
        if isinstance(x, Symbol):
            return values[x.index]
        return values[x] if isinstance(x, int) else x

    for index in graph.live(outputs):
        op, a, b = graph.nodes[index]
        if index in values:
            continue
        if op == "block":
            if int(a) not in blocks:
                block = graph.blocks[int(a)]
                blocks[int(a)] = _run(
                    block, [[operand(x) for x in vector] for vector in block.arguments]
                )
            values[index] = blocks[int(a)][int(b)]
        elif op in _UNARY:
            values[index] = _UNARY[op](operand(a))
        else:
            values[index] = _BINARY[op](operand(a), operand(b))
    return [operand(y) for y in outputs]


def _run(block: Block, arguments: list[list[Scalar]]) -> list[Scalar]:
    if block.body is None:
        return invert(arguments[0], block.size)
    return newton(block.body, *arguments)


class _Tangents:
    """Derivatives of every node that the outputs depend on."""

    def __init__(self, outputs: Sequence[Operand], seeds: Mapping[int, Tangent]) -> None:
        self._of: dict[int, Tangent] = dict(seeds)
        self._blocks: dict[int, list[Tangent]] = {}
        self._graph = next((y.graph for y in outputs if isinstance(y, Symbol)), Graph())
        for index in self._graph.live(outputs):
            if index not in self._of:
                self._of[index] = self._node(index)

    def of(self, x: Operand | int) -> Tangent:
        """Derivatives of a node, by symbol or index, or of a constant."""
        if isinstance(x, Symbol):
            return self._of[x.index]
        return self._of[x] if isinstance(x, int) else {}

    def _node(self, index: int) -> Tangent:
        op, a, b = self._graph.nodes[index]
        if op == "input":
            return {}
        if op == "block":
            number = int(a)
            if number not in self._blocks:
                self._blocks[number] = self._block(number)
            return self._blocks[number][int(b)]
        da, db = self.of(a), self.of(b)
        if not da and not db:
            return {}
        return _combine(self._slopes(index), (da, db))

    def _slopes(self, index: int) -> tuple[Operand, Operand]:
        """Derivatives of a node with respect to its operands."""
        op, left, right = self._graph.nodes[index]
        a, b = self._value(left), self._value(right)
        if op == "mul":
            return b, a
        if op == "div":
            return 1.0 / b, -Symbol(self._graph, index) / b
        if op == "atan2":
            size = a * a + b * b
            return b / size, -a / size
        if op == "sqrt":
            return 0.5 / Symbol(self._graph, index), 0.0
        if op == "abs":
            return a / Symbol(self._graph, index), 0.0
        return (
            {"sin": (cos(a), 0.0), "cos": (-sin(a), 0.0)}[op]
            if op in ("sin", "cos")
            else _LINEAR[op]
        )

    def _value(self, x: int | float) -> Scalar:
        return Symbol(self._graph, x) if isinstance(x, int) else x

    def _block(self, number: int) -> list[Tangent]:
        block = self._graph.blocks[number]
        changes = [[self.of(x) for x in vector] for vector in block.arguments]
        outputs = [self._graph.output(number, k) for k in range(_outputs(block))]
        if block.body is None:
            return _inverse_tangents(block.size, outputs, changes[0])
        return _newton_tangents(block, outputs[: block.size], changes[1])


_LINEAR: Mapping[str, tuple[float, float]] = {
    "add": (1.0, 1.0),
    "sub": (1.0, -1.0),
    "neg": (-1.0, 0.0),
}


def _outputs(block: Block) -> int:
    return block.size * block.size + 1 if block.body is None else block.size + 1


def _combine(slopes: Sequence[Operand], changes: Sequence[Tangent]) -> Tangent:
    """Sum of slope times change, direction by direction."""
    total: dict[int, Scalar] = {}
    for slope, change in zip(slopes, changes, strict=True):
        for direction, value in change.items():
            part = slope * value
            total[direction] = total[direction] + part if direction in total else part
    return {k: v for k, v in total.items() if isinstance(v, Symbol) or v != 0.0}


def _inverse_tangents(
    size: int, outputs: Sequence[Operand], changes: Sequence[Tangent]
) -> list[Tangent]:
    """d(A^-1) = -A^-1 dA A^-1,  d(det A) = det A tr(A^-1 dA)."""
    inverse = [outputs[k * size : (k + 1) * size] for k in range(size)]
    result: list[Tangent] = [{} for _ in outputs]
    for direction in {d for change in changes for d in change}:
        slope = [
            [changes[i * size + j].get(direction, 0.0) for j in range(size)] for i in range(size)
        ]
        left = _product(inverse, slope)
        whole = _product(left, inverse)
        for i in range(size):
            for j in range(size):
                result[i * size + j][direction] = -whole[i][j]
        result[-1][direction] = outputs[-1] * sum((left[i][i] for i in range(1, size)), left[0][0])
    return result


def _product(a: Sequence[Sequence[Scalar]], b: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
    columns = list(zip(*b, strict=True))
    return [
        [sum((x * y for x, y in zip(row, column, strict=True)), 0.0) for column in columns]
        for row in a
    ]


def _newton_tangents(
    block: Block, solution: Sequence[Operand], changes: Sequence[Tangent]
) -> list[Tangent]:
    """Of the equations solved, at their solution; whether the iteration converged does not change."""
    size = block.size
    result: list[Tangent] = [{} for _ in range(size + 1)]
    if block.body is None or not any(changes):
        return result
    moving = [k for k, change in enumerate(changes) if change]
    own = Graph()  # in a graph of their own, where the solution is an input like the parameters
    unknowns = [own.input(0, k) for k in range(size)]
    parameters = [own.input(1, k) for k in range(len(changes))]
    values = block.body(unknowns, parameters)
    partial = jacobian(values[:size], [parameters[k] for k in moving])
    given = {
        x.index: y
        for x, y in zip((*unknowns, *parameters), (*solution, *block.arguments[1]), strict=True)
    }
    flat = evaluate(own, [*values[size:], *(slope for row in partial for slope in row)], given)
    inverse = Inverse([flat[i * size : (i + 1) * size] for i in range(size)])
    slopes = [flat[size * size + i * len(moving) :][: len(moving)] for i in range(size)]
    pushes = [_combine(row, [changes[k] for k in moving]) for row in slopes]
    for direction in {d for push in pushes for d in push}:
        for k, value in enumerate(inverse.solve([-push.get(direction, 0.0) for push in pushes])):
            result[k][direction] = value
    return result
