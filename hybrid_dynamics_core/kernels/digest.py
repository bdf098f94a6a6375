"""Digests of the objects that a program reads: any change of a number, type or order matters.

All reachable objects are included, also names of a description. The code of functions and classes
is not read: it must be part of `formula_code.PLACES`, which has a digest of its own.
"""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import struct
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from enum import Enum
from functools import cached_property
from pathlib import PurePath
from types import CodeType, FunctionType, NoneType
from typing import Any

import numpy as np

from ..ground.lazy import lazy
from .formula_code import decides_formulas
from .graph import Symbol

_LIBRARIES = ("builtins", "numpy")  # covered by their versions, which are part of every key
# What is written of an object: the first role whose types it has. The rest are "object".
_ROLES: dict[str, tuple[type, ...]] = {
    "enum": (Enum,),
    "plain": (NoneType, bool, int, str, bytes, PurePath),
    "float": (float,),
    "array": (np.ndarray,),
    "type": (type,),
    "map": (Mapping,),
    "set": (AbstractSet,),
    "sequence": (Sequence,),
    "function": (FunctionType,),
}
_role_of: dict[type, str] = {}  # of the types that were met
_computed: dict[tuple[type, str], bool] = {}  # attributes that were met, by type and name


class NoDigestError(TypeError):
    """An object is not identified by its content, so results that depend on it are not cached."""


def digest(thing: object) -> str:
    """Hexadecimal digest of an object and all objects that it refers to.

    Raises:
        NoDigestError: an object, class or function is not identified by its content.
    """
    writer = _Writer()
    writer.add(thing)
    return writer.hash.hexdigest()


class _Writer:
    """Feeds a hash. A repeated object is replaced by the index of its first occurrence."""

    def __init__(self) -> None:
        self.hash = hashlib.sha256()
        self._places: dict[int, int] = {}
        self._objects: list[object] = []  # keeps objects alive, so that ids stay unique

    def put(self, kind: str, content: bytes = b"") -> None:
        self.hash.update(f"{kind}:{len(content)}:".encode())
        self.hash.update(content)

    def add(self, thing: object) -> None:
        if self._put_value(thing):
            return
        place = self._places.get(id(thing))
        if place is not None:
            self.put("again", str(place).encode())
            return
        self._places[id(thing)] = len(self._places)
        self._objects.append(thing)
        self._put_composite(thing)

    def _put_composite(self, thing: Any) -> None:
        role = _role(type(thing))
        if role == "map":
            self._put_entries("map", [part for item in thing.items() for part in item])
        elif role == "set":
            self.put("set", "".join(sorted(digest(entry) for entry in thing)).encode())
        elif role == "sequence":
            self._put_entries("list" if isinstance(thing, list) else "tuple", thing)
        elif role == "function":
            self._put_function(thing)
        else:
            self._put_object(thing)

    def _put_entries(self, kind: str, entries: Sequence[object]) -> None:
        self.put(kind, str(len(entries)).encode())
        for entry in entries:
            self.add(entry)

    def _put_value(self, thing: Any) -> bool:
        """Write an object without references to others; returns whether it was one."""
        role = _role(type(thing))
        if role == "plain":
            self.put(type(thing).__name__, repr(thing).encode())
        elif role == "float":
            self.put("float", struct.pack("<d", thing))
        elif role == "enum":
            self.put("enum", f"{_name(type(thing))}.{thing.name}".encode())
        elif role == "array" and thing.dtype != object:
            self.put("array", f"{thing.dtype.str}{thing.shape}".encode())
            self.put("data", np.ascontiguousarray(thing).tobytes())
        elif role == "type":
            if thing.__module__ not in _LIBRARIES:
                _require_formula(thing)
            self.put("type", _name(thing).encode())
        else:
            return False
        return True

    def _put_function(self, function: FunctionType) -> None:
        """Write name, instructions, defaults and closure of a function."""
        _require_formula(function)
        self.put("function", f"{function.__module__}.{function.__qualname__}".encode())
        self._put_code(function.__code__, function.__doc__)
        self.add([cell.cell_contents for cell in function.__closure__ or ()])
        self.add(function.__defaults__)
        self.add(function.__kwdefaults__)

    def _put_code(self, code: CodeType, docstring: str | None = None) -> None:
        """Write instructions, which distinguish functions of one name, such as lambdas."""
        self.put("code", code.co_code)
        for names in (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars):
            self.put("names", " ".join(names).encode())
        for value in code.co_consts:
            if isinstance(value, CodeType):
                self._put_code(value)
            elif value != docstring:
                # a digest of its own, since the identity of constants differs between processes
                self.put("constant", digest(value).encode())

    def _put_object(self, thing: Any) -> None:
        kind = type(thing)
        _require_formula(kind)
        self.put("object", _name(kind).encode())
        if dataclasses.is_dataclass(thing):
            names = [field.name for field in dataclasses.fields(thing)]
            self.add({name: getattr(thing, name) for name in names})
        elif isinstance(thing, Symbol):
            self.add([thing.graph, thing.index])
        elif hasattr(thing, "__dict__"):
            self.add({k: value for k, value in vars(thing).items() if not _is_computed(kind, k)})
        else:
            raise NoDigestError(f"a {kind.__name__} has no digest")


def _require_formula(thing: type | FunctionType) -> None:
    if not decides_formulas(thing.__module__):
        name = f"{thing.__module__}.{thing.__qualname__}"
        raise NoDigestError(f"{name} is not of the code that decides formulas")


def _role(kind: type) -> str:
    """The role of objects of a type; asking abstract classes each time takes long."""
    role = _role_of.get(kind)
    if role is None:
        roles = [role for role, kinds in _ROLES.items() if issubclass(kind, kinds)]
        role = _role_of[kind] = [*roles, "object"][0]
    return role


def _is_computed(kind: type, name: str) -> bool:
    is_computed = _computed.get((kind, name))
    if is_computed is None:
        attribute = inspect.getattr_static(kind, name, None)
        is_computed = _computed[kind, name] = isinstance(attribute, (cached_property, lazy))
    return is_computed


def _name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"
