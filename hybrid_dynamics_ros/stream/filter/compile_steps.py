"""Compilation of filter steps: their formulas are traced with `doubles.Double`.

Loops over rows and joints surround them. exp and expm1 are those of the C library, as in Python, so
that all bits equal those of `recursion.run_in_python`.
"""

from __future__ import annotations

from collections.abc import Callable

from hybrid_dynamics_core.kernels import extension, llvm, native
from hybrid_dynamics_core.kernels.ir.entry import DECLARATIONS, Entry
from hybrid_dynamics_core.kernels.ir.text import Function

from . import doubles
from .doubles import Double, name_of
from .steps import Steps

_NAMES = ("intervals", "samples", "constants", "memory", "before", "fitted", "quality")
_FILLED = ("memory", "fitted", "quality")


def compiled(steps: Steps) -> Callable[..., int]:
    """Compile steps to a `recursion.Advance`."""
    text = "".join((DECLARATIONS, doubles.DECLARATIONS, _rows_text(steps), _entry_text(steps)))
    return extension.function(llvm.LoadedCode(llvm.compile_text(text, native.LEVEL)))


def _entry_text(steps: Steps) -> str:
    """The entry function `call` for Python, which checks the arrays."""
    entry = Entry.counted("call", len(_NAMES), extension.header())
    rows, _, joints = entry.lengths(_NAMES.index("samples"), 3)
    shapes: dict[str, list[int | str]] = {
        "intervals": [rows],
        "samples": [rows, steps.channels, joints],
        "constants": [steps.constants],
        "memory": [steps.memory],
        "before": [steps.derivatives, joints],
        "fitted": [rows, steps.derivatives, joints],
        "quality": [rows],
    }
    arguments = [f"i64 {rows}", f"i64 {joints}"]
    for number, name in enumerate(_NAMES):
        pointer = entry.array(number, shapes[name], writable=name in _FILLED)
        arguments.append(f"ptr {pointer}")
    entry.f.do(f"call void @rows({', '.join(arguments)})")
    return entry.finish("0")


def _rows_text(steps: Steps) -> str:
    """The loop over rows: the memory, then each joint."""
    parameters = ["i64 %rows", "i64 %joints", *(f"ptr %{name}" for name in _NAMES)]
    f = Function(f"define internal void @rows({', '.join(parameters)})")
    constants = _loaded(f, "%constants", steps.constants)
    before = f.slot("ptr")
    f.store("%before", before, kind="ptr")
    with f.loop(0, "%rows") as row:
        dt = Double(f, f.load("%intervals", row))
        memory, gains = steps.update(constants, _loaded(f, "%memory", steps.memory), dt)
        for k, number in enumerate(memory):
            f.store(name_of(number), "%memory", k)
        f.store(name_of(memory[-1]), "%quality", row)
        fitted = _row(f, "%fitted", row, steps.derivatives)
        samples = _row(f, "%samples", row, steps.channels)
        last = f.load(before, kind="ptr")
        with f.loop(0, "%joints") as joint:
            values = steps.correct(
                _column(f, last, joint, steps.derivatives),
                dt,
                gains,
                _column(f, samples, joint, steps.channels),
            )
            for place, value in zip(_places(f, joint, len(values)), values, strict=True):
                f.store(name_of(value), fitted, place)
        f.store(fitted, before, kind="ptr")
    f.do("ret void")
    return f.text()


def _loaded(f: Function, pointer: str, count: int) -> list[Double]:
    return [Double(f, f.load(pointer, k)) for k in range(count)]


def _row(f: Function, pointer: str, row: str, height: int) -> str:
    """Address of a row of an array (rows, height, joints)."""
    size = f.product("%joints", height)
    return f.at(pointer, f.let(f"mul i64 {row}, {size}"))


def _column(f: Function, pointer: str, joint: str, height: int) -> list[Double]:
    """The entries of a joint in an array (height, joints)."""
    return [Double(f, f.load(pointer, place)) for place in _places(f, joint, height)]


def _places(f: Function, joint: str, height: int) -> list[str]:
    places = [joint]
    for _ in range(height - 1):
        places.append(f.let(f"add i64 {places[-1]}, %joints"))
    return places
