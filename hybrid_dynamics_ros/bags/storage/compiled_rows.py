"""Records that differ in some columns of bytes, written in one pass as machine code: `mcap_chunk` in place of NumPy.

NumPy writes column after column and holds the interpreter in between; this runs beside it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.kernels import llvm, native
from hybrid_dynamics_core.kernels.ir.text import Function

from ...messages.cdr import Bytes

Columns = Sequence[tuple[int, Bytes]]  # first byte in a record, and the bytes of each record (N, k)
Records = tuple[
    Bytes, Bytes, Columns
]  # what is written (N, size), the pattern of all (size,), where they differ
_DECLARED = "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)\n"
_BLOCK = ("rows", "size", "records", "pattern", "columns", "table")
_COLUMN = ("start", "size", "step", "values")
_ADDRESSES = ("records", "pattern", "table", "values")
_WORD = 8  # bytes of an entry of both tables


@cache
def writer() -> Callable[[Sequence[Records]], None] | None:
    """What writes records: all of a pattern, then its columns; None where there is no compiler."""
    if native.reason_against():
        return None
    loaded = llvm.Loaded(llvm.compile_text(_text(), native.LEVEL))
    code = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p)(loaded.address)

    def write(blocks: Sequence[Records]) -> None:
        for records, pattern, own in blocks:
            rows, size = records.shape
            whole = (
                records.flags.c_contiguous
                and pattern.flags.c_contiguous
                and pattern.shape == (size,)
            )
            if not whole or not all(_fits(column, start, rows, size) for start, column in own):
                raise ValueError(
                    "expected records and a pattern of one size, and columns inside them"
                )
        columns = _table(
            [_column(start, values) for _, _, own in blocks for start, values in own], _COLUMN
        )
        told, at = [], columns.ctypes.data
        for records, pattern, own in blocks:
            told.append((*records.shape, records.ctypes.data, pattern.ctypes.data, len(own), at))
            at += _WORD * len(_COLUMN) * len(own)
        table = _table(told, _BLOCK)
        code(len(table), table.ctypes.data)
        _ = loaded  # lives as long as its code

    return write


def _fits(column: Bytes, start: int, rows: int, size: int) -> bool:
    count, width = column.shape
    return count == rows and 0 <= start <= size - width and (width <= 1 or column.strides[1] == 1)


def _column(start: int, values: Bytes) -> tuple[int, ...]:
    return start, values.shape[1], values.strides[0], values.ctypes.data


def _table(rows: Sequence[tuple[int, ...]], fields: Sequence[str]) -> NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(len(rows), len(fields))


def _text() -> str:
    f = Function("define void @call(i64 %blocks, ptr %told)")
    with f.loop(0, "%blocks") as number:
        block = _entry(f, "%told", number, _BLOCK)
        with f.loop(0, block["rows"]) as row:
            record = _byte(f, block["records"], f.let(f"mul i64 {row}, {block['size']}"))
            _copy(f, record, block["pattern"], block["size"])
            with f.loop(0, block["columns"]) as index:
                column = _entry(f, block["table"], index, _COLUMN)
                values = _byte(f, column["values"], f.let(f"mul i64 {row}, {column['step']}"))
                _copy(f, _byte(f, record, column["start"]), values, column["size"])
    f.do("ret void")
    return _DECLARED + f.text()


def _entry(f: Function, table: str, row: str, fields: Sequence[str]) -> dict[str, str]:
    """What a row of a table says; numbers, and addresses in the fields that are named so."""
    at = f.let(f"mul i64 {row}, {len(fields)}")
    return {
        name: f.load(table, at, k, kind="ptr" if name in _ADDRESSES else "i64")
        for k, name in enumerate(fields)
    }


def _byte(f: Function, pointer: str, at: str) -> str:
    return f.at(pointer, at, kind="i8")


def _copy(f: Function, to: str, source: str, size: str) -> None:
    f.do(f"call void @llvm.memcpy.p0.p0.i64(ptr {to}, ptr {source}, i64 {size}, i1 false)")
