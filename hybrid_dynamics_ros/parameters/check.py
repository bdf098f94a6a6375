"""Checks of parameter values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, cast

from .inputs import SENSOR
from .robot import XACRO_ARGS
from .row import Parameter, ParameterError, Value


def checked(row: Parameter[Any], value: Any) -> Value:
    """The value of a parameter, checked against its row of the table.

    An integer is accepted as a float. An array becomes a tuple. An unset value, None or an empty
    array, becomes the default.

    Raises:
        ParameterError: the value has a wrong type or length, or is empty, out of bounds or none of
            the choices. The text says what is expected.
    """
    is_array = row.length != 0
    if value is None or (is_array and _is_empty(value)):
        return cast(Value, row.default)
    if is_array:
        return _checked_array(row, value)
    entry = _entry(row, value)
    if entry == "" and row.default != "":
        raise _wrong(row, value, row.text)
    _check_sign(row, entry)
    return cast(Value, entry)


def _is_empty(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str | bytes) and len(value) == 0


def _check_sign(row: Parameter[Any], entry: Any) -> None:
    """Raise if the sign of a sensor is neither 1 nor -1, which bounds cannot express."""
    is_sign = row.name.startswith(f"{SENSOR}.") and row.name.endswith(".sign")
    if is_sign and abs(entry) != 1.0:
        raise _wrong(row, entry, "expected 1.0 or -1.0")


def _checked_array(row: Parameter[Any], value: Any) -> Value:
    """Check length and entries of an array; returns a tuple."""
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise _wrong(row, value, "expected an array")
    if row.length is not None and len(value) != row.length:
        raise _wrong(row, list(value), f"expected {row.length} entries")
    entries = tuple(_entry(row, entry) for entry in value)
    if row is XACRO_ARGS:
        _check_arguments(entries)
    return cast(Value, entries)


def _check_arguments(texts: tuple[str, ...]) -> None:
    """Raise if a text is no argument, or repeats one."""
    names = set()
    for text in texts:
        name, sign, _ = text.partition(":=")
        if not sign or not name.strip():
            raise _wrong(XACRO_ARGS, text, "expected NAME:=VALUE, as prefix:=left_")
        if name.strip() in names:
            raise _wrong(XACRO_ARGS, list(texts), f"'{name.strip()}' is given twice")
        names.add(name.strip())


def _entry(row: Parameter[Any], value: Any) -> Any:
    """Check a scalar value, or one entry of an array."""
    if row.kind is float and type(value) is int:
        value = float(value)
    if type(value) is not row.kind:
        raise _wrong(row, value, f"expected {_KINDS[row.kind]}")
    if row.choices and value not in row.choices:
        raise _wrong(row, value, f"expected one of: {', '.join(row.choices)}")
    if row.bounds is not None:
        low, high = row.bounds
        if not (math.isfinite(value) and low <= value <= high):
            unit = f" {row.unit}" if row.unit else ""
            raise _wrong(row, value, f"expected a number from {low:g} to {high:g}{unit}")
    return value


_KINDS: Final = {str: "a word", int: "a whole number", float: "a number", bool: "true or false"}


def _wrong(row: Parameter[Any], value: object, expected: str) -> ParameterError:
    shown = f"'{value}'" if isinstance(value, str) else value
    return ParameterError(f"parameter {row.name} is {shown}: {expected}")
