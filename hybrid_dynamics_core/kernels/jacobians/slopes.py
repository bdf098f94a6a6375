"""Derivatives of single nodes with respect to their operands."""

from __future__ import annotations

from collections.abc import Mapping

from ...algebra.scalar import Scalar, cos, sin
from ..graph import Graph, Operand, Symbol

# constant slopes
_CONSTANT: Mapping[str, tuple[float, float]] = {
    "add": (1.0, 1.0),
    "sub": (1.0, -1.0),
    "neg": (-1.0, 0.0),
    "rint": (0.0, 0.0),
}


def slopes_of(graph: Graph, index: int) -> tuple[Operand, Operand]:
    """Derivatives of a node with respect to its two operands, as further nodes or constants."""
    op, first, second = graph.nodes[index]
    if op in _CONSTANT:
        return _CONSTANT[op]
    a, b = _value(graph, first), _value(graph, second)
    if op == "mul":
        return b, a
    result = Symbol(graph, index)
    if op == "div":
        return 1.0 / b, -result / b
    if op == "atan2":
        size = a * a + b * b
        return b / size, -a / size
    return _slope(op, a, result), 0.0


def _value(graph: Graph, x: int | float) -> Scalar:
    return Symbol(graph, x) if isinstance(x, int) else x


def _slope(op: str, a: Scalar, result: Symbol) -> Scalar:
    """Derivative of a unary operation."""
    if op == "sqrt":
        return 0.5 / result
    if op == "abs":
        return a / result
    both = {"sin": cos(a), "cos": -sin(a)}  # both are nodes: one often needs the other
    return both[op]
