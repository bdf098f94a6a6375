"""Numbers in a description may be written as expressions over `parameters:`; parsed here, never run as code."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping

from ..ground.decimal_commas import POINT_HINT, with_point
from ..ground.suggestions import did_you_mean, suggestion
from ..ground.wording import counted

_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
MAX_LENGTH = 200
_UNIT = re.compile(  # 18 kg, 70mm
    r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*"
    r"(t|kg|g|lbs?|km|m|dm|cm|mm|um|µm|in|inch|ft|\"|k?N|k?N[ *]?m|s|ms|rad|grad|°|kg["
    r" *]?m(\^|\*\*)?[2²])\s*$"
)
UNITS = "units are fixed: m, kg, s, N, rad (30*deg)"
_NO_SIGN = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)\s*(deg|pi)\b")  # 60deg, 2 pi


class _NotAllowedError(ValueError):
    """Something in an expression that no number needs."""


def evaluate(text: str, names: Mapping[str, float], known: str = "parameters") -> float:
    """Value of an arithmetic expression: numbers, names, pi, deg (pi/180), + - * /, parentheses, functions.

    known: what `names` are, for messages; "" where there are none but pi and deg.

    Raises ValueError with a reason that reads as the end of a sentence.
    """
    if len(text) > MAX_LENGTH:
        raise ValueError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        whole = _NO_SIGN.sub(r"\1*\2", text.strip())
        hint = did_you_mean(whole) if whole != text.strip() else ""
        unit = _UNIT.match(text) if not hint else None
        if unit:
            raise ValueError(
                f"'{text}' has a unit; {UNITS}: write the number alone, in these"
            ) from None
        over = f"numbers and {known}" if known else "numbers, pi and deg"
        raise ValueError(
            f"'{text}' is neither a number nor an expression (+ - * / over {over}){hint}"
        ) from None
    point = with_point(text)
    if point:
        raise ValueError(f"'{text}' is no number{POINT_HINT}{did_you_mean(point)}")
    try:
        return _value(tree.body, names, known)
    except ZeroDivisionError:
        raise ValueError(f"'{text}' divides by zero") from None
    except _NotAllowedError:
        words = ", ".join(word for word in ("numbers", known, "pi", "deg") if word)
        allowed = f"{words}, + - * /, parentheses and {', '.join(FUNCTIONS)}"
        raise ValueError(f"'{text}' has something else than {allowed}") from None


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


def _value(node: ast.expr, names: Mapping[str, float], known: str) -> float:
    if (
        isinstance(node, ast.Constant)
        and isinstance(node.value, (int, float))
        and not isinstance(node.value, bool)
    ):
        return float(node.value)
    if isinstance(node, ast.Name):
        return _named(node.id, names, known)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        value = _value(node.operand, names, known)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return _BINARY[type(node.op)](
            _value(node.left, names, known), _value(node.right, names, known)
        )
    if isinstance(node, ast.Call):
        return _called(node, names, known)
    raise _NotAllowedError


def _called(node: ast.Call, names: Mapping[str, float], known: str) -> float:
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    if name not in FUNCTIONS or node.keywords:
        raise _NotAllowedError
    count, function = FUNCTIONS[name]
    if len(node.args) != count:
        raise ValueError(f"{name}() takes {counted(count, 'value')}")
    values = [_value(argument, names, known) for argument in node.args]
    try:
        return function(*values)
    except ValueError:
        raise ValueError(f"{name}({', '.join(f'{v:g}' for v in values)}) has no value") from None


def _named(name: str, names: Mapping[str, float], known: str) -> float:
    if name == "pi":
        return math.pi
    if name == "deg" and name not in names:  # a file may have a parameter of this name
        return math.pi / 180.0
    if name not in names:
        if not known:
            raise ValueError(f"'{name}' is not a number, pi or deg")
        hint = suggestion(name, names)
        raise ValueError(f"'{name}' is not one of the {known} ({', '.join(names) or 'none'}){hint}")
    return names[name]
