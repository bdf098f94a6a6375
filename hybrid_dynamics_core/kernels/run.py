"""A traced program as a callable: one state or many, from generated code."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.numerics import invert_columns, invert_floats, newton_columns, newton_floats
from ..description.model import Array
from .emit import emit_columns, emit_scalar
from .trace import Trace, Traceable, split, trace

Codes = NDArray[np.int64]
BLOCK = 4096  # states worked at once: the columns in use stay in the cache


def _sqrt(x: float) -> float:
    return math.sqrt(x) if x >= 0.0 else math.nan


_SCALAR = {
    "sin": math.sin,
    "cos": math.cos,
    "sqrt": _sqrt,
    "fabs": math.fabs,
    "atan2": math.atan2,
    "invert": invert_floats,
    "newton": newton_floats,
}
_COLUMNS = {
    "sin": np.sin,
    "cos": np.cos,
    "sqrt": np.sqrt,
    "fabs": np.abs,
    "atan2": np.arctan2,
    "logical_not": np.logical_not,
    "invert": invert_columns,
    "newton": newton_columns,
}


class Kernel:
    """A program of one robot; traced and compiled when first called."""

    def __init__(self, program: Traceable, sizes: Sequence[int]) -> None:
        self._program = program
        self._sizes = tuple(sizes)

    @cached_property
    def trace(self) -> Trace:
        """The traced program."""
        return trace(self._program, self._sizes)

    @cached_property
    def _scalar(self) -> Callable[..., tuple[int, list[float]]]:
        return _compiled(emit_scalar(self.trace), _SCALAR)

    @cached_property
    def _columns(self) -> Callable[..., None]:
        return _compiled(emit_columns(self.trace), _COLUMNS)

    def __call__(self, *arguments: Array) -> tuple[dict[str, Array], Codes]:
        """Results by name and status; arguments (size,) or (N, size), mixed as they come; results (..., *shape)."""
        many = [a.shape[0] for a in arguments if a.ndim == 2]
        if not many:
            status, values = self._scalar_or_nan([a.tolist() for a in arguments])
            return split(np.array(values), self.trace.layout), np.array(status)
        return self._batch(arguments, many[0])

    def _scalar_or_nan(self, arguments: list[list[float]]) -> tuple[int, list[float]]:
        try:
            return self._scalar(*arguments)
        except (ZeroDivisionError, ValueError, OverflowError):  # NumPy gives NaN here, math refuses: run it on NumPy
            flat, status = self._rows([np.array(a)[None] for a in arguments], 1)
            return int(status[0]), flat[0].tolist()

    def _batch(self, arguments: Sequence[Array], n: int) -> tuple[dict[str, Array], Codes]:
        full = [a if a.ndim == 2 else np.broadcast_to(a, (n, a.shape[0])) for a in arguments]
        flat, status = self._rows(full, n)
        return split(flat, self.trace.layout), status

    def _rows(self, arguments: Sequence[Array], n: int) -> tuple[Array, Codes]:
        flat = np.empty((n, len(self.trace.outputs)))
        status = np.empty(n, dtype=np.int64)
        with np.errstate(all="ignore"):
            for start in range(0, n, BLOCK):
                rows = slice(start, start + BLOCK)
                columns = [np.ascontiguousarray(a[rows].T) for a in arguments]
                out = np.empty((flat.shape[1], columns[0].shape[1]))
                self._columns(*columns, out, status[rows])
                flat[rows] = out.T
        return flat, status


def _compiled(source: str, names: dict[str, Any]) -> Callable[..., Any]:
    scope: dict[str, Any] = dict(names)
    exec(compile(source, "<kernel>", "exec"), scope)  # noqa: S102  source from numbered variables only, see emit
    function: Callable[..., Any] = scope["kernel"]
    return function
