"""The text of a module: one entry, and all functions that it calls."""

from __future__ import annotations

from typing import Literal

from ..rewrite import scheduled
from ..trace import Trace
from . import entry, held_entry
from .atan2 import atan2_function
from .blocks import block_functions
from .entry import Header, one_entry, path_entry, rows_entry
from .rows import rows_function, wide_functions
from .sincos import sincos_functions
from .states import one_functions, path_function
from .steps import StepsFunction, slope_function, steps_entry
from .text import declarations
from .xla_entry import xla_32_entry, xla_one_entry, xla_rows_entry

# for one state, for rows side by side, and for rows that each start from the previous one; the same
# two for XLA, and rows of 32 bits for XLA; steps of an integrator
Form = Literal["one", "rows", "path", "xla_one", "xla_rows", "xla_32", "steps"]


def module_text(trace: Trace, form: Form, width: int, header: Header) -> str:
    """LLVM IR with the function `call` of a form; rows are computed in vectors of `width`."""
    widths = [1]
    if form in ("rows", "xla_rows") and width > 1:
        widths.append(width)
        # One state is computed faster in the other order, in which more is independent.
        trace = scheduled(trace)
    parts = [entry.DECLARATIONS, held_entry.DECLARATIONS]
    for w in widths:
        parts += [line + "\n" for line in declarations(w)]
    functions: list[str] = []
    for w in widths:
        functions += [*sincos_functions(w), atan2_function(w)]
    parts += dict.fromkeys(functions)  # without duplicates
    parts += block_functions(trace, widths[-1])
    parts += _functions(trace, form, width, header)
    return "".join(parts)


def _functions(trace: Trace, form: Form, width: int, header: Header) -> list[str]:
    """The functions of a trace, its entry among them."""
    if form == "rows":
        return [*_rows_functions(trace, width), rows_entry(trace, header)]
    if form == "xla_rows":
        return [*_rows_functions(trace, width), xla_rows_entry(trace)]
    functions = one_functions(trace)
    if form == "one":
        functions += [one_entry(trace, header), held_entry.held_entry(trace, header)]
    elif form == "xla_one":
        functions.append(xla_one_entry(trace))
    elif form == "xla_32":
        functions.append(xla_32_entry(trace))
    elif form == "steps":
        functions += [slope_function(trace), StepsFunction(trace).text()]
        functions.append(steps_entry(trace, header))
    else:
        functions += [path_function(trace), path_entry(trace, header)]
    return functions


def _rows_functions(trace: Trace, width: int) -> list[str]:
    if width == 1:
        return [*one_functions(trace), rows_function(trace, width)]
    return [*wide_functions(trace, width), rows_function(trace, width)]
