"""The text of a module: one entry, and all functions that it calls."""

from __future__ import annotations

from typing import Literal

from ..rewrite import scheduled
from ..trace import Trace
from . import entry
from .atan2 import atan2_function
from .blocks import block_functions
from .entry import Header, one_entry, path_entry, rows_entry
from .held_entry import DECLARATIONS, held_entry
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
    parts = [entry.DECLARATIONS, DECLARATIONS]
    for w in widths:
        parts += [line + "\n" for line in declarations(w)]
    functions: list[str] = []
    for w in widths:
        functions += [*sincos_functions(w), atan2_function(w)]
    parts += dict.fromkeys(functions)  # without duplicates
    parts += block_functions(trace, widths[-1])
    if form == "one":
        parts += [*one_functions(trace), one_entry(trace, header)]
        parts += [held_entry(trace, header)]
    elif form == "xla_one":
        parts += [*one_functions(trace), xla_one_entry(trace)]
    elif form == "xla_32":
        parts += [*one_functions(trace), xla_32_entry(trace)]
    elif form == "steps":
        parts += [*one_functions(trace), slope_function(trace), StepsFunction(trace).text()]
        parts.append(steps_entry(trace, header))
    elif form == "path":
        parts += [*one_functions(trace), path_function(trace), path_entry(trace, header)]
    else:
        parts += wide_functions(trace, width) if width > 1 else one_functions(trace)
        parts.append(rows_function(trace, width))
        parts.append(xla_rows_entry(trace) if form == "xla_rows" else rows_entry(trace, header))
    return "".join(parts)
