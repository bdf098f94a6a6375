"""Digests of the source of kernels, without comments, docstrings and most line breaks.

`PLACES` is all code that graphs or generated texts depend on. Other code, such as drawing, does not
change kernels. tests/kernels compares the list with the programs' imports.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable, Sequence
from functools import cache as cached
from pathlib import Path
from types import CodeType

from . import cache

PACKAGE = __name__.split(".", maxsplit=1)[0]
# Folders and modules of the package. Objects of any other module are never part of a kernel.
PLACES = (
    "algebra",
    "closure",
    "description/actuators.py",
    "description/effects.py",
    "description/elasticity",
    "description/model.py",
    "description/rigid_body.py",
    "dynamics",
    "errors.py",
    "ground",
    "kernels",
    "mechanism",
    "programs",
)
COMPILER = ("kernels/llvm.py",)  # code that object code depends on, besides the text
# of a code object, without places in the file
_PARTS_OF_CODE = (
    "co_code",
    "co_names",
    "co_varnames",
    "co_freevars",
    "co_cellvars",
    "co_argcount",
    "co_posonlyargcount",
    "co_kwonlyargcount",
    "co_flags",
    "co_qualname",
    "co_exceptiontable",
)
_ROOT = Path(__file__).resolve().parent.parent
_PREFIXES = tuple(f"{PACKAGE}.{place.removesuffix('.py').replace('/', '.')}" for place in PLACES)


class NoSourceError(OSError):
    """The source of the package is missing, so its version is unknown."""


@cached
def decides_formulas(module: str) -> bool:
    """Whether a module, by its full name, is part of `PLACES`."""
    return any(f"{module}.".startswith(f"{prefix}.") for prefix in _PREFIXES)


@cached
def formula_digest() -> str:
    """Digest of the code of `PLACES`.

    Raises:
        NoSourceError: the source is missing.
    """
    return _digest_of(PLACES)


@cached
def compiler_digest() -> str:
    """Digest of the code of `COMPILER`; raises NoSourceError too."""
    return _digest_of(COMPILER)


def _digest_of(places: Sequence[str]) -> str:
    """Digest of the bytecode; it takes 0.2 s, so it is cached by a digest of the bytes."""
    paths = [path for place in places for path in _files(place)]
    texts = {path.relative_to(_ROOT).as_posix(): path.read_bytes() for path in paths}
    names = [part.encode() for part in ("bytecode", platform.python_version(), *texts)]
    key = _hash([*names, *texts.values()])
    entry = cache.read(key)
    if entry is None:
        parts: list[bytes] = []
        for name, text in texts.items():
            parts += [name.encode(), canonical(text).encode()]
        entry = cache.Entry({"bytecode": _hash(parts)})
        cache.write(key, entry)
    return str(entry.facts["bytecode"])


def _files(place: str) -> list[Path]:
    path = _ROOT / place
    files = [path] if path.is_file() else sorted(path.rglob("*.py"))
    if not files:
        raise NoSourceError(f"{path} has no source")
    return files


def canonical(text: bytes) -> str:
    """A text of the bytecode of a source, without comments, docstrings and most line breaks.

    To compile takes a third of the time that a walk over the syntax tree takes.
    """
    code = compile(text, "formulas", "exec", dont_inherit=True, optimize=2)  # no docstrings
    return _text_of(code)


def _text_of(constant: object) -> str:
    """A text of a constant of bytecode, the same in every process and wherever lines begin."""
    if isinstance(constant, CodeType):
        parts = [str(getattr(constant, name)) for name in _PARTS_OF_CODE]
        return repr([*parts, *map(_text_of, constant.co_consts)])
    if isinstance(constant, frozenset):
        return repr(sorted(map(_text_of, constant)))
    return repr(constant)


def _hash(parts: Iterable[bytes]) -> str:
    total = hashlib.sha256()
    for part in parts:
        total.update(hashlib.sha256(part).digest())
    return total.hexdigest()
