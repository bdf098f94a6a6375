"""Digests of the code that kernels are made from, without comments, docstrings and line breaks.

`PLACES` is all code that decides a graph of operations or its text. What else the package does,
such as drawing, changes no kernel. tests/kernels holds the list against the programs' imports.
"""

from __future__ import annotations

import ast
import hashlib
import platform
from collections.abc import Iterable, Sequence
from functools import cache as cached
from pathlib import Path

from . import cache

PACKAGE = __name__.split(".", maxsplit=1)[0]
# Folders and modules of the package. Objects of any other module are never part of a kernel.
PLACES = (
    "algebra",
    "closure",
    "description/actuators.py",
    "description/effects.py",
    "description/model.py",
    "description/rigid_body.py",
    "dynamics",
    "errors.py",
    "ground",
    "kernels",
    "mechanism",
    "programs",
)
COMPILER = ("kernels/llvm.py",)  # decides the object code beside the text that it is given
_ROOT = Path(__file__).resolve().parent.parent
_PREFIXES = tuple(f"{PACKAGE}.{place.removesuffix('.py').replace('/', '.')}" for place in PLACES)


class NoSourceError(OSError):
    """The source of the package is not here, so that nothing says which version this is."""


@cached
def decides_formulas(module: str) -> bool:
    """Whether a module, by its full name, is part of `PLACES`."""
    return any(f"{module}.".startswith(f"{prefix}.") for prefix in _PREFIXES)


@cached
def formula_digest() -> str:
    """Digest of the code of `PLACES`.

    Raises:
        NoSourceError: the source is not here.
    """
    return _digest_of(PLACES)


@cached
def compiler_digest() -> str:
    """Digest of the code of `COMPILER`; raises NoSourceError too."""
    return _digest_of(COMPILER)


def _digest_of(places: Sequence[str]) -> str:
    """Digest of the syntax. It takes half a second, so it is kept under a digest of the bytes."""
    paths = [path for place in places for path in _files(place)]
    texts = {path.relative_to(_ROOT).as_posix(): path.read_bytes() for path in paths}
    names = [part.encode() for part in ("code", platform.python_version(), *texts)]
    key = _hash([*names, *texts.values()])
    entry = cache.read(key)
    if entry is None:
        parts = [(name, syntax(text)) for name, text in texts.items()]
        entry = cache.Entry({"syntax": _hash(word.encode() for part in parts for word in part)})
        cache.write(key, entry)
    return str(entry.facts["syntax"])


def _files(place: str) -> list[Path]:
    path = _ROOT / place
    files = [path] if path.is_file() else sorted(path.rglob("*.py"))
    if not files:
        raise NoSourceError(f"{path} has no source")
    return files


def syntax(text: bytes) -> str:
    """A text that comments, docstrings and layout of a source do not change."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            _drop_docstring(node)
    return ast.dump(tree)


def _drop_docstring(
    node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef,
) -> None:
    if ast.get_docstring(node, clean=False) is not None:
        del node.body[0]


def _hash(parts: Iterable[bytes]) -> str:
    total = hashlib.sha256()
    for part in parts:
        total.update(hashlib.sha256(part).digest())
    return total.hexdigest()
