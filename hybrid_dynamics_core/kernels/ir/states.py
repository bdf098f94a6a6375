"""A whole trace as functions: `@one` for a state, `@rows` for many, several of them side by side.

Arguments are pointers to the input vectors and to the named outputs. The status of a state is 0,
the code of the first check that fails, or NOT_FINITE.
"""

from __future__ import annotations

import math

from ..graph import Symbol
from ..status import NOT_FINITE
from ..trace import Trace
from .blocks import call_block, fetch_input
from .nodes import Nodes
from .parts import Parts
from .text import Function, Lanes

# states whose inputs are gathered at a time: several vectors' worth, still in the first cache
BLOCK = 64


def sizes(trace: Trace) -> list[int]:
    """Number of values of each named output."""
    return [math.prod(shape) for _, shape in trace.layout]


def _parameters(trace: Trace) -> list[str]:
    return [f"ptr %a{v}" for v in range(len(trace.inputs))]


def _outs(trace: Trace) -> list[str]:
    return [f"ptr %o{k}" for k in range(len(trace.layout))]


def one_functions(trace: Trace) -> list[str]:
    """`@one(a0, ..., o0, ...)`: fill the outputs of a state, return its status; after the parts that it calls."""
    parts = Parts(trace, 1, "one", _parameters(trace), fetch_input(trace))
    f = Function(
        f"define internal i64 @one({', '.join(_parameters(trace) + _outs(trace))}) alwaysinline"
    )
    nodes = parts.nodes(Lanes(f, 1), call_block)
    inputs = [f.load(f"%a{v}", k) for v, k in _read(trace)]
    status = _status(nodes, inputs)
    values = iter(trace.outputs)
    for k, size in enumerate(sizes(trace)):
        for j in range(size):
            f.store(nodes.value(next(values)), f"%o{k}", j)
    f.do(f"ret i64 {status}")
    return [*parts.functions(call_block), f.text()]


def _read(trace: Trace) -> list[tuple[int, int]]:
    """Input components that are looked at: all of the vectors of which any is used."""
    vectors = {v for v, _ in trace.used_inputs()}
    return [(v, k) for v in sorted(vectors) for k in range(trace.inputs[v])]


def _status(nodes: Nodes, inputs: list[str]) -> str:
    """Status of each lane."""
    lanes, trace = nodes.lanes, nodes.trace
    finite = lanes.compare("oeq", _not_finite(nodes, inputs), lanes.constant(0.0))
    status = lanes.choose(
        finite, lanes.integer, lanes.spread("i64", 0), lanes.spread("i64", NOT_FINITE)
    )
    for check in reversed(trace.checks):  # the first check that fails names the status
        good = lanes.compare("ogt", nodes.value(check.value), lanes.constant(check.threshold))
        status = lanes.choose(good, lanes.integer, status, lanes.spread("i64", check.code))
    return status


def _not_finite(nodes: Nodes, inputs: list[str]) -> str:
    """Zero, but NaN where an input or output is not finite: each times zero, summed in four chains."""
    lanes = nodes.lanes
    results = {o.index: nodes.value(o) for o in nodes.trace.outputs if isinstance(o, Symbol)}
    zero = lanes.constant(0.0)
    chains = [zero] * 4
    for k, value in enumerate([*inputs, *results.values()]):
        chains[k % 4] = lanes.arithmetic(
            "fadd", chains[k % 4], lanes.arithmetic("fmul", value, zero)
        )
    first, second = (lanes.arithmetic("fadd", a, b) for a, b in (chains[:2], chains[2:]))
    return lanes.arithmetic("fadd", first, second)


def wide_functions(trace: Trace, width: int) -> list[str]:
    """`@wide(in, o0, ..., status)`: `width` states at once.

    Inputs come by component, outputs go to rows.
    """
    column = {key: n for n, key in enumerate(_read(trace))}

    def fetch(lanes: Lanes, index: int) -> str:
        _, vector, component = trace.graph.nodes[index]
        return _load_column(lanes, column[int(vector), int(component)])

    parts = Parts(trace, width, "wide", ["ptr %in"], fetch)
    f = Function(
        f"define internal void @wide({', '.join(['ptr %in', *_outs(trace), 'ptr %status'])})"
        " noinline"
    )
    lanes = Lanes(f, width)
    nodes = parts.nodes(lanes, call_block)
    inputs = [_load_column(lanes, n) for n in column.values()]
    f.do(f"store {lanes.integer} {_status(nodes, inputs)}, ptr %status, align 8")
    values = iter(trace.outputs)
    for k, size in enumerate(sizes(trace)):
        for j in range(size):
            value = nodes.value(next(values))
            for lane in range(width):
                f.store(
                    f.let(f"extractelement {lanes.kind} {value}, i64 {lane}"),
                    f"%o{k}",
                    lane * size + j,
                )
    f.do("ret void")
    return [*parts.functions(call_block), f.text()]


def _load_column(lanes: Lanes, number: int) -> str:
    place = lanes.function.at("%in", BLOCK * number)
    return lanes.function.let(f"load {lanes.kind}, ptr {place}, align 8")


def rows_function(trace: Trace, width: int) -> str:
    """`@rows(n, a0, stride0, ..., o0, ..., status)`: n states; a stride (in numbers) is 0 where all share a vector."""
    strided = "".join(f"ptr %a{v}, i64 %stride{v}, " for v in range(len(trace.inputs)))
    outs = "".join(f"ptr %o{k}, " for k in range(len(trace.layout)))
    f = Function(f"define internal void @rows(i64 %n, {strided}{outs}ptr %status) noinline")
    if width == 1:
        _row_by_row(f, trace)
    else:
        _blocks(f, trace, width)
    f.do("ret void")
    return f.text()


def _row_by_row(f: Function, trace: Trace) -> None:
    with f.loop(0, "%n") as row:
        places = [
            f.at(f"%a{v}", f.let(f"mul i64 {row}, %stride{v}")) for v in range(len(trace.inputs))
        ]
        places += [
            f.at(f"%o{k}", f.let(f"mul i64 {row}, {size}")) for k, size in enumerate(sizes(trace))
        ]
        status = f.let(f"call i64 @one({', '.join(f'ptr {p}' for p in places)})")
        f.store(status, "%status", row, kind="i64")


def _blocks(f: Function, trace: Trace, width: int) -> None:
    read = _read(trace)
    columns = f.slot("double", BLOCK * len(read))
    spare = [f.slot("double", width * size) for size in sizes(trace)]
    spare_status = f.slot("i64", width)
    last = f.let("sub i64 %n, 1")
    _gather(f, read, columns, "0", last, sorted({v for v, _ in read}))
    with f.loop(0, "%n", BLOCK) as start:
        for v in sorted({v for v, _ in read}):
            with f.when(f.let(f"icmp ne i64 %stride{v}, 0")):
                _gather(f, read, columns, start, last, [v])
        left = f.let(f"sub i64 %n, {start}")
        short = f.let(f"icmp slt i64 {left}, {BLOCK}")
        with f.loop(0, f.let(f"select i1 {short}, i64 {left}, i64 {BLOCK}"), width) as first:
            row, rest = f.let(f"add i64 {start}, {first}"), f.let(f"sub i64 {left}, {first}")
            whole, part, on = f.label(), f.label(), f.label()
            f.branch(f.let(f"icmp sge i64 {rest}, {width}"), whole, part)
            f.begin(whole)
            places = [
                f.at(f"%o{k}", f.let(f"mul i64 {row}, {size}"))
                for k, size in enumerate(sizes(trace))
            ]
            _call_wide(f, f.at(columns, first), places, f.at("%status", row, kind="i64"))
            f.do(f"br label %{on}")
            f.begin(part)
            _call_wide(f, f.at(columns, first), spare, spare_status)
            with f.loop(0, rest) as k:
                to = f.let(f"add i64 {row}, {k}")
                f.store(f.load(spare_status, k, kind="i64"), "%status", to, kind="i64")
                for number, size in enumerate(sizes(trace)):
                    _copy(f, spare[number], k, f"%o{number}", to, size)
            f.do(f"br label %{on}")
            f.begin(on)


def _gather(
    f: Function,
    read: list[tuple[int, int]],
    columns: str,
    start: str,
    last: str,
    vectors: list[int],
) -> None:
    """Put a block of states of some input vectors into columns; lanes after the last state repeat it."""
    with f.loop(0, BLOCK) as lane:
        row = f.let(f"add i64 {start}, {lane}")
        over = f.let(f"icmp sgt i64 {row}, {last}")
        row = f.let(f"select i1 {over}, i64 {last}, i64 {row}")
        for v in vectors:
            place = f.at(f"%a{v}", f.let(f"mul i64 {row}, %stride{v}"))
            for n, (vector, k) in enumerate(read):
                if vector == v:
                    f.store(f.load(place, k), columns, n * BLOCK, lane)


def _call_wide(f: Function, columns: str, outs: list[str], status: str) -> None:
    f.do(f"call void @wide({', '.join(f'ptr {p}' for p in (columns, *outs, status))})")


def _copy(
    f: Function, source: str, source_row: str, target: str, target_row: str, size: int
) -> None:
    if size:
        a, b = (f.let(f"mul i64 {row}, {size}") for row in (source_row, target_row))
        with f.loop(0, size) as j:
            f.store(f.load(source, a, j), target, b, j)
