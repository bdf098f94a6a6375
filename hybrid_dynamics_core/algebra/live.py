"""Numbers that are arguments of programs: a value, and a symbol that stands for it.

A constant of a description that depends on free parameters is a `Live` number. Conditions on it,
which decide the structure of a model, are those of its value. It is never a structural zero, so no
term with it is left out. `bound` puts symbols of a program in place of all live numbers.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from ..ground.arrays import Array
from .scalar import Scalar

T = TypeVar("T")

_BINDING = "symbols of live numbers"  # key in the memo of a copy


class Live:
    """A number with its value now, and the symbol that it is computed from.

    Attributes:
        value: its value now.
        symbol: the symbol, of a graph of the free parameters.
    """

    def __init__(self, value: float, symbol: Scalar) -> None:
        self.value = value
        self.symbol = symbol

    def __float__(self) -> float:
        return self.value

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        return repr(self.value)

    def __format__(self, spec: str) -> str:
        return format(self.value, spec)

    def __deepcopy__(self, memo: dict[Any, Any]) -> Any:
        """The number itself; the symbol bound to it in `bound`."""
        binding = memo.get(_BINDING)
        return self if binding is None else binding(self)

    # -- conditions

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)

    def __lt__(self, other: Any) -> bool:
        return self.value < float(other)

    def __le__(self, other: Any) -> bool:
        return self.value <= float(other)

    def __gt__(self, other: Any) -> bool:
        return self.value > float(other)

    def __ge__(self, other: Any) -> bool:
        return self.value >= float(other)

    # -- arithmetic

    def __add__(self, other: Any) -> Any:
        return _combined(self, other, lambda a, b: a + b)

    def __radd__(self, other: Any) -> Any:
        return _combined(other, self, lambda a, b: a + b)

    def __sub__(self, other: Any) -> Any:
        return _combined(self, other, lambda a, b: a - b)

    def __rsub__(self, other: Any) -> Any:
        return _combined(other, self, lambda a, b: a - b)

    def __mul__(self, other: Any) -> Any:
        return _combined(self, other, lambda a, b: a * b)

    def __rmul__(self, other: Any) -> Any:
        return _combined(other, self, lambda a, b: a * b)

    def __truediv__(self, other: Any) -> Any:
        return _combined(self, other, lambda a, b: a / b)

    def __rtruediv__(self, other: Any) -> Any:
        return _combined(other, self, lambda a, b: a / b)

    def __pow__(self, power: int) -> Any:
        result: Any = 1.0
        for _ in range(power):
            result = result * self
        return result

    def __neg__(self) -> Any:
        return _of(-self.value, -self.symbol)

    def __pos__(self) -> Live:
        return self

    def __abs__(self) -> Any:
        return self.absolute()

    # -- functions, as `algebra.scalar` calls them

    def sin(self) -> Any:
        """Sine."""
        value = math.sin(self.value)
        return _of(value, self.symbol.sin())

    def cos(self) -> Any:
        """Cosine."""
        value = math.cos(self.value)
        return _of(value, self.symbol.cos())

    def sqrt(self) -> Any:
        """Square root."""
        value = math.sqrt(self.value)
        return _of(value, self.symbol.sqrt())

    def absolute(self) -> Any:
        """Absolute value."""
        return _of(abs(self.value), self.symbol.absolute())

    def atan2(self, x: Any) -> Any:
        """Angle of the vector (x, self)."""
        value = math.atan2(self.value, float(x))
        return _of(value, self.symbol.atan2(_symbol(x)))

    def atan2_of(self, y: float) -> Any:
        """Angle of the vector (self, y)."""
        value = math.atan2(y, self.value)
        return _of(value, self.symbol.atan2_of(y))


def _combined(a: Any, b: Any, operation: Callable[[Any, Any], Any]) -> Any:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return NotImplemented
    value = operation(float(a), float(b))
    symbol = operation(_symbol(a), _symbol(b))
    return _of(value, symbol)


def _of(value: float, symbol: Any) -> Any:
    """A live number; a float if it does not depend on the parameters."""
    if isinstance(symbol, (float, int)):
        return float(symbol)
    return Live(value, symbol)


def _symbol(x: Any) -> Any:
    return x.symbol if isinstance(x, Live) else float(x)


def is_live(values: Any) -> bool:
    """Whether a number is live, or an array or tuple has a live number."""
    if isinstance(values, Live):
        return True
    if isinstance(values, np.ndarray):
        return bool(values.dtype == object)
    return isinstance(values, (tuple, list)) and any(map(is_live, values))


def plain(values: Any) -> Any:
    """An array of floats, or a float, in place of live numbers."""
    if isinstance(values, np.ndarray):
        return values.astype(np.float64)
    return float(values)


def kept(value: Any) -> float:
    """A number as a float; one that stands for an argument of programs as it is."""
    if isinstance(value, Real):
        return float(value)
    number: float = value
    return number


def stacked(values: Any) -> Array:
    """An array of numbers, live ones included."""
    if is_live(values):
        return np.array(values, dtype=object)
    return np.array(values, dtype=np.float64)


def live_numbers(thing: Any) -> list[Live]:
    """All live numbers in an object and what it refers to, each once, in order."""
    numbers: dict[int, Live] = {}
    memo: dict[Any, Any] = {}

    def add(number: Live) -> Live:
        numbers[id(number)] = number
        return number

    memo[_BINDING] = add
    copy.deepcopy(thing, memo)
    return list(numbers.values())


def bound(thing: T, symbols: Mapping[int, Scalar]) -> T:
    """A copy of any object with symbols in place of its live numbers.

    Args:
        thing: the object; what it shares is shared in the copy.
        symbols: symbols by the identity of the live number.
    """
    memo: dict[Any, Any] = {_BINDING: lambda live: symbols[id(live)]}
    return copy.deepcopy(thing, memo)
