"""Numbers written as expressions over `parameters:`; parsed here, never run as code."""

from __future__ import annotations

import ast
import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence

from ..algebra.live import is_live
from ..algebra.scalar import absolute, atan2, cos, sin, sqrt
from ..ground.decimal_commas import POINT_HINT, with_point
from ..ground.quantities import ANGLE, PLAIN, UNITS, Dimension, Quantity, described, mismatch
from ..ground.suggestions import did_you_mean, suggestion
from ..ground.wording import counted

MAX_LENGTH = 200
FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {  # (number of arguments, function)
    "sqrt": (1, math.sqrt),
    "abs": (1, abs),
    "sin": (1, math.sin),
    "cos": (1, math.cos),
    "tan": (1, math.tan),
    "asin": (1, math.asin),
    "acos": (1, math.acos),
    "atan2": (2, math.atan2),
}
_LIVE_FUNCTIONS: dict[str, Callable[..., float]] = {  # of arguments of programs
    "sqrt": sqrt,
    "abs": absolute,
    "sin": sin,
    "cos": cos,
    "tan": lambda x: sin(x) / cos(x),
    "atan2": atan2,
    "asin": lambda x: atan2(x, sqrt(1.0 - x * x)),
    "acos": lambda x: atan2(sqrt(1.0 - x * x), x),
}
_UNIT_HINT = "units are factors, as 65*mm, 200*bar, 3*kN*m, 30*deg"
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_WITH_UNIT = re.compile(  # 18 kg, 70mm, 3 lb
    rf"^\s*[-+]?{_NUMBER}\s*(µm|\"|°|[a-zA-Z]+([ *]?[a-zA-Z]+)?(\^|\*\*)?[2²]?)\s*$"
)
_LONGEST_FIRST = "|".join(sorted([*UNITS, "pi"], key=len, reverse=True))
_NO_SIGN = re.compile(rf"(?<![\w.])({_NUMBER})\s*({_LONGEST_FIRST})\b")  # 60deg, 2 pi, 70 mm
_SQUARE = re.compile(r"\b([a-zA-Z]+)(?:\^|\*\*)?2\b")  # m^2, m2
_SIGNED_SQUARE = re.compile(r"([*/])\s*([a-zA-Z]+)(?:\^|\*\*)2\b")  # /s^2
_APART = re.compile(rf"\b({_LONGEST_FIRST})\s+({_LONGEST_FIRST})\b")  # N m


class _NotAllowedError(ValueError):
    """An expression has syntax that is not allowed."""


def evaluate(
    text: str,
    names: Mapping[str, float],
    names_are: str = "parameters",
    units: Sequence[str] = (),
) -> float:
    """Value of an arithmetic expression.

    It may have numbers, names, pi, units, + - * /, parentheses and functions. Units are factors:
    30*deg is an angle in radians, and 200*bar a pressure in pascals. A name in `names` takes
    precedence over a unit of the same name.

    Args:
        text: the expression.
        names: values of the names that it may use, in SI units.
        names_are: noun for these names in messages; "" if only pi and units are allowed.
        units: the allowed units, such as `N m`; empty if any unit is allowed. They are checked only
            if the expression has units.

    Raises:
        ValueError: it has no value, or a wrong unit. The message is a clause.
        OverflowError: the value is too large.
    """
    if len(text) > MAX_LENGTH:
        raise ValueError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)  # of 0if, say
            tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(_no_expression(text, names_are)) from None
    point = with_point(text)
    if point:
        raise ValueError(f"'{text}' is no number{POINT_HINT}{did_you_mean(point)}")
    try:
        quantity = _Evaluation(text, names, names_are).summand(tree.body)
    except ZeroDivisionError:
        raise ValueError(f"'{text}' divides by zero") from None
    except _NotAllowedError:
        terms = ", ".join(filter(None, ("numbers", names_are, "pi", "units")))
        allowed = f"{terms}, + - * /, parentheses and {', '.join(FUNCTIONS)}"
        hint = _power_hint(text)
        raise ValueError(f"'{text}' has something else than {allowed}{hint}") from None
    problem = mismatch(quantity.dimension, units)
    if problem:
        raise ValueError(f"'{text}' {problem}")
    return quantity.value


def _no_expression(text: str, names_are: str) -> str:
    """The message for a text that cannot be parsed, with a suggestion."""
    stripped = text.strip()
    with_signs = _with_factors(stripped)
    hint = ""
    if with_signs != stripped:
        hint = did_you_mean(with_signs)
    elif _WITH_UNIT.match(text):
        return f"'{text}' has a unit that is not known here; {_UNIT_HINT}"
    terms = "numbers, pi and units"
    if names_are:
        terms = f"numbers, {names_are} and units"
    return f"'{text}' is neither a number nor an expression (+ - * / over {terms}){hint}"


def _power_hint(text: str) -> str:
    """What to write in place of a square: 3*rad/s^2 is 3*rad/s/s."""
    squares = _SIGNED_SQUARE.sub(r"\1\2\1\2", text)
    if squares == text:
        return ""
    return did_you_mean(squares)


def _with_factors(text: str) -> str:
    """The text with its units as factors: 0.5 kg m^2 becomes 0.5*kg*m*m."""
    plain = text.replace("°", "deg").replace("²", "^2")
    squares = _SQUARE.sub(r"\1*\1", plain)
    return _APART.sub(r"\1*\2", _NO_SIGN.sub(r"\1*\2", squares))


class _Evaluation:
    """Walks the tree of one expression."""

    def __init__(self, text: str, names: Mapping[str, float], names_are: str) -> None:
        self.text = text
        self.names = names
        self.names_are = names_are

    def value(self, node: ast.expr) -> Quantity:
        if isinstance(node, ast.Constant):
            return Quantity(_literal(node.value))
        if isinstance(node, ast.Name):
            return self.named(node.id)
        if isinstance(node, ast.UnaryOp):
            return self.signed(node)
        if isinstance(node, ast.BinOp):
            return self.combined(node)
        if isinstance(node, ast.Call):
            return self.called(node)
        raise _NotAllowedError

    def summand(self, node: ast.expr) -> Quantity:
        """A term of a sum, which must not be a bare unit."""
        quantity = self.value(node)
        if quantity.has_number:
            return quantity
        part = ast.unparse(node).replace(" ", "")
        existing = ""
        if self.names_are:
            existing = f", and none of the {self.names_are} ({', '.join(self.names) or 'none'})"
        raise ValueError(f"'{part}' is a unit without a number{existing}; write 1*{part}")

    def signed(self, node: ast.UnaryOp) -> Quantity:
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise _NotAllowedError
        quantity = self.value(node.operand)
        if isinstance(node.op, ast.USub):
            return quantity._replace(dividend=-quantity.dividend)
        return quantity

    def combined(self, node: ast.BinOp) -> Quantity:
        if isinstance(node.op, ast.Mult):
            return self.value(node.left).times(self.value(node.right))
        if isinstance(node.op, ast.Div):
            return self.value(node.left).divided_by(self.value(node.right))
        if not isinstance(node.op, (ast.Add, ast.Sub)):
            raise _NotAllowedError
        left = self.summand(node.left)
        right = self.summand(node.right)
        dimension = self.common_dimension([left, right])
        if isinstance(node.op, ast.Add):
            return Quantity(left.value + right.value, dimension)
        return Quantity(left.value - right.value, dimension)

    def common_dimension(self, parts: Sequence[Quantity]) -> Dimension | None:
        """The common dimension of quantities; those without a dimension are ignored."""
        written = {part.dimension for part in parts} - {None, PLAIN}
        if len(written) > 1:
            words = " and ".join(sorted(map(described, filter(None, written))))
            raise ValueError(f"'{self.text}' puts {words} together, which do not go together")
        if written:
            return written.pop()
        if any(part.dimension is None for part in parts):
            return None
        return PLAIN

    def called(self, node: ast.Call) -> Quantity:
        if not isinstance(node.func, ast.Name) or node.keywords:
            raise _NotAllowedError
        name = node.func.id
        if name not in FUNCTIONS:
            raise _NotAllowedError
        count, function = FUNCTIONS[name]
        if len(node.args) != count:
            raise ValueError(f"{name}() takes {counted(count, 'value')}")
        arguments = [self.summand(argument) for argument in node.args]
        dimension = self.result_dimension(name, arguments)
        values = [argument.value for argument in arguments]
        if is_live(values):
            return Quantity(_LIVE_FUNCTIONS[name](*values), dimension)
        try:
            return Quantity(function(*values), dimension)
        except ValueError:
            listed = ", ".join(f"{value:g}" for value in values)
            raise ValueError(f"{name}({listed}) has no value") from None

    def result_dimension(self, name: str, arguments: Sequence[Quantity]) -> Dimension | None:
        """The dimension of a function's result."""
        dimension = self.common_dimension(arguments)
        if name == "abs":
            return dimension
        if name == "sqrt":
            return self.root_dimension(dimension)
        if name != "atan2" and dimension not in (None, PLAIN, ANGLE):
            raise ValueError(
                f"{name}() of '{self.text}' is of {described(dimension)}; expected an angle or a"
                " number without a unit"
            )
        return PLAIN

    def root_dimension(self, dimension: Dimension | None) -> Dimension | None:
        if dimension is None:
            return None
        if any(power % 2 for power in dimension):
            raise ValueError(f"sqrt() of '{self.text}' is of {described(dimension)}, no square")
        m, kg, s, rad = (power // 2 for power in dimension)
        return m, kg, s, rad

    def named(self, name: str) -> Quantity:
        if name == "pi":
            return Quantity(math.pi)
        if name in self.names:
            return Quantity(self.names[name], None)
        if name in UNITS:
            return UNITS[name]
        hint = suggestion(name, [*self.names, *UNITS])
        if not self.names_are:
            raise ValueError(f"'{name}' is not a number, pi or a unit{hint}")
        existing = ", ".join(self.names) or "none"
        raise ValueError(
            f"'{name}' is not one of the {self.names_are} ({existing}) and no unit{hint}"
        )


def _literal(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise _NotAllowedError
    return float(value)
