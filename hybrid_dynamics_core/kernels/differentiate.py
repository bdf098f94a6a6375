"""Exact derivatives of a program, by differentiation of its graph.

Each node gets its derivatives in the given directions, as further nodes of the same graph. Zero
derivatives are left out, so structural zeros cost nothing. An iteration is differentiated by the
implicit function theorem. With residuals phi(x, p) = 0, dx = -(d phi/dx)^-1 (d phi/dp) dp, where d
phi/dx is the Jacobian of the iteration.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain

from ..algebra.linear import Inverse, mirrored, transposed, unit_vectors
from ..algebra.numerics import invert, newton
from ..algebra.scalar import Scalar, Scalars, absolute, atan2, cos, rint, sin, sqrt
from .graph import Block, Graph, Operand, Symbol
from .jacobians.elimination import ORDERS, jacobian_by_elimination
from .jacobians.slopes import slopes_of

Operands = Sequence[Operand]
Rows = list[list[Scalar]]
# [nodes] graphs in which elimination always takes less than tangents of every node are longer
LONGEST_BY_NODE = 2000
MOST_COLUMNS = 8  # of a symmetric matrix; more columns take more operations than elimination
PLACEHOLDER = -1  # number of the input vector of a linear function
Tangent = dict[int, Operand]  # direction -> derivative, zeros left out
_UNARY: Mapping[str, Callable[[Scalar], Scalar]] = {
    "neg": lambda a: -a,
    "sin": sin,
    "cos": cos,
    "sqrt": sqrt,
    "abs": absolute,
    "rint": rint,
}
_BINARY: Mapping[str, Callable[[Scalar, Scalar], Scalar]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "atan2": atan2,
}


def jacobian(outputs: Operands, inputs: Operands) -> Rows:
    """The derivatives of outputs with respect to inputs.

    Args:
        outputs: symbols of one graph, or constants.
        inputs: input symbols of the same graph, or constants.

    Returns:
        One row for each output, one column for each input.
    """
    seeds: dict[int, Tangent] = {}
    for direction, x in enumerate(inputs):
        if isinstance(x, Symbol):
            seeds[x.index] = {direction: 1.0}
    tangents = _Tangents(outputs, seeds)
    directions = range(len(inputs))
    rows = []
    for y in outputs:
        tangent = tangents.of(y)
        rows.append([tangent.get(direction, 0.0) for direction in directions])
    return rows


def short_jacobian(outputs: Operands, inputs: Operands) -> Rows:
    """The same in fewer operations, by elimination of nodes.

    Graphs with blocks have it node by node. So have short graphs for which that takes less.
    """
    graph = _graph_of(outputs)
    if graph is None:
        return jacobian(outputs, inputs)
    if _has_blocks(graph, outputs):
        return jacobian(outputs, inputs)
    candidates: list[Rows] = []
    if len(graph.live(outputs)) <= LONGEST_BY_NODE:
        candidates.append(jacobian(outputs, inputs))
    candidates += [jacobian_by_elimination(graph, outputs, inputs, order) for order in ORDERS]
    return _shortest(graph, candidates)


def symmetric_matrix(function: Callable[[Scalars], list[Scalar]], scalars: Scalars) -> Rows:
    """The matrix of a linear function, which is symmetric, from one of its triangles.

    Args:
        function: from a vector (n,) to a vector (n,).
        scalars: n scalars of the kind that it computes with. On symbols, the matrix takes the
            fewest operations of some ways.
    """
    n = len(scalars)
    units = unit_vectors(n)
    graph = _graph_of(scalars)
    if graph is None:
        return mirrored([function(unit) for unit in units])
    values: list[Symbol] = [graph.input(PLACEHOLDER, k) for k in range(n)]
    images = function([*values])
    candidates: list[Rows] = []
    if n <= MOST_COLUMNS or _has_blocks(graph, images):
        candidates.append(mirrored([function(unit) for unit in units]))
    if not _has_blocks(graph, images):
        for order in ORDERS:
            rows = jacobian_by_elimination(graph, images, values, order)
            candidates += [mirrored(rows), mirrored(transposed(rows))]
    return _shortest(graph, candidates)


def _has_blocks(graph: Graph, outputs: Operands) -> bool:
    """Whether outputs depend on blocks; near singular places, elimination would lose digits."""
    return any(graph.nodes[index][0] == "block" for index in graph.live(outputs))


def _shortest(graph: Graph, candidates: Sequence[Rows]) -> Rows:
    """The matrix whose entries need the fewest nodes; of equal ones, the first."""
    return min(candidates, key=lambda rows: len(graph.live([*chain.from_iterable(rows)])))


def along(outputs: Operands, inputs: Operands, changes: Operands) -> list[Scalar]:
    """The changes of outputs for changes of inputs: their derivative in one direction.

    Args:
        outputs: symbols of one graph, or constants.
        inputs: input symbols of the same graph, or constants.
        changes: symbols of the same graph, one for each input.
    """
    seeds: dict[int, Tangent] = {}
    for x, change in zip(inputs, changes, strict=True):
        if isinstance(x, Symbol):
            seeds[x.index] = {0: change}
    tangents = _Tangents(outputs, seeds)
    return [tangents.of(y).get(0, 0.0) for y in outputs]


def substitute(outputs: Operands, replaced: Mapping[Operand, Scalar]) -> list[Scalar]:
    """The outputs with input symbols replaced; nodes that do not depend on them are shared."""
    values: dict[int, Scalar] = {}
    for symbol, value in replaced.items():
        if isinstance(symbol, Symbol):
            values[symbol.index] = value
    graph = _graph_of(outputs)
    if graph is None:
        return list(outputs)
    for index in graph.live(outputs):
        if graph.nodes[index][0] == "input":
            values.setdefault(index, Symbol(graph, index))
    return evaluate(graph, outputs, values)


def _graph_of(outputs: Operands) -> Graph | None:
    for y in outputs:
        if isinstance(y, Symbol):
            return y.graph
    return None


def evaluate(graph: Graph, outputs: Operands, inputs: Mapping[int, Scalar]) -> list[Scalar]:
    """Evaluate outputs over any scalars, from values of the live input nodes by index."""
    return _Evaluation(graph, outputs, inputs).values


class _Evaluation:
    """Evaluates a graph over scalars."""

    def __init__(self, graph: Graph, outputs: Operands, inputs: Mapping[int, Scalar]) -> None:
        self._graph = graph
        self._nodes = dict(inputs)
        self._blocks: dict[int, list[Scalar]] = {}
        for index in graph.live(outputs):
            if index not in self._nodes:
                self._nodes[index] = self._node(index)
        self.values = [self._operand(y) for y in outputs]

    def _operand(self, x: Operand | int) -> Scalar:
        if isinstance(x, Symbol):
            return self._nodes[x.index]
        if isinstance(x, int):
            return self._nodes[x]
        return x

    def _node(self, index: int) -> Scalar:
        op, a, b = self._graph.nodes[index]
        if op == "block":
            return self._block(int(a))[int(b)]
        first = self._operand(a)
        if op in _UNARY:
            return _UNARY[op](first)
        second = self._operand(b)
        return _BINARY[op](first, second)

    def _block(self, number: int) -> list[Scalar]:
        if number not in self._blocks:
            block = self._graph.blocks[number]
            arguments = [list(map(self._operand, vector)) for vector in block.arguments]
            if block.body is None:
                self._blocks[number] = invert(arguments[0], block.size)
            else:
                self._blocks[number] = newton(block.body, *arguments)
        return self._blocks[number]


class _Tangents:
    """Derivatives of every node that the outputs depend on."""

    def __init__(self, outputs: Operands, seeds: Mapping[int, Tangent]) -> None:
        self._nodes: dict[int, Tangent] = dict(seeds)
        self._blocks: dict[int, list[Tangent]] = {}
        self._graph = _graph_of(outputs) or Graph()
        for index in self._graph.live(outputs):
            if index not in self._nodes:
                self._nodes[index] = self._node(index)

    def of(self, x: Operand | int) -> Tangent:
        """Derivatives of a node, by symbol or index, or of a constant."""
        if isinstance(x, Symbol):
            return self._nodes[x.index]
        if isinstance(x, int):
            return self._nodes[x]
        return {}

    def _node(self, index: int) -> Tangent:
        op, a, b = self._graph.nodes[index]
        if op == "input":
            return {}
        if op == "block":
            return self._block(int(a))[int(b)]
        changes = self.of(a), self.of(b)
        if not any(changes):
            return {}
        return _combine(slopes_of(self._graph, index), changes)

    def _block(self, number: int) -> list[Tangent]:
        if number not in self._blocks:
            block = self._graph.blocks[number]
            changes = [list(map(self.of, vector)) for vector in block.arguments]
            outputs = [self._graph.output(number, k) for k in range(block.outputs)]
            if block.body is None:
                tangents = _inverse_tangents(block.size, outputs, changes[0])
            else:
                solution = outputs[: block.size]
                tangents = _newton_tangents(block, solution, changes[1])
            self._blocks[number] = tangents
        return self._blocks[number]


def _directions(changes: Sequence[Tangent]) -> set[int]:
    """Directions in which any of the tangents is not zero."""
    return set(chain.from_iterable(changes))


def _combine(slopes: Operands, changes: Sequence[Tangent]) -> Tangent:
    """Sum of slope times change, direction by direction."""
    total: dict[int, Scalar] = {}
    for slope, change in zip(slopes, changes, strict=True):
        for direction, value in change.items():
            part = slope * value
            if direction in total:
                part = total[direction] + part
            total[direction] = part
    return {k: value for k, value in total.items() if not _is_zero(value)}


def _is_zero(value: Scalar) -> bool:
    return not isinstance(value, Symbol) and value == 0.0


def _inverse_tangents(size: int, outputs: Operands, changes: Sequence[Tangent]) -> list[Tangent]:
    """d(A^-1) = -A^-1 dA A^-1."""
    inverse = _rows(outputs, size)
    result: list[Tangent] = [{} for _ in outputs]
    for direction in _directions(changes):
        slope = [change.get(direction, 0.0) for change in changes]
        relative = _product(inverse, _rows(slope, size))
        product = _product(relative, inverse)
        for k, entry in enumerate(chain.from_iterable(product)):
            result[k][direction] = -entry
    return result


def _product(a: Rows, b: Rows) -> Rows:
    columns = list(zip(*b, strict=True))
    return [_dots(row, columns) for row in a]


def _dots(row: Operands, columns: Sequence[Operands]) -> list[Scalar]:
    return [_dot(row, column) for column in columns]


def _dot(a: Operands, b: Operands) -> Scalar:
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def _newton_tangents(block: Block, solution: Operands, changes: Sequence[Tangent]) -> list[Tangent]:
    """Tangents of the outputs of a Newton block.

    Outputs are the solution and the number of iterations, whose tangent is zero.
    """
    result: list[Tangent] = [{} for _ in range(block.outputs)]
    moving = [k for k, change in enumerate(changes) if change]
    if not moving:
        return result
    partials, slopes = _partials(block, solution, moving)
    inverse = Inverse(partials)
    moves = [changes[k] for k in moving]
    pushes = [_combine(row, moves) for row in slopes]
    for direction in _directions(pushes):
        residuals = [-push.get(direction, 0.0) for push in pushes]
        for k, value in enumerate(inverse.solve(residuals)):
            result[k][direction] = value
    return result


def _partials(block: Block, solution: Operands, moving: Sequence[int]) -> tuple[Rows, Rows]:
    """d phi/dx, and d phi/dp of the moving parameters, at the solution."""
    assert block.body is not None  # noqa: S101  only equations have partials
    size, given = block.size, block.arguments[1]
    graph = Graph()  # graph of the equations only, with the solution as an input
    unknowns = [graph.input(0, k) for k in range(size)]
    parameters = [graph.input(1, k) for k in range(len(given))]
    values = block.body(unknowns, parameters)
    residuals, partials = values[:size], values[size:]
    moving_parameters = [parameters[k] for k in moving]
    slopes = jacobian(residuals, moving_parameters)
    symbols = [*unknowns, *parameters]
    at_solution = zip(symbols, [*solution, *given], strict=True)
    inputs = {symbol.index: value for symbol, value in at_solution}
    outputs = [*partials, *chain.from_iterable(slopes)]
    flat = evaluate(graph, outputs, inputs)
    count = len(partials)
    return _rows(flat[:count], size), _rows(flat[count:], len(moving))


def _rows(flat: Operands, width: int) -> Rows:
    starts = range(0, len(flat), width)
    return [list(flat[start : start + width]) for start in starts]
