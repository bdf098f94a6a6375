"""Compiled functions as built-in functions of Python, with the least overhead.

The code reads arrays in place (`ir.entry`). NumPy's binary interface fixes the offsets of an
array's fields; `usable` checks them once.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .ir.entry import Header
from .llvm import LoadedCode

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
    """The addresses that the code compares with; it keeps the function's objects alive."""

    referents: tuple[Any, ...]


def header() -> Header:
    """Offsets of the fields of an array object in this Python."""
    return Header(object.__basicsize__)


@cache
def usable() -> bool:
    """Whether the fields of arrays are at the expected offsets."""
    if ctypes.sizeof(ctypes.c_void_p) != 8 or ctypes.sizeof(ctypes.c_int) != 4:
        return False
    where = header()
    sample = np.zeros((3, 2))
    fixed = np.zeros(1)
    fixed.flags.writeable = False
    samples = ((sample, 0x0501), (sample.T, 0x0500), (fixed, 0x0101))
    return all(_is_laid_out(array, flags, where) for array, flags in samples)


def _is_laid_out(array: NDArray[Any], flags: int, where: Header) -> bool:
    """Whether the fields of an array have the expected values."""
    fields = [
        (where.type, ctypes.c_void_p, id(np.ndarray)),
        (where.data, ctypes.c_void_p, array.ctypes.data),
        (where.ndim, ctypes.c_int, array.ndim),
        (where.descr, ctypes.c_void_p, id(np.dtype(np.float64))),
    ]
    if not all(_read(array, offset, kind) == value for offset, kind, value in fields):
        return False
    if _read(array, where.flags, ctypes.c_int) & 0x0501 != flags:
        return False
    dims = _read(array, where.dims, ctypes.c_void_p)
    return tuple((ctypes.c_int64 * array.ndim).from_address(dims)) == array.shape


def _read(thing: object, offset: int, kind: Any) -> Any:
    return kind.from_address(id(thing) + offset).value


def function(code: LoadedCode) -> Callable[..., int]:
    """The entry of loaded code as a callable."""
    addresses = _Self(shape=(3,), dtype=np.int64)
    addresses[:] = [id(np.ndarray), id(np.dtype(np.float64)), id(np.dtype(np.int64))]
    definition = _Definition(b"kernel", code.address, _FASTCALL, None)
    addresses.referents = (code, definition)
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype = ctypes.py_object
    make.argtypes = [ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p]
    result: Callable[..., int] = make(ctypes.addressof(definition), addresses, None)
    return result
