"""The source: constants, traced functions, and the public functions around them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...ground.arrays import Array
from ...kernels.trace import Trace
from ...robot.robot import Robot
from .calls import GUESS, JOINTS, PINS
from .emit import constant, emit_functions, function_name
from .header import STATUS
from .names import literal
from .real import Precision
from .shared import emit_shared
from .signatures import Names, rows, signature
from .tracer import TracedFunction

UNDETERMINED = "1e-10"  # share below which a pin's force would lose half its digits

_HEAD = """\
/* Generated; see {p}.h. */
#include "{p}.h"

#include <float.h>
#include <math.h>

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it drops the checks of what is not finite"
#endif
"""

_SET_NAN = """\
static void set_nan(double *x, int n)
{
    for (int k = 0; k < n; ++k) {
        x[k] = (double)NAN;
    }
}
"""

_HELPERS = """\
static int all_finite(const double *x, int n)
{
    int good = 1;
    for (int k = 0; k < n; ++k) {
        good &= x[k] - x[k] <= 0.0;
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
    robot: Robot,
    names: Names,
    traced: Sequence[TracedFunction],
    start: Trace | None,
    precision: Precision,
) -> str:
    """The text of ROBOT.c.

    Args:
        robot: the robot.
        names: its identifiers.
        traced: the functions.
        start: what followed functions start from; None where every loop has a closed form.
        precision: tolerances.
    """
    texts: list[str] = []
    traces = [one.trace for one in traced]
    if start is not None:
        texts += emit_functions(start)
    if len({id(trace.graph) for trace in traces}) < len(traces):
        texts += emit_shared(traces)
    else:
        for one in traced:
            texts += emit_functions(one.trace, one.split)
    parts = [
        _HEAD.format(p=names.prefix),
        _constants(robot, names),
        *(_name_lists(names, one) for one in traced if one.lists),
        _status_text(names.prefix),
        _HELPERS,
        *dict.fromkeys(texts),
    ]
    if any(one.loops for one in traced):
        parts.append(_SET_NAN)
    if start is not None:
        parts.append(_start_function(names, precision))
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
    ranges = {"limits": robot.limits, "effort_ranges": _effort_ranges(robot)}
    for kind, both in ranges.items():
        pairs = [f"{{{_numbers(pair)}}}" for pair in both]
        lines.append(f"const double {p}_{kind}[{names.nu}][2] = {{\n    {rows(pairs, 2)}}};")
    texts = [literal(name) for name in robot.coordinates]
    lines.append(
        f"const char *const {p}_coordinate_names[{names.ns}] = {{\n    {rows(texts, 3)}}};"
    )
    return "\n".join(lines) + "\n"


def _effort_ranges(robot: Robot) -> Array:
    """Least and largest efforts (n, 2) of the active coordinates [N m, N]."""
    ranges = np.stack([-robot.effort_limits, robot.effort_limits], axis=1)
    for k, name in enumerate(robot.active):
        if name in robot.effort_ranges:
            ranges[k] = robot.effort_ranges[name]
    return ranges


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


def _start_function(names: Names, precision: Precision) -> str:
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
        if (!(fabs(start[k] - guess[k]) <= {precision.near!r})) {{
            return {p}_JUMP;
        }}
    }}
    return {p}_OK;
}}
"""


def _public(names: Names, traced: TracedFunction, follows: bool) -> str:
    """A public function: it checks, computes into an array of its own, and copies."""
    p, ns = names.prefix, names.ns
    size = traced.total
    inputs = [*traced.inputs, GUESS]
    listed = [f"all_finite({name}, {names.length(name)})" for name in inputs]
    if traced.split is not None:
        listed[-1] = f"(!guess || {listed[-1]})"
    tests = " && ".join(listed)
    lines = [f"double out[{size} + {ns}];"]
    if follows:
        lines.append(f"double start[{ns} + {ns} * {names.nu}];")
    lines += [
        "int status;",
        f"if (!({tests})) {{",
        f"    return {p}_NOT_FINITE;",
        "}",
    ]
    if follows:
        lines += ["status = close_guess(guess, start);", f"if (status != {p}_OK) {{"]
        lines += ["    return status;", "}"]
    sources = {name: name for name in inputs}
    sources.update({"start": "start", "start_map": f"start + {ns}"})
    arguments = ", ".join([*(sources.get(name, "0") for name in traced.vectors), "out"])
    lines += [
        f"status = {function_name(traced.trace.name)}({arguments});",
        f"if (status != {p}_OK) {{",
        "    return status;",
        "}",
        *_undetermined(traced),
        f"if (!({_finite(traced, ns)})) {{",
        f"    return {p}_NOT_FINITE;",
        "}",
        *_copies(traced, ns),
        f"return {p}_OK;",
    ]
    body = "\n".join(f"    {line}" for line in lines)
    return f"{signature(names, traced)}\n{{\n{body}\n}}\n"


def _copies(traced: TracedFunction, ns: str) -> list[str]:
    """Statements that hand out the results and the configuration."""
    lines = []
    first = 0
    for name, size in traced.results.items():
        lines.append(f"copy(out + {first}, {name}, {size});")
        first += size
    handed = f"copy(out + {first}, guess, {ns});"
    if traced.split is None:
        return [*lines, handed]
    return [*lines, "if (guess) {", f"    {handed}", "}"]


def _finite(traced: TracedFunction, ns: str) -> str:
    """The test that results are finite, but for those that may be NaN."""
    if not traced.call.open:
        number = ns if traced.split is None else f"(guess ? {ns} : 0)"
        return f"all_finite(out, {traced.total} + {number})"
    configuration = f"all_finite(out + {traced.total}, {ns})"
    if traced.split is not None:
        configuration = f"(!guess || {configuration})"
    tests = [configuration]
    first = 0
    for name, size in traced.results.items():
        if name not in traced.call.open:
            tests.append(f"all_finite(out + {first}, {size})")
        first += size
    return " && ".join(tests)


def _undetermined(traced: TracedFunction) -> list[str]:
    """Statements that set undetermined pins, and the joints of their loops, to NaN."""
    places: dict[str, int] = {}
    first = 0
    for name, size in traced.results.items():
        places[name] = first
        first += size
    lines = []
    for k, joints in enumerate(traced.loops):
        share = f"out[{places[PINS[3]] + k}]"
        lines += [f"if (!({share} > {UNDETERMINED})) {{"]
        lines.append(f"    {share} = ({share} <= {UNDETERMINED}) ? {share} : 0.0;")
        triples = [(name, k) for name in PINS[1:3]]
        triples += [(name, joint) for joint in joints for name in JOINTS[1:]]
        for name, index in triples:
            lines.append(f"    set_nan(out + {places[name] + 3 * index}, 3);")
        lines.append("}")
    return lines


def _name_lists(names: Names, traced: TracedFunction) -> str:
    text = ""
    for kind, listed in traced.lists.items():
        size = f"{names.prefix}_N_{kind.upper()}S"
        texts = [literal(name) for name in listed]
        head = f"const char *const {names.prefix}_{kind}_names[{size}]"
        text += f"{head} = {{\n    {rows(texts, 3)}}};\n"
    return text
