"""Kernels as machine code."""

from __future__ import annotations

import platform
from collections.abc import Callable

import numpy as np

from . import extension, llvm
from .cache import Artifact
from .ir.module import Form, module_text
from .trace import Trace

NAME = "native"
LEVEL = 2  # of LLVM's optimisation
VECTORS = 20_000  # live nodes up to which states are worked side by side: beyond, that takes too long to compile


def reason_against() -> str:
    """Why machine code cannot be made here; empty where it can."""
    if llvm.binding() is None:
        return f"llvmlite {'.'.join(map(str, llvm.OLDEST))} or newer is not installed"
    return "" if extension.usable() else "arrays of this NumPy are laid out in an unknown way"


def identity() -> list[str]:
    """Everything outside the program that the code depends on."""
    import llvmlite  # noqa: PLC0415  optional

    version = [platform.python_version(), np.__version__, llvmlite.__version__]
    return [
        NAME,
        platform.system(),
        *version,
        *llvm.processor(),
        str(LEVEL),
        str(VECTORS),
        str(extension.header().size),
    ]


def make(trace: Trace, form: Form) -> bytes:
    """Object code of one form of a trace."""
    width = llvm.width() if len(trace.live()) <= VECTORS else 1
    return llvm.compile_text(module_text(trace, form, width, extension.header()), LEVEL)


def load(artifact: Artifact) -> Callable[..., int]:
    """The function in object code."""
    return extension.function(llvm.Loaded(artifact.code))
