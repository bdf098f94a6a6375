"""Records that differ in some columns of bytes, written in one pass as machine code: `mcap_chunk` in place of NumPy.

NumPy writes column after column and holds the interpreter in between; this runs beside it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from hybrid_dynamics_core.kernels import llvm, native
from hybrid_dynamics_core.kernels.ir.text import Function
from hybrid_dynamics_ros.cdr import Bytes

Columns = Sequence[tuple[int, Bytes]]  # first byte in a record, and the bytes of each record (N, k)
_DECLARED = "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)\n"
_FIELDS = 4  # of a column: first byte, bytes, step from record to record, address


@cache
def writer() -> Callable[[Bytes, Bytes, Columns], None] | None:
    """What writes records (N, size): all of a pattern (size,), then columns; None where there is no compiler."""
    if native.reason_against():
        return None
    loaded = llvm.Loaded(llvm.compile_text(_text(), native.LEVEL))
    pointer, count = ctypes.c_void_p, ctypes.c_int64
    code = ctypes.CFUNCTYPE(None, count, count, pointer, pointer, count, pointer)(loaded.address)

    def write(records: Bytes, pattern: Bytes, columns: Columns) -> None:
        rows, size = records.shape
        whole = records.flags.c_contiguous and pattern.flags.c_contiguous and pattern.shape == (size,)
        if not whole or not all(_fits(column, start, rows, size) for start, column in columns):
            raise ValueError("expected records and a pattern of one size, and columns inside them")
        table = [(start, column.shape[1], column.strides[0], column.ctypes.data) for start, column in columns]
        told = np.array(table, dtype=np.int64).reshape(len(table), _FIELDS)
        code(rows, size, records.ctypes.data, pattern.ctypes.data, len(told), told.ctypes.data)
        _ = loaded  # lives as long as its code

    return write


def _fits(column: Bytes, start: int, rows: int, size: int) -> bool:
    return column.shape[0] == rows and 0 <= start <= size - column.shape[1] and column.strides[1] == 1


def _text() -> str:
    heads = "ptr %records, ptr %pattern, i64 %columns, ptr %table"
    f = Function(f"define void @call(i64 %rows, i64 %size, {heads})")
    with f.loop(0, "%rows") as row:
        record = _byte(f, "%records", f.let(f"mul i64 {row}, %size"))
        _copy(f, record, "%pattern", "%size")
        with f.loop(0, "%columns") as column:
            at = f.let(f"mul i64 {column}, {_FIELDS}")
            start, size, step = (f.load("%table", at, k, kind="i64") for k in range(3))
            values = f.load("%table", at, 3, kind="ptr")
            _copy(f, _byte(f, record, start), _byte(f, values, f.let(f"mul i64 {row}, {step}")), size)
    f.do("ret void")
    return _DECLARED + f.text()


def _byte(f: Function, pointer: str, at: str) -> str:
    return f.at(pointer, at, kind="i8")


def _copy(f: Function, to: str, source: str, size: str) -> None:
    f.do(f"call void @llvm.memcpy.p0.p0.i64(ptr {to}, ptr {source}, i64 {size}, i1 false)")
