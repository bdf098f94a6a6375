"""Newton's method for equations whose constants are arguments of programs.

The function of the iteration is traced by itself. So these constants are further parameters of it.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

from ...algebra.live import Live, bound, live_numbers
from ...algebra.scalar import Scalar, Scalars
from ..constraints.equations import Equation
from .newton import NewtonBlock


class LiveNewtonBlock(NewtonBlock):
    """A Newton block with live numbers, or with the symbols that are bound to them.

    Attributes:
        live: equations with live numbers.
        numbers: all live numbers in them.
        constants: the numbers, or their symbols.
    """

    def __init__(self, block: NewtonBlock, equations: Sequence[Equation]) -> None:
        self.__dict__.update(vars(block))
        self.equations = tuple(equations)
        self.live = self.equations
        self.numbers: tuple[Live, ...] = tuple(live_numbers(self.equations))
        self.constants: tuple[Scalar, ...] = self.numbers

    def __deepcopy__(self, memo: dict[Any, Any]) -> LiveNewtonBlock:
        """A copy with bound equations; those of the iteration stay live."""
        other = copy.copy(self)
        memo[id(self)] = other
        other.equations = copy.deepcopy(self.equations, memo)
        other.constants = copy.deepcopy(self.constants, memo)
        return other

    def iterated_with(self) -> list[Scalar]:
        """The numbers, as parameters of the iteration."""
        return list(self.constants)

    def residuals_and_jacobian(self, unknowns: Scalars, parameters: Scalars) -> list[Scalar]:
        """The function that Newton's method calls, with the constants as its last parameters."""
        first = len(parameters) - len(self.numbers)
        symbols = {id(n): p for n, p in zip(self.numbers, parameters[first:], strict=True)}
        inner = copy.copy(self)
        inner.equations = bound(self.live, symbols)
        return NewtonBlock.residuals_and_jacobian(inner, unknowns, parameters[:first])
