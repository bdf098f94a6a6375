"""A digest of what a kernel is made from: the objects that a program reads, and the code that reads them.

Any change of a number, a type, an order or a function gives another digest. Names out of a
description count like everything else that can be reached.
"""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import struct
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from enum import Enum
from functools import cache, cached_property
from pathlib import Path, PurePath
from types import FunctionType

import numpy as np


class NoDigestError(TypeError):
    """Something cannot be told apart from something else by its content: what depends on it is not to be kept."""


def digest(thing: object) -> str:
    """Hexadecimal digest of an object and of all that it holds.

    NoDigestError where that is not possible.
    """
    writer = _Writer()
    writer.add(thing)
    return writer.hash.hexdigest()


class _Writer:
    """Feeds a hash; an object met again is told by the place where it was met first, so cycles end."""

    def __init__(self) -> None:
        self.hash = hashlib.sha256()
        self._met: dict[int, int] = {}
        self._kept: list[object] = []  # ids stay unique only while the objects live

    def put(self, kind: str, content: bytes = b"") -> None:
        self.hash.update(f"{kind}:{len(content)}:".encode())
        self.hash.update(content)

    def add(self, thing: object) -> None:
        if self._plain(thing):
            return
        if id(thing) in self._met:
            self.put("again", str(self._met[id(thing)]).encode())
            return
        self._met[id(thing)] = len(self._met)
        self._kept.append(thing)
        if isinstance(thing, Mapping):
            self._entries("map", [part for item in thing.items() for part in item])
        elif isinstance(thing, AbstractSet):
            self.put("set", "".join(sorted(digest(entry) for entry in thing)).encode())
        elif isinstance(thing, Sequence):
            self._entries("list" if isinstance(thing, list) else "tuple", thing)
        elif isinstance(thing, FunctionType):
            self._function(thing)
        else:
            self._object(thing)

    def _entries(self, kind: str, entries: Sequence[object]) -> None:
        self.put(kind, str(len(entries)).encode())
        for entry in entries:
            self.add(entry)

    def _plain(self, thing: object) -> bool:
        if isinstance(thing, Enum):
            self.put("enum", f"{_name(type(thing))}.{thing.name}".encode())
        elif thing is None or isinstance(thing, (bool, int, str, bytes, PurePath)):
            self.put(type(thing).__name__, repr(thing).encode())
        elif isinstance(thing, float):
            self.put("float", struct.pack("<d", thing))
        elif isinstance(thing, np.ndarray) and thing.dtype != object:
            self.put("array", f"{thing.dtype.str}{thing.shape}".encode())
            self.put("data", np.ascontiguousarray(thing).tobytes())
        elif isinstance(thing, type):
            self.put("type", _name(thing).encode())
        else:
            return False
        return True

    def _function(self, function: FunctionType) -> None:
        """Module, line, name, and what it holds from around it; its text is part of the code's digest."""
        _own(function)
        line = function.__code__.co_firstlineno
        self.put("function", f"{function.__module__}.{line}.{function.__qualname__}".encode())
        self.add([cell.cell_contents for cell in function.__closure__ or ()])
        self.add(function.__defaults__)
        self.add(function.__kwdefaults__)

    def _object(self, thing: object) -> None:
        _own(type(thing))
        self.put("object", _name(type(thing)).encode())
        if dataclasses.is_dataclass(thing):
            self.add(
                {field.name: getattr(thing, field.name) for field in dataclasses.fields(thing)}
            )
        elif hasattr(thing, "__dict__"):
            self.add(
                {
                    key: value
                    for key, value in vars(thing).items()
                    if not _computed(type(thing), key)
                }
            )
        else:
            raise NoDigestError(f"a {type(thing).__name__} has no digest")


def _own(thing: type | FunctionType) -> None:
    """Only what this package wrote is told apart by its name: the digest of the code answers for the rest of it."""
    if thing.__module__.partition(".")[0] != __name__.partition(".")[0]:
        raise NoDigestError(f"{thing.__module__}.{thing.__qualname__} is not of this package")


def _computed(kind: type, key: str) -> bool:
    return isinstance(inspect.getattr_static(kind, key, None), cached_property)


def _name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


@cache
def code_digest() -> str:
    """Digest of the sources of this package: generated code is of no use to another version."""
    root = Path(__file__).resolve().parent.parent
    total = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        total.update(path.relative_to(root).as_posix().encode())
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()
