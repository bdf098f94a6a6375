"""Numbers in a description may be written as expressions over `parameters:`; parsed here, never run as code."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping

_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
MAX_LENGTH = 200


def evaluate(text: str, names: Mapping[str, float]) -> float:
    """Value of an arithmetic expression: numbers, names, pi, + - * /, parentheses, sqrt(), sin(), cos().

    Raises ValueError with a reason that reads as the end of a sentence.
    """
    if len(text) > MAX_LENGTH:
        raise ValueError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(
            f"'{text}' is neither a number nor an expression (+ - * / over numbers and parameters)"
        ) from None
    try:
        value = _value(tree.body, names)
    except ZeroDivisionError:
        raise ValueError(f"'{text}' divides by zero") from None
    if not math.isfinite(value):
        raise ValueError(f"'{text}' is not finite")
    return value


_FUNCTIONS: dict[str, Callable[[float], float]] = {"sqrt": math.sqrt, "sin": math.sin, "cos": math.cos}


def _value(node: ast.expr, names: Mapping[str, float]) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return float(node.value)
    if isinstance(node, ast.Name):
        return _named(node.id, names)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        value = _value(node.operand, names)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return _BINARY[type(node.op)](_value(node.left, names), _value(node.right, names))
    if (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in _FUNCTIONS
        and len(node.args) == 1
    ):
        return _FUNCTIONS[node.func.id](_value(node.args[0], names))
    raise ValueError("only numbers, parameters, pi, + - * /, parentheses, sqrt(), sin() and cos() are allowed")


def _named(name: str, names: Mapping[str, float]) -> float:
    if name == "pi":
        return math.pi
    if name not in names:
        known = ", ".join(names) or "none"
        raise ValueError(f"'{name}' is not one of the parameters ({known})")
    return names[name]
