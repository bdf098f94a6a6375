"""Functions for a whole trace: `@one` for a state, `@rows` for many, in vectors of states.

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
from .transpose import load_columns, pieces, store_rows

# states gathered at a time: several vectors, which fit into the first-level cache
BLOCK = 64


def sizes(trace: Trace) -> list[int]:
    """Number of values of each named output."""
    return [math.prod(shape) for _, shape in trace.layout]


def _parameters(trace: Trace) -> list[str]:
    return [f"ptr %a{v}" for v in range(len(trace.inputs))]


def _outs(trace: Trace) -> list[str]:
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
    arguments = ", ".join(parameters + _outs(trace))
    f = Function(f"define internal i64 @one({arguments}) noinline")
    nodes = parts.nodes(Lanes(f, 1), call_block)
    inputs = [f.load(f"%a{v}", k) for v, k in _read(trace)]
    status = _status(nodes, inputs)
    for output, (number, place) in zip(trace.outputs, _places(trace), strict=True):
        value = nodes.value(output)
        f.store(value, f"%o{number}", place)
    f.do(f"ret i64 {status}")
    return [*parts.functions(call_block), f.text()]


def _read(trace: Trace) -> list[tuple[int, int]]:
    """All components of the input vectors that are used."""
    vectors = {v for v, _ in trace.used_inputs()}
    components = []
    for v in sorted(vectors):
        components += [(v, k) for k in range(trace.inputs[v])]
    return components


def _status(nodes: Nodes, inputs: list[str]) -> str:
    """Status of each lane."""
    lanes = nodes.lanes
    total = _not_finite(nodes, inputs)
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


def _not_finite(nodes: Nodes, inputs: list[str]) -> str:
    """Sum of all numbers times zero, in four chains: NaN if a number is not finite, or zero."""
    lanes = nodes.lanes
    results: dict[int, str] = {}  # without duplicates
    for output in nodes.trace.outputs:
        if isinstance(output, Symbol):
            results[output.index] = nodes.value(output)
    zero = lanes.constant(0.0)
    chains = [zero] * 4
    for k, value in enumerate([*inputs, *results.values()]):
        product = lanes.arithmetic("fmul", value, zero)
        chains[k % 4] = lanes.arithmetic("fadd", chains[k % 4], product)
    first = lanes.arithmetic("fadd", chains[0], chains[1])
    second = lanes.arithmetic("fadd", chains[2], chains[3])
    return lanes.arithmetic("fadd", first, second)


def wide_functions(trace: Trace, width: int) -> list[str]:
    """`@wide(in, o0, ..., status)`: computes `width` states at once.

    Inputs are stored by component, outputs by row.
    """
    components = _read(trace)
    columns = {key: n for n, key in enumerate(components)}

    def fetch(lanes: Lanes, index: int) -> str:
        _, vector, component = trace.graph.nodes[index]
        return _load_column(lanes, columns[int(vector), int(component)])

    parts = Parts(trace, width, "wide", ["ptr %in"], fetch)
    parameters = ", ".join(["ptr %in", *_outs(trace), "ptr %status"])
    f = Function(f"define internal void @wide({parameters}) noinline")
    lanes = Lanes(f, width)
    nodes = parts.nodes(lanes, call_block)
    inputs = [_load_column(lanes, n) for n in range(len(components))]
    status = _status(nodes, inputs)
    f.do(f"store {lanes.integer} {status}, ptr %status, align 8")
    values = [nodes.value(output) for output in trace.outputs]
    for number, size in enumerate(sizes(trace)):
        for first, length in pieces(size, width):
            store_rows(f, values[first : first + length], f"%o{number}", size, first, width)
        values = values[size:]
    f.do("ret void")
    return [*parts.functions(call_block), f.text()]


def _load_column(lanes: Lanes, number: int) -> str:
    place = lanes.function.at("%in", BLOCK * number)
    return lanes.function.let(f"load {lanes.kind}, ptr {place}, align 8")


def rows_function(trace: Trace, width: int) -> str:
    """`@rows(n, a0, stride0, ..., o0, ..., status)`: computes n states.

    A stride [numbers] is 0 if all states share a vector.
    """
    parameters = ["i64 %n"]
    for v in range(len(trace.inputs)):
        parameters += [f"ptr %a{v}", f"i64 %stride{v}"]
    parameters += [*_outs(trace), "ptr %status"]
    f = Function(f"define internal void @rows({', '.join(parameters)}) noinline")
    if width == 1:
        _row_by_row(f, trace)
    else:
        _Blocks(f, trace, width).write()
    f.do("ret void")
    return f.text()


def _row_by_row(f: Function, trace: Trace) -> None:
    with f.loop(0, "%n") as row:
        places = [_input_row(f, v, row) for v in range(len(trace.inputs))]
        places += _output_rows(f, trace, row)
        status = f.let(f"call i64 @one({_pointers(places)})")
        f.store(status, "%status", row, kind="i64")


def path_function(trace: Trace) -> str:
    """`@path(n, a0, ..., o0, ..., status)`: rows that each start from the previous one.

    The first input has a row for each state. The last inputs, as many as there are outputs, are
    what the row before put out; the arguments are for the first row. It ends at the first row
    without an answer.
    """
    outs = len(trace.layout)
    shared = len(trace.inputs) - outs
    parameters = ["i64 %n", *_parameters(trace), *_outs(trace), "ptr %status"]
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
        places += _output_rows(f, trace, row)
        status = f.let(f"call i64 @one({_pointers(places)})")
        f.store(status, "%status", row, kind="i64")
        is_good = f.let(f"icmp eq i64 {status}, {GOOD}")
        f.store(is_good, working, kind="i1", align=1)
    f.do("ret void")
    return f.text()


def _pointers(places: Sequence[str]) -> str:
    """The arguments of a call for some addresses."""
    return ", ".join(f"ptr {place}" for place in places)


def _input_row(f: Function, vector: int, row: str) -> str:
    """Address of a row of an input; the stride makes it the same for a shared vector."""
    offset = f.let(f"mul i64 {row}, %stride{vector}")
    return f.at(f"%a{vector}", offset)


def _output_rows(f: Function, trace: Trace, row: str) -> list[str]:
    """Addresses of a row of each output."""
    return [f.row(f"%o{k}", row, size) for k, size in enumerate(sizes(trace))]


class _Blocks:
    """Computation in blocks of states, whose inputs are gathered by component."""

    def __init__(self, f: Function, trace: Trace, width: int) -> None:
        self.f = f
        self.trace = trace
        self.width = width
        self.read = _read(trace)
        self.columns = f.slot("double", BLOCK * len(self.read))
        self.sizes = sizes(trace)
        # receives the surplus results of the last vector
        self.spare = [f.slot("double", width * size) for size in self.sizes]
        self.spare_status = f.slot("i64", width)
        self.last = f.let("sub i64 %n, 1")

    def write(self) -> None:
        f = self.f
        vectors = sorted({v for v, _ in self.read})
        for v in vectors:
            is_shared = f.let(f"icmp eq i64 %stride{v}, 0")
            with f.when(is_shared), f.loop(0, BLOCK) as lane:
                self._gather_state("0", lane, v)
        with f.loop(0, "%n", BLOCK) as start:
            remaining = f.let(f"sub i64 %n, {start}")
            is_short = f.let(f"icmp slt i64 {remaining}, {BLOCK}")
            length = f.let(f"select i1 {is_short}, i64 {remaining}, i64 {BLOCK}")
            for v in vectors:
                varies = f.let(f"icmp ne i64 %stride{v}, 0")
                with f.when(varies), f.loop(0, length, self.width) as first:
                    self._gather(start, first, v)
            with f.loop(0, length, self.width) as first:
                self._vector(start, first, remaining)

    def _gather(self, start: str, first: str, vector: int) -> None:
        """Copy an input of a vector of states to columns; the last state is repeated to fill it."""
        f = self.f
        row = f.let(f"add i64 {start}, {first}")
        beyond = f.let(f"add i64 {row}, {self.width}")
        is_full = f.let(f"icmp sle i64 {beyond}, %n")
        full, part, on = f.label(), f.label(), f.label()
        f.branch(is_full, full, part)
        f.begin(full)
        size = self.trace.inputs[vector]
        table = f.row(f"%a{vector}", row, size)
        column = self.read.index((vector, 0))
        for piece in pieces(size, self.width):
            for value in load_columns(f, table, size, piece, self.width):
                place = f.at(self.columns, column * BLOCK, first)
                f.do(f"store <{self.width} x double> {value}, ptr {place}, align 8")
                column += 1
        f.do(f"br label %{on}")
        f.begin(part)
        with f.loop(0, self.width) as k:
            lane = f.let(f"add i64 {first}, {k}")
            self._gather_state(start, lane, vector)
        f.do(f"br label %{on}")
        f.begin(on)

    def _gather_state(self, start: str, lane: str, vector: int) -> None:
        """Copy an input of one state to columns."""
        f = self.f
        row = f.let(f"add i64 {start}, {lane}")
        is_beyond = f.let(f"icmp sgt i64 {row}, {self.last}")
        row = f.let(f"select i1 {is_beyond}, i64 {self.last}, i64 {row}")
        place = _input_row(f, vector, row)
        for n, (v, k) in enumerate(self.read):
            if v == vector:
                f.store(f.load(place, k), self.columns, n * BLOCK, lane)

    def _vector(self, start: str, first: str, remaining: str) -> None:
        """Compute a vector of states from `first`; an incomplete one writes to spare memory."""
        f = self.f
        row = f.let(f"add i64 {start}, {first}")
        count = f.let(f"sub i64 {remaining}, {first}")
        full, part, on = f.label(), f.label(), f.label()
        is_full = f.let(f"icmp sge i64 {count}, {self.width}")
        f.branch(is_full, full, part)
        f.begin(full)
        places = _output_rows(f, self.trace, row)
        self._call_wide(first, places, "%status", row)
        f.do(f"br label %{on}")
        f.begin(part)
        self._call_wide(first, self.spare, self.spare_status)
        with f.loop(0, count) as k:
            target = f.let(f"add i64 {row}, {k}")
            status = f.load(self.spare_status, k, kind="i64")
            f.store(status, "%status", target, kind="i64")
            for number, size in enumerate(self.sizes):
                self._copy(self.spare[number], k, f"%o{number}", target, size)
        f.do(f"br label %{on}")
        f.begin(on)

    def _call_wide(self, first: str, outs: list[str], status: str, *row: str) -> None:
        f = self.f
        columns = f.at(self.columns, first)
        target = f.at(status, *row, kind="i64")
        f.do(f"call void @wide({_pointers([columns, *outs, target])})")

    def _copy(self, source: str, source_row: str, target: str, target_row: str, size: int) -> None:
        f = self.f
        if size:
            first = f.product(source_row, size)
            target_first = f.product(target_row, size)
            with f.loop(0, size) as j:
                value = f.load(source, first, j)
                f.store(value, target, target_first, j)
