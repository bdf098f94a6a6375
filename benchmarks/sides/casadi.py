"""CasADi: the program of this library in its virtual machine, and as generated C code."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi
import numpy as np

from hybrid_dynamics_core import Robot

from ..side import Side
from .our_text import inverse_dynamics

Array = np.ndarray
MAPPED = 1000  # states that one call of the mapped function takes


def sides(robot: Robot) -> list[Side]:
    """The virtual machine and, where there is a C compiler, generated code."""
    symbols = [casadi.SX.sym(name, 4) for name in ("u", "du", "ddu")]
    scalars = [[vector[k] for k in range(4)] for vector in symbols]
    tau = inverse_dynamics(robot, casadi)(*scalars)
    machine = casadi.Function("tau", symbols, [casadi.vertcat(*tau)])
    result = [_side("CasADi, virtual machine", machine)]
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is not None:
        result.append(_side("CasADi, generated C", _external(machine, compiler)))
    return result


def _memory(array: Any) -> memoryview:
    return memoryview(array)


def _external(function: casadi.Function, compiler: str) -> casadi.Function:
    folder = Path(tempfile.mkdtemp(prefix="casadi"))
    here = Path.cwd()
    os.chdir(folder)  # CasADi writes where it stands
    try:
        function.generate("tau.c")
    finally:
        os.chdir(here)
    library = folder / "tau.so"
    flags = ["-O3", "-march=native", "-shared", "-fPIC"]
    command = [compiler, *flags, str(folder / "tau.c"), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)  # noqa: S603  the system's compiler
    return casadi.external("tau", str(library))


def _side(name: str, function: casadi.Function) -> Side:
    return Side(name, {"id": _caller(function), "id_batch": _batch(function)})


def _caller(function: casadi.Function) -> Callable[..., Array]:
    buffer: Any  # the types of CasADi ask for sizes that its functions do not
    buffer, trigger = function.buffer()

    def call(u: Array, du: Array, ddu: Array) -> Array:
        out = np.empty(4)
        buffer.set_arg(0, _memory(u))
        buffer.set_arg(1, _memory(du))
        buffer.set_arg(2, _memory(ddu))
        buffer.set_res(0, _memory(out))
        trigger()
        return out

    return call


def _batch(function: casadi.Function) -> Callable[..., Array]:
    buffer: Any
    buffer, trigger = function.map(MAPPED, "serial").buffer()

    def call(u: Array, du: Array, ddu: Array) -> Array:
        out = np.empty_like(u)
        for start in range(0, len(u), MAPPED):
            rows = slice(start, start + MAPPED)
            for k, vector in enumerate((u, du, ddu)):
                buffer.set_arg(k, _memory(vector[rows]))
            buffer.set_res(0, _memory(out[rows]))
            trigger()
        return out

    return call
