"""A line of the table of parameters, and the error of a value that cannot be used."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, Generic, TypeVar

Value = str | int | float | bool | tuple[float, ...] | tuple[str, ...] | None
T = TypeVar("T", bound=Value)
OptionalFloats = tuple[float, ...] | None
OptionalNames = tuple[str, ...] | None

LARGE: Final = 1e9  # bound of numbers that need none but a finite one


class ParameterError(ValueError):
    """A parameter has a value that the node cannot use, or a name that it does not know."""


class ChangeTime(Enum):
    """When a parameter may change."""

    NEVER = "it is fixed once the node runs; start the node with another value"
    UNCONFIGURED = (
        "it changes only while the node is unconfigured; call the transition cleanup first"
    )
    ANY_TIME = "at any time"


@dataclass(frozen=True)
class Parameter(Generic[T]):
    """One line of the table.

    Attributes:
        name: parameter name.
        default: value where none is given; None where the parameter is then an empty array.
        text: what it is, for people.
        unit: of a number; "" for other values.
        bounds: lowest and highest number, both allowed; None where there are no bounds.
        choices: the words that are allowed; () where any word is.
        kind: type of the value, or of the entries where it is an array.
        length: number of entries of an array; None for an array of any length, 0 for no array.
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
