"""Numbers of options, written as descriptions write them: 0.1, pi/2, 30*deg, 500*ms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.expressions import evaluate
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit


def value_of(term: str, units: Sequence[str] = ()) -> float:
    """The value of a term in which nothing but numbers, pi and units has a name.

    Args:
        term: that is evaluated.
        units: in which it may be, where it has any; none where all may be.

    Raises:
        ValueError, ArithmeticError: it has no value, or is in another unit.
    """
    return evaluate(term, {}, names_are="", units=units)


class NumberType(click.ParamType):  # type: ignore[type-arg]
    """A number, or a term as descriptions take them.

    Args:
        units: in which it may be, where it has any.
    """

    name = "number"

    def __init__(self, *units: str) -> None:
        self.units = units

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The value of a term."""
        if isinstance(value, float):
            return value
        try:
            return value_of(str(value), self.units)
        except (ValueError, ArithmeticError) as error:
            self.fail(f"'{value}': {error}", param, ctx)


class QuantityRange(click.FloatRange):
    """A number within a range, or a term in a unit.

    Args:
        unit: in which it may be, where it has any.
        least: the smallest that is taken.
        most: the largest; None where there is none.
        above: whether `least` itself is refused.
    """

    def __init__(
        self, unit: str, least: float = 0.0, most: float | None = None, above: bool = False
    ) -> None:
        super().__init__(min=least, max=most, min_open=above)
        self._number = NumberType(unit)

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The value of a term, if it is within the range."""
        number = self._number.convert(value, param, ctx)
        within: float = super().convert(number, param, ctx)
        return within


def coordinate_units(machine: Robot, rate: str = "") -> list[str]:
    """Units of the active coordinates, or with `rate` of their rates: `/s`, `/s^2`."""
    return [coordinate_unit(machine.joint_types[name], rate) for name in machine.active]


def effort_units(machine: Robot) -> list[str]:
    """Units of the efforts along the active coordinates."""
    return [effort_unit(machine.joint_types[name]) for name in machine.active]
