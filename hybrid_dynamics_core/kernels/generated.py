"""The backend of generated Python: floats for one state, NumPy for many.

It needs no compiler.
"""

from __future__ import annotations

import marshal
import math
import platform
import sys
from collections.abc import Callable, Sequence
from types import CodeType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.numerics import invert_columns, invert_floats, newton_columns, newton_floats
from .backend import Artifact, Source
from .emit_numpy import emit_columns
from .emit_python import emit_scalar
from .ir.module import Form
from .status import GOOD, NOT_FINITE, NOT_TAKEN
from .trace import Trace

NAME = "python"
# states per call: with fewer, NumPy's overhead counts; with more, rows leave the cache
BLOCK = 8192

_FLOAT64 = np.dtype(np.float64)
_INT64 = np.dtype(np.int64)
Array = NDArray[np.float64]


def _sqrt(x: float) -> float:
    return math.sqrt(x) if x >= 0.0 else math.nan


def _rint(x: float) -> float:
    return float(np.rint(x))


def _atan2(y: float, x: float) -> float:
    # NumPy's function: math.atan2 may differ in the last bit, and one state must equal many
    return float(np.arctan2(y, x))


_SCALAR = {
    "sin": math.sin,
    "cos": math.cos,
    "sqrt": _sqrt,
    "fabs": math.fabs,
    "rint": _rint,
    "atan2": _atan2,
    "invert": invert_floats,
    "newton": newton_floats,
}
_UFUNCS = (
    "add",
    "subtract",
    "multiply",
    "divide",
    "negative",
    "sin",
    "cos",
    "sqrt",
    "rint",
    "absolute",
    "arctan2",
    "greater",
    "logical_not",
)
_COLUMNS = {
    **{name: getattr(np, name) for name in _UFUNCS},
    "fabs": np.abs,
    "atan2": np.arctan2,
    "invert": invert_columns,
    "newton": newton_columns,
}


def identity() -> list[str]:
    """All conditions outside of program and package that facts and text depend on."""
    return [NAME, platform.python_version(), np.__version__]


def conditions() -> list[str]:
    """The Python version that can load the code."""
    return [NAME, sys.version]


def source(trace: Trace, form: Form) -> Source:
    """Python source of one form of a trace."""
    emit = emit_scalar if form == "one" else emit_columns
    return Source(emit(trace))


def build(source: Source) -> bytes:
    """The bytecode of the source, since compilation would block all threads of a reader."""
    return marshal.dumps(compile(source.text, "<kernel>", "exec"))


def load(artifact: Artifact) -> Callable[..., int]:
    """The function of an artifact, with the interface of compiled code."""
    code: CodeType = marshal.loads(artifact.code)  # noqa: S302  of a folder of this user alone
    is_columns = "ROWS" in code.co_names
    scope: dict[str, Any] = dict(_COLUMNS if is_columns else _SCALAR)
    exec(code, scope)  # noqa: S102  numbered variables only
    if is_columns:
        return StateBatch(scope["kernel"], scope["ROWS"], artifact.facts)
    return SingleState(scope["kernel"], artifact.facts)


def _suits(array: object, *shapes: tuple[int, ...], dtype: np.dtype[Any] = _FLOAT64) -> bool:
    return type(array) is np.ndarray and array.dtype == dtype and array.shape in shapes


def _can_be_filled(array: Array) -> bool:
    return array.flags.c_contiguous and array.flags.writeable


class SingleState:
    """Calls a function of floats with arrays: inputs, then outputs, which are filled."""

    def __init__(
        self, kernel: Callable[..., tuple[int, list[float]]], facts: dict[str, Any]
    ) -> None:
        self._kernel, self._read, self._count = kernel, facts["read"], len(facts["inputs"])
        inputs = [(size,) for size in facts["inputs"]]
        outputs = [tuple(shape) for _, shape in facts["layout"]]
        self._shapes = [*inputs, *outputs]

    def __call__(self, *arrays: Array) -> int:
        """The status; `NOT_TAKEN` also on a division by zero, which NumPy then handles."""
        if not self._takes(arrays):
            return NOT_TAKEN
        given, outs = arrays[: self._count], arrays[self._count :]
        inputs = [a.tolist() for a in given]
        try:
            status, values = self._kernel(*inputs)
        except (ZeroDivisionError, ValueError, OverflowError):
            return NOT_TAKEN
        if status == GOOD:
            total = sum(values) + sum(sum(inputs[v]) for v in self._read)
            status = GOOD if math.isfinite(total) else NOT_FINITE
        if status != GOOD and _share_memory(given, outs):
            return NOT_TAKEN  # the caller then reads the inputs again
        start = 0
        for out in outs:
            out[...] = np.reshape(values[start : start + out.size], out.shape)
            start += out.size
        return status

    def _takes(self, arrays: Sequence[Array]) -> bool:
        if len(arrays) != len(self._shapes) or not all(map(_suits, arrays, self._shapes)):
            return False
        return all(map(_can_be_filled, arrays[self._count :]))


def _share_memory(inputs: Sequence[Array], outs: Sequence[Array]) -> bool:
    return any(np.may_share_memory(a, out) for a in inputs for out in outs)


class StateBatch:
    """Calls a function of columns with arrays.

    Arguments are inputs (size,) or (N, size), outputs (N, *shape) and the status (N,).
    """

    def __init__(self, kernel: Callable[..., None], rows: int, facts: dict[str, Any]) -> None:
        self._kernel, self._rows, self._read = kernel, rows, facts["read"]
        self._inputs: list[int] = facts["inputs"]
        self._shapes = [tuple(shape) for _, shape in facts["layout"]]

    def __call__(self, *arrays: Any) -> int:
        """0, or `NOT_TAKEN`."""
        count = len(self._inputs)
        inputs, outs, status = arrays[:count], arrays[count:-1], arrays[-1]
        if not self._takes(inputs, outs, status):
            return NOT_TAKEN
        n = len(status)
        flat = [out.reshape(n, math.prod(out.shape[1:])) for out in outs]
        self._run(inputs, flat, status)
        return GOOD

    def _takes(self, inputs: Sequence[Any], outs: Sequence[Any], status: Any) -> bool:
        n = len(status)
        if not _suits(status, (n,), dtype=_INT64) or len(outs) != len(self._shapes):
            return False
        for array, size in zip(inputs, self._inputs, strict=True):
            if not _suits(array, (size,), (n, size)):
                return False
        for out, shape in zip(outs, self._shapes, strict=True):
            if not _suits(out, (n, *shape)):
                return False
        return all(map(_can_be_filled, outs))

    def _run(
        self, inputs: Sequence[Array], outs: Sequence[Array], status: NDArray[np.int64]
    ) -> None:
        n = len(status)
        width = min(n, BLOCK)
        scratch = np.empty((self._rows, width))
        results = np.empty((sum(out.shape[1] for out in outs), width))
        with np.errstate(all="ignore"):
            for start in range(0, n, BLOCK):
                m = min(BLOCK, n - start)
                rows = slice(start, start + m)
                columns = [_columns(a, rows, m) for a in inputs]
                self._kernel(*columns, scratch[:, :m], results[:, :m], status[rows])
                finite = np.isfinite(results[:, :m]).all(axis=0)
                for v in self._read:
                    finite &= np.isfinite(columns[v]).all(axis=0)
                status[rows][(status[rows] == GOOD) & ~finite] = NOT_FINITE
                first = 0
                for out in outs:
                    out[rows] = results[first : first + out.shape[1], :m].T
                    first += out.shape[1]


def path(one: Callable[..., int], count: int, *arrays: Any) -> int:
    """Rows that each start from the previous one, up to the first one without an answer.

    Args:
        one: the function of one state.
        count: number of outputs.
        *arrays: rows of the first input, the other inputs, outputs and status, as in
            `Kernel.fill_path`.
    """
    *arguments, codes = arrays
    inputs, outs = arguments[:-count], arguments[-count:]
    first, shared, start = inputs[0], inputs[1:-count], inputs[-count:]
    for k, row in enumerate(first):
        results = [out[k] for out in outs]
        codes[k] = one(row, *shared, *start, *results)
        if codes[k] != GOOD:
            break
        start = results
    return GOOD


def _columns(array: Array, rows: slice, count: int) -> Array:
    """Components by row; vectors shared by all states are broadcast without a copy."""
    if array.ndim == 1:
        return np.broadcast_to(array[:, None], (len(array), count))
    return np.ascontiguousarray(array[rows].T)
