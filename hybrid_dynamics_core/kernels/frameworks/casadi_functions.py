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
_CONVERGED = 1e-10  # largest residual of a closed loop, over its lengths; well above rounding
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
        name: name of the Function.
        names: names of the input vectors, in order.
        constants: values of some inputs, which are no inputs of the Function.

    Returns:
        The Function: free inputs -> results by name in their shapes, and `status`. This is the code
        of the first check that fails.
    """
    inputs: list[Expression] = []
    free_names: list[str] = []
    for key, size in zip(names, trace.inputs, strict=True):
        if key not in constants:
            inputs.append(casadi.MX.sym(key, size))
            free_names.append(key)
    results = _Stages(trace, names, constants).run(inputs)
    result_names = [key for key, _ in trace.layout]
    return casadi.Function(name, inputs, results, free_names, [*result_names, "status"])


class _Stages:
    """The straight parts of a trace, between its blocks, as SX expressions.

    Attributes:
        inputs: SX symbols of the free inputs.
    """

    def __init__(
        self, trace: Trace, names: Sequence[str], constants: Mapping[str, Sequence[float]]
    ) -> None:
        self._trace = trace
        self.inputs: list[Expression] = []
        self._outputs: dict[int, Expression] = {}  # symbols of the results of blocks, by block
        self._vectors: list[Expression] = []  # symbols or constants of all inputs
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
            if not isinstance(given, (list, tuple)):  # CasADi returns a single result by itself
                given = [given]
            self._outputs[number] = casadi.SX.sym(f"b{number}", block.outputs)
            if block.body is None:
                solved.append(_inverted(given[0], block.size))
            else:
                body = trace_body(self._trace, number)
                solved.append(_solved(body, block.size, *given))
        return list(self._stage("results", self._results())(*inputs, *solved))

    def _stage(self, name: str, results: Sequence[Expression]) -> Expression:
        """A Function of the free inputs and of the results of blocks so far."""
        symbols = [*self.inputs, *self._outputs.values()]
        return casadi.Function(name, symbols, list(results))

    def _results(self) -> list[Expression]:
        """The results in their shapes, and the status."""
        results = []
        first = 0
        flat = self._trace.outputs
        for _, shape in self._trace.layout:
            rows, columns = (*shape, 1, 1)[:2]  # a vector is a column
            last = first + rows * columns
            vector = self._vector(flat[first:last])
            results.append(casadi.reshape(vector, columns, rows).T)  # CasADi goes by columns
            first = last
        status: Expression = casadi.SX(0)
        for check in reversed(self._trace.checks):  # the first failed check decides
            status = self._decided(check, status)
        return [*results, status]

    def _decided(self, check: Check, status: Expression) -> Expression:
        """The status of a check that fails, else that of those after it."""
        passes = self.value(check.value) > check.threshold
        return casadi.if_else(passes, status, check.code)

    def _vector(self, operands: Sequence[Operand]) -> Expression:
        """A column of operands; the empty SX makes it one even if there are none."""
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
        """The expression of a node whose operands have one."""
        op, a, b = self._trace.graph.nodes[index]
        if op == "input":
            return self._vectors[int(a)][int(b)]
        if op == "block":
            return self._outputs[int(a)][int(b)]
        first = self._operand(a)
        if op in _UNARY:
            return _UNARY[op](first)
        return _BINARY[op](first, self._operand(b))

    def _operand(self, x: int | float) -> Expression:
        """The expression of a node, or a constant."""
        return self._nodes[x] if isinstance(x, int) else x


def _inverted(entries: Expression, size: int) -> Expression:
    """The inverse of a matrix row by row (size * size)."""
    matrix = casadi.reshape(entries, size, size).T
    inverse = casadi.inv(matrix)
    return casadi.vec(inverse.T)


def _solved(body: Trace, size: int, guess: Expression, parameters: Expression) -> Expression:
    """Solution of a Newton block, then 1, or -1 if the iteration failed (size + 1).

    Args:
        body: trace of its residuals, and of their derivatives by the unknowns row by row.
        size: number of unknowns.
        guess: start of the iteration (size).
        parameters: parameters of the equations.
    """
    straight = _Stages(body, ("x", "p"), {})
    values = casadi.vertcat(*[straight.value(x) for x in body.outputs])
    residuals = values[:size]
    jacobian = casadi.reshape(values[size:], size, size).T
    step = casadi.solve(jacobian, residuals)
    equations = casadi.Function("equations", straight.inputs, [residuals])
    newton_step = casadi.Function("step", straight.inputs, [step])
    solve = casadi.rootfinder("solve", "newton", equations, _ITERATION)
    near = solve(guess, parameters)
    solution = near - newton_step(near, parameters)  # the rootfinder stops at steps of 1e-6
    largest = casadi.norm_inf(equations(solution, parameters))
    converged = casadi.if_else(largest < _CONVERGED, 1.0, -1.0)
    return casadi.vertcat(solution, converged)
