"""Conversion of arguments to checked float64 arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from .arrays import Array

_REAL_KINDS = "iuf"  # NumPy's letters: signed and unsigned integers, floats


def real_array(name: str, value: ArrayLike) -> Array:
    """An array of real numbers of any shape; they may be infinite or NaN.

    Args:
        name: name of the argument, for messages.
        value: value of the argument.

    Returns:
        The values as float64, without a copy if they are float64 already.

    Raises:
        InputError: the value is no array of real numbers.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is not an array of numbers: {error}") from error
    if array.size and array.dtype.kind not in _REAL_KINDS:
        raise InputError(
            f"{name} is not an array of numbers: it holds {array.dtype.name} values; expected real"
            " ones"
        )
    return array.astype(np.float64, copy=False)


def finite_vectors(
    name: str, value: ArrayLike, names: tuple[str, ...], rows: int | None = None
) -> Array:
    """A vector of finite values with one entry a name, or a batch of them.

    Args:
        name: name of the argument, for messages.
        value: value of the argument, (n,) or (N, n).
        names: names of the n entries, in order.
        rows: length that the batch must have; -1 for one vector, None for any.

    Returns:
        (n,) or (N, n) float64, without a copy if the values are float64 already.

    Raises:
        InputError: the shape is wrong, or a value is not finite.
    """
    n = len(names)
    is_single = rows is None or rows < 0
    if (
        is_single
        and type(value) is np.ndarray
        and value.dtype == np.float64
        and value.shape == (n,)
        and all_finite(value)
    ):
        return value  # by far the most frequent case
    if isinstance(value, (Mapping, str, bytes)):
        raise _no_list(name, value, names)
    array = real_array(name, value)
    _check_shape(name, array, names, rows)
    if not np.isfinite(array).all():
        raise _not_finite(name, array, names)
    return array


def all_finite(values: Array) -> bool:
    """Whether all entries of a small array are finite."""
    # plain floats are quicker than NumPy here
    flat = values if values.ndim == 1 else values.ravel()
    total = sum(flat.tolist())
    return math.isfinite(total) or bool(np.isfinite(values).all())


def vectors_by_name(
    label: str,
    values: Mapping[str, ArrayLike] | None,
    names: tuple[str, ...],
    coordinates: tuple[str, ...],
) -> Array:
    """Values in the order of names; zero for names that are left out.

    Args:
        label: label of the argument, for messages.
        values: a number or (N,) by name; None for all zero.
        names: n names that may be given, in order.
        coordinates: all coordinates of the robot, for messages.

    Returns:
        (n,) finite values, or (N, n) where any of them is (N,).

    Raises:
        InputError: a name or a shape is wrong, or a value is not finite.
    """
    given = mapping_of(label, values)
    for name in given:
        if name not in names:
            where = "values" if name in coordinates else "the robot"
            raise InputError(
                f"{label}: '{name}' is not among the coordinates of {where} ({', '.join(names)})"
            )
    columns = [real_array(f"{label}: {name}", given.get(name, 0.0)) for name in names]
    _check_columns(label, columns, names)
    if not columns:
        return np.zeros(0)
    ordered = np.stack(np.broadcast_arrays(*columns), axis=-1)
    return finite_vectors(label, ordered, names)


def mapping_of(label: str, values: object) -> Mapping[str, ArrayLike]:
    """A mapping, or an empty one for None.

    Raises:
        InputError: the value is no mapping.
    """
    if values is None:
        return {}
    if not isinstance(values, Mapping):
        kind = type(values).__name__
        raise InputError(f"{label} is of type {kind}; expected values by name, as {{'q1': 0.1}}")
    return values


def _no_list(
    name: str, value: Mapping[str, float] | str | bytes, names: tuple[str, ...]
) -> InputError:
    """The error for a mapping or a text in place of a list."""
    kind = f"text ({value!r})"
    if isinstance(value, Mapping):
        kind = "values by name"
    hint = ""
    if name == "u":
        hint = "; values by name, of any independent coordinates, are for close_given"
    order = ", ".join(names)
    return InputError(f"{name} is {kind}; expected a list of numbers in the order {order}{hint}")


def _check_columns(label: str, columns: list[Array], names: tuple[str, ...]) -> None:
    """Check that each column is a number or (N,), with one common N."""
    lengths: dict[str, int] = {}
    for name, column in zip(names, columns, strict=True):
        if column.ndim > 1:
            raise InputError(
                f"{label}: {name} has shape {column.shape}; expected a number, or (N,) for a batch"
            )
        if column.ndim:
            lengths[name] = len(column)
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputError(f"{label}: lengths differ ({listed}); expected one for all")


def _check_shape(name: str, array: Array, names: tuple[str, ...], rows: int | None) -> None:
    n = len(names)
    if array.ndim not in (1, 2) or array.shape[-1] != n:
        raise InputError(
            f"{name} has shape {array.shape}; expected ({n},) or (N, {n}) in the order"
            f" {', '.join(names)}"
        )
    if rows is None:
        return
    expected = (n,) if rows < 0 else (rows, n)
    if array.shape != expected:
        raise InputError(
            f"{name} has shape {array.shape}; expected {expected}, as the state it belongs to"
        )


def _not_finite(name: str, array: Array, names: tuple[str, ...]) -> InputError:
    """The error that names the first entry which is not finite."""
    place = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
    where = names[place[-1]]
    if array.ndim == 2:
        where += f" in row {place[0]}"
    return InputError(f"{name}: {where} is {array[place]}; expected finite numbers")
