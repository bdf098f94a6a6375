"""Type checks of arguments that are no arrays."""

from __future__ import annotations

import numpy as np

from ..errors import InputError


def require_type(name: str, value: object, kind: type, how: str) -> None:
    """Check the type of an argument.

    Args:
        name: name of the argument, for messages.
        value: value of the argument.
        kind: the required type.
        how: a way to get one, such as `robot.loads`.

    Raises:
        InputError: the value has another type.
    """
    if not isinstance(value, kind):
        given = type(value).__name__
        raise InputError(f"{name} is of type {given}; expected {kind.__name__}, as {how}")


def real_number(name: str, value: object) -> float:
    """A real number, which may be infinite.

    Args:
        name: name of the argument, for messages.
        value: value of the argument.

    Raises:
        InputError: the value is no real number.
    """
    if not isinstance(value, bool) and isinstance(value, (int, float, np.integer, np.floating)):
        return float(value)
    raise InputError(f"{name} is {value!r} ({type(value).__name__}); expected a number")


def integer(name: str, value: object, least: int = 1) -> int:
    """A whole number.

    Args:
        name: name of the argument, for messages.
        value: value of the argument.
        least: the smallest allowed value.

    Raises:
        InputError: the value is no integer, or too small.
    """
    if not isinstance(value, bool) and isinstance(value, (int, np.integer)) and value >= least:
        return int(value)
    raise InputError(f"{name} is {value!r}; expected a whole number of at least {least}")
