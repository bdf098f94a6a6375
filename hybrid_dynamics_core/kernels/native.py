"""Kernels as machine code."""

from __future__ import annotations

import logging
import platform
from collections.abc import Callable

import numpy as np

from . import extension, llvm
from .cache import Artifact
from .ir.module import Form, module_text
from .trace import Trace

NAME = "native"
# of LLVM's optimisation: the graph is in its best form already, and higher levels take longer
LEVEL = 1
LONG = 250_000  # live nodes from which compiling well would take more than half a minute

_log = logging.getLogger(__name__)


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
        str(LONG),
        str(extension.header().size),
    ]


def make(trace: Trace, form: Form) -> bytes:
    """Object code of one form of a trace."""
    size = len(trace.live)
    level = LEVEL if size < LONG else 0
    if level != LEVEL:
        _log.warning(
            "a program of %d operations is compiled quickly instead of well: it runs several times"
            " slower",
            size,
        )
    return llvm.compile_text(module_text(trace, form, llvm.width(), extension.header()), level)


def load(artifact: Artifact) -> Callable[..., int]:
    """The function in object code."""
    return extension.function(llvm.Loaded(artifact.code))
