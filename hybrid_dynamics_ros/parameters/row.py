"""A row of the table of parameters, and the error of a wrong value."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, Generic, TypeVar

Value = str | int | float | bool | tuple[float, ...] | tuple[str, ...] | None
T = TypeVar("T", bound=Value)
OptionalFloats = tuple[float, ...] | None
OptionalNames = tuple[str, ...] | None

LARGE: Final = 1e9  # default bound of numbers


class ParameterError(ValueError):
    """A parameter has a wrong value or an unknown name."""


class ChangeTime(Enum):
    """When a parameter may change."""

    NEVER = "it is fixed once the node runs; start the node with another value"
    UNCONFIGURED = (
        "it changes only while the node is unconfigured; call the transition cleanup first"
    )
    ANY_TIME = "at any time"


@dataclass(frozen=True)
class Parameter(Generic[T]):
    """One row of the table.

    Attributes:
        name: parameter name.
        default: default value; None if the default is an empty array.
        text: description.
        unit: unit of a number; "" for other values.
        bounds: smallest and largest allowed number; None without bounds.
        choices: allowed words; () if any word is allowed.
        kind: type of the value, or of the entries of an array.
        length: number of entries of an array; None for any length, 0 for a scalar.
        change: when it may change.
    """

    name: str
    default: T
    text: str
    unit: str = ""
    bounds: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    kind: type[Any] = float
    length: int | None = 0
    change: ChangeTime = ChangeTime.UNCONFIGURED
