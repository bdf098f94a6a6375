"""CasADi expressions of a trace.

Straight parts are SX expressions. Newton's iteration is a rootfinder between them, which CasADi
differentiates by the implicit function theorem.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi

from ...algebra.numerics import MAX_ITERATIONS
from ..graph import Operand, Symbol
from ..trace import Check, Trace, trace_body

Expression = Any  # SX, MX or Function; CasADi has no types
_UNARY: Mapping[str, Callable[[Expression], Expression]] = {
    "neg": lambda a: -a,
    "sin": casadi.sin,
    "cos": casadi.cos,
    "sqrt": casadi.sqrt,
    "abs": casadi.fabs,
    "rint": lambda a: casadi.floor(a + 0.5),
}
_BINARY: Mapping[str, Callable[[Expression, Expression], Expression]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "atan2": casadi.atan2,
}
_CONVERGED = 1e-10  # residual in lengths of the loop, above rounding
_ITERATION = {"error_on_fail": False, "max_iter": MAX_ITERATIONS, "abstol": 1e-14}


def function(
    trace: Trace,
    name: str,
    names: Sequence[str],
    constants: Mapping[str, Sequence[float]],
) -> Expression:
    """A CasADi Function of a trace.

    Args:
        trace: the traced program.
        name: of the Function.
        names: of the input vectors, in order. Those with constants are no inputs of the Function.
        constants: values of some inputs.

    Returns:
        The Function: free inputs -> results by name, matrices in their shapes, and `status`, the
        code of the first check that fails.
    """
    free = [k for k, key in enumerate(names) if key not in constants]
    sizes = [trace.inputs[k] for k in free]
    inputs = [casadi.MX.sym(names[k], size) for k, size in zip(free, sizes, strict=True)]
    stages = _Stages(trace, names, constants)
    results = stages.run(inputs)
    titles = [*[key for key, _ in trace.layout], "status"]
    return casadi.Function(name, inputs, results, [names[k] for k in free], titles)


class _Stages:
    """The straight parts of a trace between its blocks.

    Attributes:
        inputs: symbols of the free inputs.
    """

    def __init__(
        self, trace: Trace, names: Sequence[str], constants: Mapping[str, Sequence[float]]
    ) -> None:
        self._trace = trace
        self.inputs: list[Expression] = []
        self._outputs: dict[int, Expression] = {}  # symbols of results of blocks
        self._vectors: list[Expression] = []  # by number of the input
        for key, size in zip(names, trace.inputs, strict=True):
            if key in constants:
                self._vectors.append(casadi.DM(list(constants[key])))
            else:
                self.inputs.append(casadi.SX.sym(key, size))
                self._vectors.append(self.inputs[-1])
        self._nodes: dict[int, Expression] = {}

    def run(self, inputs: list[Expression]) -> list[Expression]:
        """Results (MX) from free inputs (MX)."""
        solved: list[Expression] = []
        for number in self._trace.live_blocks():
            block = self._trace.graph.blocks[number]
            arguments = [self._vector(vector) for vector in block.arguments]
            given = self._stage(f"before_{number}", arguments)(*inputs, *solved)
            given = given if isinstance(given, (list, tuple)) else [given]
            self._outputs[number] = casadi.SX.sym(f"b{number}", block.outputs)
            if block.body is None:
                solved.append(_inverted(given[0], block.size))
            else:
                body = trace_body(self._trace, number)
                solved.append(_solved(body, block.size, *given))
        return list(self._stage("results", self._results())(*inputs, *solved))

    def _stage(self, name: str, results: Sequence[Expression]) -> Expression:
        symbols = [*self.inputs, *self._outputs.values()]
        return casadi.Function(name, symbols, list(results))

    def _results(self) -> list[Expression]:
        results = []
        first = 0
        flat = self._trace.outputs
        for _, shape in self._trace.layout:
            rows, columns = (*shape, 1, 1)[:2]
            last = first + rows * columns
            vector = self._vector(flat[first:last])
            results.append(casadi.reshape(vector, columns, rows).T)  # from row by row
            first = last
        status: Expression = casadi.SX(0)
        for check in reversed(self._trace.checks):  # the first failed check decides
            status = self._decided(check, status)
        return [*results, status]

    def _decided(self, check: Check, status: Expression) -> Expression:
        passes = self.value(check.value) > check.threshold
        return casadi.if_else(passes, status, check.code)

    def _vector(self, operands: Sequence[Operand]) -> Expression:
        return casadi.vertcat(casadi.SX(0, 1), *[self.value(x) for x in operands])

    def value(self, x: Operand) -> Expression:
        """The expression of an operand."""
        if not isinstance(x, Symbol):
            return casadi.SX(float(x))
        for index in self._trace.graph.live([x]):
            if index not in self._nodes:
                self._nodes[index] = self._node(index)
        return self._nodes[x.index]

    def _node(self, index: int) -> Expression:
        op, a, b = self._trace.graph.nodes[index]
        if op == "input":
            return self._vectors[int(a)][int(b)]
        if op == "block":
            return self._outputs[int(a)][int(b)]
        first = self._nodes[a] if isinstance(a, int) else a
        if op in _UNARY:
            return _UNARY[op](first)
        return _BINARY[op](first, self._nodes[b] if isinstance(b, int) else b)


def _inverted(entries: Expression, size: int) -> Expression:
    """The inverse row by row, then the determinant."""
    matrix = casadi.reshape(entries, size, size).T
    inverse = casadi.inv(matrix)
    return casadi.vertcat(casadi.vec(inverse.T), casadi.det(matrix))


def _solved(body: Trace, size: int, guess: Expression, parameters: Expression) -> Expression:
    """Solution of a Newton block; then 1, or -1 if the iteration failed."""
    straight = _Stages(body, ("x", "p"), {})
    values = casadi.vertcat(*[straight.value(x) for x in body.outputs])
    residuals, partials = values[:size], casadi.reshape(values[size:], size, size).T
    step = casadi.solve(partials, residuals)
    equations = casadi.Function("equations", straight.inputs, [residuals])
    newton_step = casadi.Function("step", straight.inputs, [step])
    solve = casadi.rootfinder("solve", "newton", equations, _ITERATION)
    near = solve(guess, parameters)
    solution = near - newton_step(near, parameters)  # the rootfinder stops at 1e-6
    largest = casadi.norm_inf(equations(solution, parameters))
    return casadi.vertcat(solution, casadi.if_else(largest < _CONVERGED, 1.0, -1.0))
