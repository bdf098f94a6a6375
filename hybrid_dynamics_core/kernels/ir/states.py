"""Functions for a whole trace: `@one` for a state, and `@path` for rows that follow each other.

Arguments are pointers to the input vectors and to the named outputs. The status of a state is 0,
the code of the first check that fails, or NOT_FINITE.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from ..graph import Symbol
from ..status import GOOD, NOT_FINITE
from ..trace import Trace
from .blocks import call_block, fetch_input
from .nodes import Nodes
from .parts import Parts
from .text import Function, Lanes


def sizes(trace: Trace) -> list[int]:
    """Number of values of each named output."""
    return [math.prod(shape) for _, shape in trace.layout]


def _parameters(trace: Trace) -> list[str]:
    return [f"ptr %a{v}" for v in range(len(trace.inputs))]


def outs_of(trace: Trace) -> list[str]:
    """Parameters for the outputs."""
    return [f"ptr %o{k}" for k in range(len(trace.layout))]


def _places(trace: Trace) -> Iterator[tuple[int, int]]:
    """(index of the output, index in it) of each flat output, in order."""
    for number, size in enumerate(sizes(trace)):
        for place in range(size):
            yield number, place


def one_functions(trace: Trace) -> list[str]:
    """`@one(a0, ..., o0, ...)`: fills the outputs of a state, and returns its status.

    The functions that it calls come before it.
    """
    parameters = _parameters(trace)
    parts = Parts(trace, 1, "one", parameters, fetch_input(trace))
    arguments = ", ".join(parameters + outs_of(trace))
    f = Function(f"define internal i64 @one({arguments}) noinline")
    nodes = parts.nodes(Lanes(f, 1), call_block)
    inputs = [f.load(f"%a{v}", k) for v, k in read_inputs(trace)]
    status = status_of(nodes, [zero_if_finite(nodes.lanes, inputs)])
    for output, (number, place) in zip(trace.outputs, _places(trace), strict=True):
        value = nodes.value(output)
        f.store(value, f"%o{number}", place)
    f.do(f"ret i64 {status}")
    return [*parts.functions(call_block), f.text()]


def read_inputs(trace: Trace) -> list[tuple[int, int]]:
    """All components of the input vectors that are used."""
    vectors = {v for v, _ in trace.used_inputs()}
    components = []
    for v in sorted(vectors):
        components += [(v, k) for k in range(trace.inputs[v])]
    return components


def status_of(nodes: Nodes, tests: Sequence[str]) -> str:
    """Status of each lane.

    Args:
        nodes: the values.
        tests: zero, or NaN where an input is not finite.
    """
    lanes = nodes.lanes
    results: dict[int, str] = {}  # without duplicates
    for output in nodes.trace.outputs:
        if isinstance(output, Symbol):
            results[output.index] = nodes.value(output)
    total = zero_if_finite(lanes, list(results.values()))
    for test in tests:
        total = lanes.arithmetic("fadd", total, test)
    is_finite = lanes.compare("oeq", total, lanes.constant(0.0))
    good = lanes.splat("i64", 0)
    not_finite = lanes.splat("i64", NOT_FINITE)
    status = lanes.choose(is_finite, lanes.integer, good, not_finite)
    for check in reversed(nodes.trace.checks):  # the first failed check decides the status
        value = nodes.value(check.value)
        passes = lanes.compare("ogt", value, lanes.constant(check.threshold))
        code = lanes.splat("i64", check.code)
        status = lanes.choose(passes, lanes.integer, status, code)
    return status


def zero_if_finite(lanes: Lanes, values: Sequence[str]) -> str:
    """Sum of all values times zero, in four chains: NaN if one is not finite, else zero."""
    zero = lanes.constant(0.0)
    chains = [zero] * 4
    for k, value in enumerate(values):
        product = lanes.arithmetic("fmul", value, zero)
        chains[k % 4] = lanes.arithmetic("fadd", chains[k % 4], product)
    first = lanes.arithmetic("fadd", chains[0], chains[1])
    second = lanes.arithmetic("fadd", chains[2], chains[3])
    return lanes.arithmetic("fadd", first, second)


def path_function(trace: Trace) -> str:
    """`@path(n, a0, ..., o0, ..., status)`: rows that each start from the previous one.

    The first input has a row for each state. The last inputs, as many as there are outputs, are
    what the row before put out; the arguments are for the first row. It ends at the first row
    without an answer.
    """
    outs = len(trace.layout)
    shared = len(trace.inputs) - outs
    parameters = ["i64 %n", *_parameters(trace), *outs_of(trace), "ptr %status"]
    f = Function(f"define internal void @path({', '.join(parameters)}) noinline")
    working = f.slot("i1")
    f.store("true", working, kind="i1", align=1)
    with f.loop(0, "%n", while_=working) as row:
        is_first = f.let(f"icmp eq i64 {row}, 0")
        before = f.let(f"sub i64 {row}, 1")
        places = [f.row("%a0", row, trace.inputs[0])]
        places += [f"%a{v}" for v in range(1, shared)]
        for k, size in enumerate(sizes(trace)):
            previous = f.row(f"%o{k}", before, size)
            start = f"%a{shared + k}"
            places.append(f.let(f"select i1 {is_first}, ptr {start}, ptr {previous}"))
        places += output_rows(f, trace, row)
        status = f.let(f"call i64 @one({pointers(places)})")
        f.store(status, "%status", row, kind="i64")
        is_good = f.let(f"icmp eq i64 {status}, {GOOD}")
        f.store(is_good, working, kind="i1", align=1)
    f.do("ret void")
    return f.text()


def pointers(places: Sequence[str]) -> str:
    """The arguments of a call for some addresses."""
    return ", ".join(f"ptr {place}" for place in places)


def input_row(f: Function, vector: int, row: str) -> str:
    """Address of a row of an input; the stride makes it the same for a shared vector."""
    offset = f.let(f"mul i64 {row}, %stride{vector}")
    return f.at(f"%a{vector}", offset)


def output_rows(f: Function, trace: Trace, row: str) -> list[str]:
    """Addresses of a row of each output."""
    return [f.row(f"%o{k}", row, size) for k, size in enumerate(sizes(trace))]
