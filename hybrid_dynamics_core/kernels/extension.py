"""Compiled functions as built-in functions of Python, with the least overhead.

The code reads arrays in place (`ir.entry`). NumPy's binary interface fixes the offsets of an
array's fields; `usable` checks them once.
"""

from __future__ import annotations

import ctypes
import importlib
import inspect
import sys
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from .ir.entry import Header
from .llvm import LoadedCode

_FASTCALL = 0x0080  # METH_FASTCALL: (self, array of arguments, their number)
_KEYWORDS = 0x0002  # METH_KEYWORDS: the names of the last arguments follow
_NEW_ARRAY = 93  # place of PyArray_New in NumPy's table of functions
_FLOAT64 = 12  # NPY_DOUBLE
_DTYPE = np.dtype(np.float64)


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
    definition = _Definition(b"kernel", code.address, _FASTCALL, None)
    return _built_in(definition, _identities(), code)


def held_caller(
    function: Callable[..., int], held: Sequence[Array | None], fallback: Callable[..., Any]
) -> Callable[..., Any]:
    """The entry for users of the code of a function, see `ir.held_entry`.

    Args:
        function: result of `function` for one state.
        held: vectors of all inputs, None for those that the caller gives.
        fallback: called with the same arguments if the code does not take them.

    Returns:
        The entry, with name and signature of the fallback; the fallback itself if NumPy's function
        for new arrays is missing.
    """
    new_array = _new_array()
    addresses = getattr(function, "__self__", None)
    if not new_array or not isinstance(addresses, _Self):
        return fallback
    code: LoadedCode = addresses.referents[0]
    name = sys.intern("out")
    further = [id(fallback), id(name), new_array]
    further += [0 if vector is None else vector.ctypes.data for vector in held]
    doc = f"call{_signature_text(fallback)}\n--\n\n{fallback.__doc__ or ''}".encode()
    address = code.address_of("held")
    definition = _Definition(b"call", address, _FASTCALL | _KEYWORDS, doc)
    referents = (code, doc, fallback, name, *held)
    return _built_in(definition, [*_identities(), *further], *referents)


def _identities() -> list[int]:
    """The first addresses of each entry, see `ir.entry.Address`."""
    return [id(np.ndarray), id(np.dtype(np.float64)), id(np.dtype(np.int64))]


def _built_in(definition: _Definition, values: list[int], *referents: Any) -> Callable[..., Any]:
    """A built-in function whose `self` has some addresses."""
    addresses = _Self(shape=(len(values),), dtype=np.int64)
    addresses[:] = values
    addresses.referents = (*referents, definition)
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype = ctypes.py_object
    make.argtypes = [ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p]
    result: Callable[..., Any] = make(ctypes.addressof(definition), addresses, None)
    return result


def _signature_text(function: Callable[..., Any]) -> str:
    """Parameters as `inspect` reads them from built-in functions; arrays by default are None."""
    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(function).parameters.values():
        is_array = isinstance(parameter.default, np.ndarray)
        parameters.append(parameter.replace(default=None) if is_array else parameter)
    return str(inspect.Signature(parameters))


@cache
def _new_array() -> int:
    """Address of NumPy's PyArray_New; 0 if it does not do what is expected."""
    core = "numpy._core" if hasattr(np, "_core") else "numpy.core"
    module = importlib.import_module(f"{core}._multiarray_umath")
    get = ctypes.pythonapi.PyCapsule_GetPointer
    get.restype, get.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    table = get(module._ARRAY_API, None)  # noqa: SLF001  NumPy's interface for C
    if table is None:
        return 0
    pointer = ctypes.c_void_p
    address = (pointer * (_NEW_ARRAY + 1)).from_address(table)[_NEW_ARRAY] or 0
    number = ctypes.c_int
    kinds: list[Any] = [ctypes.py_object, number, pointer, number, pointer, pointer]
    kinds += [number, number, pointer]
    make = ctypes.PYFUNCTYPE(ctypes.py_object, *kinds)(address)
    shape = (ctypes.c_int64 * 2)(3, 2)
    array = make(np.ndarray, 2, ctypes.addressof(shape), _FLOAT64, None, None, 0, 0, None)
    fits = type(array) is np.ndarray and array.shape == (3, 2) and array.dtype is _DTYPE
    return int(address) if fits else 0
