"""The text of a module: one entry, and all that it calls."""

from __future__ import annotations

from typing import Literal

from ..trace import Trace
from .blocks import block_functions
from .entry import DECLARATIONS, Header, one_entry, rows_entry
from .nodes import atan2_functions
from .sincos import sincos_functions
from .states import one_functions, rows_function, wide_functions
from .text import declarations

Form = Literal["one", "rows"]


def module_text(trace: Trace, form: Form, width: int, header: Header) -> str:
    """LLVM IR with the function `call`, for one state or for rows, `width` of them side by side."""
    widths = [1] if form == "one" or width == 1 else [1, width]
    parts = [DECLARATIONS]
    for w in widths:
        parts += [line + "\n" for line in declarations(w)]
    functions: list[str] = []
    for w in widths:
        functions += [*sincos_functions(w), *atan2_functions(w)]
    parts += dict.fromkeys(functions)  # each once
    parts += block_functions(trace)
    if form == "one":
        parts += [*one_functions(trace), one_entry(trace, header)]
    else:
        parts += wide_functions(trace, width) if width > 1 else one_functions(trace)
        parts += [rows_function(trace, width), rows_entry(trace, header)]
    return "".join(parts)
