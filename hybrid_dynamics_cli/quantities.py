"""Numbers in options, written as in descriptions: 0.1, pi/2, 30*deg, 500*ms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.expressions import evaluate
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit


def value_of(term: str, units: Sequence[str] = ()) -> float:
    """The value of a term of numbers, pi and units.

    Args:
        term: text of the term.
        units: allowed units; if empty, all units.

    Raises:
        ValueError, ArithmeticError: the term has no value, or another unit.
    """
    return evaluate(term, {}, names_are="", units=units)


class NumberType(click.ParamType):  # type: ignore[type-arg]
    """Type of an option with a number or a term, as in descriptions.

    Args:
        units: allowed units.
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
    """Type of an option with a number within a range, or a term in a unit.

    Args:
        unit: allowed unit.
        least: smallest value.
        most: largest value; None without one.
        above: whether the value must exceed `least`.
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
    """Units of the active coordinates, or of their derivatives with `rate` (`/s`, `/s^2`)."""
    return [coordinate_unit(machine.joint_types[name], rate) for name in machine.active]


def effort_units(machine: Robot) -> list[str]:
    """Units of the efforts of the active coordinates."""
    return [effort_unit(machine.joint_types[name]) for name in machine.active]
