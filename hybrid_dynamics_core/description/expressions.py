"""Numbers written as expressions over `parameters:`; parsed here, never run as code."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping

from ..ground.decimal_commas import POINT_HINT, with_point
from ..ground.suggestions import did_you_mean, suggestion
from ..ground.wording import counted

MAX_LENGTH = 200
FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {  # name: number of arguments, function
    "sqrt": (1, math.sqrt),
    "abs": (1, abs),
    "sin": (1, math.sin),
    "cos": (1, math.cos),
    "tan": (1, math.tan),
    "asin": (1, math.asin),
    "acos": (1, math.acos),
    "atan2": (2, math.atan2),
}
_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_UNIT_HINT = "units are fixed: m, kg, s, N, rad (30*deg)"
_WITH_UNIT = re.compile(  # 18 kg, 70mm
    r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*"
    r"(t|kg|g|lbs?|km|m|dm|cm|mm|um|µm|in|inch|ft|\"|k?N|k?N[ *]?m|s|ms|rad|grad|°|kg["
    r" *]?m(\^|\*\*)?[2²])\s*$"
)
_NO_SIGN = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)\s*(deg|pi)\b")  # 60deg, 2 pi


class _NotAllowedError(ValueError):
    """Something in an expression that no number needs."""


def evaluate(text: str, names: Mapping[str, float], names_are: str = "parameters") -> float:
    """Value of an arithmetic expression: numbers, names, pi, deg, + - * /, parentheses, functions.

    `deg` is pi/180, so that 30*deg is an angle in radians.

    Args:
        text: the expression.
        names: values of the names that it may use.
        names_are: what these are, for messages; "" where there are none but pi and deg.

    Raises:
        ValueError: it has no value; the message reads as the end of a sentence.
        OverflowError: the value is too large.
    """
    if len(text) > MAX_LENGTH:
        raise ValueError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(_no_expression(text, names_are)) from None
    point = with_point(text)
    if point:
        raise ValueError(f"'{text}' is no number{POINT_HINT}{did_you_mean(point)}")
    try:
        return _Evaluation(names, names_are).value(tree.body)
    except ZeroDivisionError:
        raise ValueError(f"'{text}' divides by zero") from None
    except _NotAllowedError:
        terms = ", ".join(filter(None, ("numbers", names_are, "pi", "deg")))
        allowed = f"{terms}, + - * /, parentheses and {', '.join(FUNCTIONS)}"
        raise ValueError(f"'{text}' has something else than {allowed}") from None


def _no_expression(text: str, names_are: str) -> str:
    """The message for a text that cannot be parsed, with what may have been meant."""
    stripped = text.strip()
    with_signs = _NO_SIGN.sub(r"\1*\2", stripped)
    hint = ""
    if with_signs != stripped:
        hint = did_you_mean(with_signs)
    elif _WITH_UNIT.match(text):
        return f"'{text}' has a unit; {_UNIT_HINT}: write the number alone, in these"
    terms = "numbers, pi and deg"
    if names_are:
        terms = f"numbers and {names_are}"
    return f"'{text}' is neither a number nor an expression (+ - * / over {terms}){hint}"


class _Evaluation:
    """Walks the tree of one expression."""

    def __init__(self, names: Mapping[str, float], names_are: str) -> None:
        self.names = names
        self.names_are = names_are

    def value(self, node: ast.expr) -> float:
        if isinstance(node, ast.Constant):
            return _literal(node.value)
        if isinstance(node, ast.Name):
            return self.named(node.id)
        if isinstance(node, ast.UnaryOp):
            return self.signed(node)
        if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            operate = _BINARY[type(node.op)]
            operands = (self.value(node.left), self.value(node.right))
            return operate(*operands)
        if isinstance(node, ast.Call):
            return self.called(node)
        raise _NotAllowedError

    def signed(self, node: ast.UnaryOp) -> float:
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise _NotAllowedError
        value = self.value(node.operand)
        if isinstance(node.op, ast.USub):
            return -value
        return value

    def called(self, node: ast.Call) -> float:
        if not isinstance(node.func, ast.Name) or node.keywords:
            raise _NotAllowedError
        name = node.func.id
        if name not in FUNCTIONS:
            raise _NotAllowedError
        count, function = FUNCTIONS[name]
        if len(node.args) != count:
            raise ValueError(f"{name}() takes {counted(count, 'value')}")
        arguments = [self.value(argument) for argument in node.args]
        try:
            return function(*arguments)
        except ValueError:
            listed = ", ".join(f"{argument:g}" for argument in arguments)
            raise ValueError(f"{name}({listed}) has no value") from None

    def named(self, name: str) -> float:
        if name == "pi":
            return math.pi
        if name in self.names:
            return self.names[name]
        if name == "deg":  # unless a file has a parameter of this name
            return math.pi / 180.0
        if not self.names_are:
            raise ValueError(f"'{name}' is not a number, pi or deg")
        existing = ", ".join(self.names) or "none"
        hint = suggestion(name, self.names)
        raise ValueError(f"'{name}' is not one of the {self.names_are} ({existing}){hint}")


def _literal(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise _NotAllowedError
    return float(value)
