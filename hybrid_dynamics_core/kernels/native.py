"""The backend of machine code."""

from __future__ import annotations

import logging
import platform
from collections.abc import Callable

import numpy as np

from . import extension, llvm
from .backend import Artifact, Source
from .formula_code import compiler_digest
from .ir.module import Form, module_text
from .trace import Trace

NAME = "native"
# optimisation level: the graph is optimised already, and higher levels take longer
LEVEL = 1
LONG = 250_000  # [live nodes] above this, full optimisation takes more than half a minute

_log = logging.getLogger(__name__)


def reason_against() -> str:
    """The reason why machine code is not available; empty if it is."""
    if llvm.binding() is None:
        return f"llvmlite {'.'.join(map(str, llvm.OLDEST))} or newer is not installed"
    if not extension.usable():
        return "arrays of this NumPy are laid out in an unknown way"
    return ""


def identity() -> list[str]:
    """All conditions outside of program and package that facts and text depend on."""
    versions = [platform.python_version(), np.__version__]
    return [*versions, str(LEVEL), str(LONG), *_machine()]


def conditions() -> list[str]:
    """All conditions besides text and level that the object code depends on."""
    return [*_machine(), compiler_digest()]


def _machine() -> list[str]:
    header = str(extension.header().size)
    return [NAME, platform.system(), *llvm.versions(), *llvm.processor(), header]


def source(trace: Trace, form: Form) -> Source:
    """The text of one form of a trace in LLVM's intermediate representation."""
    size = len(trace.live)
    level = LEVEL
    if size >= LONG:
        level = 0
        _log.warning(
            "a program of %d operations is compiled quickly instead of well: it runs several times"
            " slower",
            size,
        )
    text = module_text(trace, form, llvm.vector_width(), extension.header())
    return Source(text, level)


def build(source: Source) -> bytes:
    """Object code of a text."""
    return llvm.compile_text(source.text, source.level)


def load(artifact: Artifact) -> Callable[..., int]:
    """Load the function of object code."""
    return extension.function(code(artifact))


def code(artifact: Artifact) -> llvm.LoadedCode:
    """Load object code."""
    return llvm.LoadedCode(artifact.code)
