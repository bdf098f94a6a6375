"""The source: constants, traced functions, and the public functions around them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...kernels.trace import Trace
from ...robot.robot import Robot
from .calls import GUESS, TracedCall
from .emit import constant, emit_functions, function_name
from .header import STATUS
from .names import literal
from .signatures import Names, rows, signature, total

NEAR = 1e-4  # [rad or m] a guess farther from closed belongs to another assembly mode, or to none

_HEAD = """\
/* Generated; see {p}.h. */
#include "{p}.h"

#include <math.h>

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it drops the checks of what is not finite"
#endif
"""

_HELPERS = """\
static int all_finite(const double *x, int n)
{
    int good = 1;
    for (int k = 0; k < n; ++k) {
        good = good && (x[k] - x[k] <= 0.0);
    }
    return good;
}

static void copy(const double *from, double *to, int n)
{
    for (int k = 0; k < n; ++k) {
        to[k] = from[k];
    }
}
"""


def source_text(
    robot: Robot, names: Names, traced: Sequence[TracedCall], start: Trace | None
) -> str:
    """The text of ROBOT.c.

    Args:
        robot: the robot.
        names: its identifiers.
        traced: the functions.
        start: what followed functions start from; None where every loop has a closed form.
    """
    texts: list[str] = []
    for trace in [*([] if start is None else [start]), *(one.trace for one in traced)]:
        texts += emit_functions(trace)
    parts = [
        _HEAD.format(p=names.prefix),
        _constants(robot, names),
        _status_text(names.prefix),
        _HELPERS,
        *dict.fromkeys(texts),
    ]
    if start is not None:
        parts.append(_start_function(names))
    parts += [_public(names, one, start is not None) for one in traced]
    return "\n".join(parts)


def _constants(robot: Robot, names: Names) -> str:
    p = names.prefix
    reference = robot.close(robot.reference).s
    values = {
        f"{p}_reference[{names.ns}]": reference,
        f"{p}_gravity[3]": robot.loads.gravity,
        f"{p}_velocity_limits[{names.nu}]": robot.velocity_limits,
        f"{p}_effort_limits[{names.nu}]": robot.effort_limits,
    }
    lines = []
    for name, array in values.items():
        lines.append(f"const double {name} = {{\n    {_numbers(array)}}};")
    pairs = [f"{{{_numbers(pair)}}}" for pair in robot.limits]
    lines.append(f"const double {p}_limits[{names.nu}][2] = {{\n    {rows(pairs, 2)}}};")
    texts = [literal(name) for name in robot.coordinates]
    lines.append(
        f"const char *const {p}_coordinate_names[{names.ns}] = {{\n    {rows(texts, 3)}}};"
    )
    return "\n".join(lines) + "\n"


def _numbers(values: np.ndarray) -> str:
    return rows([constant(float(value)) for value in values])


def _status_text(prefix: str) -> str:
    cases = ""
    for name, text in STATUS.values():
        cases += f'    case {prefix}_{name}:\n        return "{text}";\n'
    return (
        f"const char *{prefix}_status_text(int status)\n{{\n    switch (status) {{\n{cases}"
        f'    default:\n        return "no status of this robot";\n    }}\n}}\n'
    )


def _start_function(names: Names) -> str:
    """The function that closes the guess, and finds R there."""
    p, ns, nu = names.prefix, names.ns, names.nu
    return f"""\
/* From a guess to the closed configuration (NS) at its u, and R there (NS, NU). */
static int close_guess(const double *guess, double *start)
{{
    const int status = f_start(guess, start);
    if (status != {p}_OK) {{
        return status;
    }}
    if (!all_finite(start, {ns} + {ns} * {nu})) {{
        return {p}_NOT_FINITE;
    }}
    for (int k = 0; k < {ns}; ++k) {{
        if (!(fabs(start[k] - guess[k]) <= {NEAR!r})) {{
            return {p}_JUMP;
        }}
    }}
    return {p}_OK;
}}
"""


def _public(names: Names, traced: TracedCall, follows: bool) -> str:
    """A public function: it checks, computes into an array of its own, and copies."""
    p, ns, call = names.prefix, names.ns, traced.call
    size = total(traced)
    inputs = [*call.inputs, GUESS]
    tests = " && ".join(f"all_finite({name}, {names.length(name)})" for name in inputs)
    lines = [f"double out[{size} + {ns}];"]
    if follows:
        lines.append(f"double start[{ns} + {ns} * {names.nu}];")
    lines += [
        "int status;",
        f"if (!({tests})) {{",
        f"    return {p}_NOT_FINITE;",
        "}",
    ]
    last = [GUESS]
    if follows:
        last = ["start", f"start + {ns}"]
        lines += ["status = close_guess(guess, start);", f"if (status != {p}_OK) {{"]
        lines += ["    return status;", "}"]
    arguments = ", ".join([*call.inputs, *last, "out"])
    lines += [
        f"status = {function_name(traced.trace.name)}({arguments});",
        f"if (status == {p}_OK && !all_finite(out, {size} + {ns})) {{",
        f"    status = {p}_NOT_FINITE;",
        "}",
        f"if (status != {p}_OK) {{",
        "    return status;",
        "}",
        *_copies(traced, ns),
        "return status;",
    ]
    body = "\n".join(f"    {line}" for line in lines)
    return f"{signature(names, traced)}\n{{\n{body}\n}}\n"


def _copies(traced: TracedCall, ns: str) -> list[str]:
    """Statements that hand out the results and the configuration."""
    lines = []
    first = 0
    for name, size in zip(traced.call.results.values(), traced.sizes, strict=True):
        lines.append(f"copy(out + {first}, {name}, {size});")
        first += size
    lines.append(f"copy(out + {first}, guess, {ns});")
    return lines
