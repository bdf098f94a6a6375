"""A C program that checks a build against numbers of the library."""

from __future__ import annotations

from collections.abc import Sequence

from ...robot.robot import Robot
from .calls import GUESS
from .emit import constant
from .real import Precision
from .signatures import Names, rows
from .states import Vector, vectors
from .tracer import TracedFunction

COUNT = 10  # states of each function

_HEAD = """\
/* Generated: checks a build of {p}.c against numbers of the library. Ends with 0 if all hold. */
#include "{p}.h"

#include <math.h>
#include <stdio.h>

static int differs(const double *got, const double *wanted, int n)
{{
    double largest = 1.0;
    for (int k = 0; k < n; ++k) {{
        largest = fmax(largest, fabs(wanted[k]));
    }}
    for (int k = 0; k < n; ++k) {{
        if (!(fabs(got[k] - wanted[k]) <= {tolerance!r} * largest)) {{
            return 1;
        }}
    }}
    return 0;
}}
"""


def vectors_text(
    robot: Robot, names: Names, traced: Sequence[TracedFunction], precision: Precision
) -> str:
    """The text of test_vectors.c."""
    parts = [_HEAD.format(p=names.prefix, tolerance=precision.agreement)]
    by_name = vectors(robot, traced, COUNT)
    for one in traced:
        parts.append(_tables(one, by_name[one.call.name]))
        parts.append(_check(names, one))
    calls = "".join(f"    failed += check_{one.call.name}();\n" for one in traced)
    parts.append(f"int main(void)\n{{\n    int failed = 0;\n{calls}    return failed != 0;\n}}\n")
    return "\n".join(parts)


def _tables(traced: TracedFunction, listed: Sequence[Vector]) -> str:
    name = traced.call.name
    inputs = ["{" + _numbers(one.inputs.tolist()) + "}" for one in listed]
    outputs = ["{" + _numbers(one.outputs.tolist()) + "}" for one in listed]
    statuses = [str(one.status) for one in listed]
    lengths = len(listed[0].inputs), len(listed[0].outputs)
    return (
        f"static const double {name}_in[{len(listed)}][{lengths[0]}] = {{\n"
        f"    {rows(inputs, 1)}}};\n"
        f"static const double {name}_out[{len(listed)}][{lengths[1]}] = {{\n"
        f"    {rows(outputs, 1)}}};\n"
        f"static const int {name}_status[{len(listed)}] = {{{', '.join(statuses)}}};\n"
    )


def _numbers(values: Sequence[float]) -> str:
    return rows([constant(value) for value in values])


def _check(names: Names, traced: TracedFunction) -> str:
    """A function that runs the vectors of a call, and says how it went."""
    call = traced.call
    arguments = []
    first = 0
    for name in traced.inputs:
        arguments.append(f"in + {first}")
        first += names.count(name)
    guess = first
    arguments.append(GUESS)
    first = 0
    for size in traced.results.values():
        arguments.append(f"out + {first}")
        first += size
    ns = names.ns
    return f"""\
static int check_{call.name}(void)
{{
    const int count = (int)(sizeof {call.name}_status / sizeof {call.name}_status[0]);
    int failed = 0;
    for (int k = 0; k < count; ++k) {{
        const double *in = {call.name}_in[k];
        double out[{first}] = {{0.0}};
        double guess[{ns}];
        int status;
        for (int j = 0; j < {ns}; ++j) {{
            guess[j] = in[{guess} + j];
        }}
        status = {names.prefix}_{call.name}({", ".join(arguments)});
        if (status != {call.name}_status[k]) {{
            printf("{call.name} %d: %s\\n", k, {names.prefix}_status_text(status));
            ++failed;
        }} else if (status == {names.prefix}_OK
                   && (differs(out, {call.name}_out[k], {first})
                       || differs(guess, {call.name}_out[k] + {first}, {ns}))) {{
            printf("{call.name} %d: other numbers than the library\\n", k);
            ++failed;
        }}
    }}
    printf("{call.name}: %d of %d as the library\\n", count - failed, count);
    return failed;
}}
"""
