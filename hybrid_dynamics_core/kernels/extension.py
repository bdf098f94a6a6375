"""A compiled function as a built-in function of Python: the least there can be between a caller and the code.

The code reads arrays where they lie (`ir.entry`). Where the fields of an array lie is fixed by
NumPy's binary interface; `usable` looks once whether it is so here, and refuses otherwise.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from .ir.entry import Header
from .llvm import Loaded

_FASTCALL = 0x0080  # METH_FASTCALL: (self, array of arguments, their number)


class _Definition(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("code", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


class _Self(np.ndarray):
    """The addresses that the code compares with; keeps alive what the function needs."""

    kept: tuple[Any, ...]


def header() -> Header:
    """Where the fields of an array object lie in this Python."""
    return Header(object.__basicsize__)


@cache
def usable() -> bool:
    """Whether the fields of arrays lie where the code looks for them."""
    if ctypes.sizeof(ctypes.c_void_p) != 8 or ctypes.sizeof(ctypes.c_int) != 4:
        return False
    where = header()
    sample = np.zeros((3, 2))
    fixed = np.zeros(1)
    fixed.flags.writeable = False
    return all(
        _read(a, where.type, ctypes.c_void_p) == id(np.ndarray)
        and _read(a, where.data, ctypes.c_void_p) == a.ctypes.data
        and _read(a, where.ndim, ctypes.c_int) == a.ndim
        and _read(a, where.descr, ctypes.c_void_p) == id(np.dtype(np.float64))
        and _read(a, where.flags, ctypes.c_int) & 0x0501 == flags
        and tuple((ctypes.c_int64 * a.ndim).from_address(_read(a, where.dims, ctypes.c_void_p)))
        == a.shape
        for a, flags in ((sample, 0x0501), (sample.T, 0x0500), (fixed, 0x0101))
    )


def _read(thing: object, offset: int, kind: Any) -> Any:
    return kind.from_address(id(thing) + offset).value


def function(code: Loaded) -> Callable[..., int]:
    """The entry of loaded code as a callable."""
    kept = _Self(shape=(3,), dtype=np.int64)
    kept[:] = [id(np.ndarray), id(np.dtype(np.float64)), id(np.dtype(np.int64))]
    definition = _Definition(b"kernel", code.address, _FASTCALL, None)
    kept.kept = (code, definition)
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype, make.argtypes = (
        ctypes.py_object,
        [
            ctypes.c_void_p,
            ctypes.py_object,
            ctypes.c_void_p,
        ],
    )
    result: Callable[..., int] = make(ctypes.addressof(definition), kept, None)
    return result
