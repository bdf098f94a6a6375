"""Arguments become checked float64 arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from .arrays import Array


def numbers(name: str, value: ArrayLike) -> Array:
    """An array of real numbers, not looked at further."""
    try:
        told = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is not an array of numbers: {error}") from error
    if told.dtype.kind not in "iuf" and told.size:
        raise InputError(
            f"{name} is not an array of numbers: it holds {told.dtype.name} values; expected real"
            " ones"
        )
    return told.astype(np.float64, copy=False)


def vectors(name: str, value: ArrayLike, names: tuple[str, ...], rows: int | None = None) -> Array:
    """(n,) or (N, n) finite values, one per name; with `rows` given the batch must be that long (-1: one state).

    Raises InputError that says which entry is wrong.
    """
    n = len(names)
    single = rows is None or rows < 0
    if (
        single
        and type(value) is np.ndarray
        and value.dtype == np.float64
        and value.shape == (n,)
        and all_finite(value)
    ):
        return value  # by far the most frequent case
    if isinstance(value, (Mapping, str, bytes)):
        by_name = (
            "; values by name, of any independent coordinates, are for close_given"
            if name == "u"
            else ""
        )
        kind = "values by name" if isinstance(value, Mapping) else f"text ({value!r})"
        raise InputError(
            f"{name} is {kind}; expected a list of numbers in the order {', '.join(names)}{by_name}"
        )
    array = numbers(name, value)
    if array.ndim not in (1, 2) or array.shape[-1] != n:
        raise InputError(
            f"{name} has shape {array.shape}; expected ({n},) or (N, {n}) in the order"
            f" {', '.join(names)}"
        )
    expected = None if rows is None else ((n,) if rows < 0 else (rows, n))
    if expected is not None and array.shape != expected:
        raise InputError(
            f"{name} has shape {array.shape}; expected {expected}, as the state it belongs to"
        )
    if not np.isfinite(array).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        where = names[place[-1]] + (f" in row {place[0]}" if array.ndim == 2 else "")
        raise InputError(f"{name}: {where} is {array[place]}; expected finite numbers")
    return array


def all_finite(values: Array) -> bool:
    """Whether all entries of a small array are finite: a sum in plain floats tells it soonest."""
    return math.isfinite(sum(values.ravel().tolist())) or bool(np.isfinite(values).all())


def named_values(
    label: str, values: Mapping[str, float] | None, names: tuple[str, ...], known: tuple[str, ...]
) -> Array:
    """Values in the order of `names`, zero where left out.

    InputError for other names and for what is not finite.
    """
    given = values or {}
    for name in given:
        if name not in names:
            where = "values" if name in known else "the robot"
            raise InputError(
                f"{label}: '{name}' is not among the coordinates of {where} ({', '.join(names)})"
            )
    return vectors(label, [given.get(name, 0.0) for name in names], names, -1)
