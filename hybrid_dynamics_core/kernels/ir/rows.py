"""Functions for many states: `@rows`, and `@wide` for a vector of states.

Inputs are transposed a vector of states at a time. So memory is read beside the computation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..trace import Trace
from .blocks import call_block
from .parts import Parts
from .states import (
    input_row,
    output_rows,
    outs_of,
    pointers,
    read_inputs,
    sizes,
    status_of,
    zero_if_finite,
)
from .text import ALIGNED, Function, Lanes
from .transpose import load_columns, pieces, store_rows

_LINE = 64  # [bytes] alignment of a column


class Columns:
    """Places of the columns that `@wide` reads, in numbers; a column is a vector of states.

    There is one for each component of the inputs. A last one for each input is its test: zero, or
    NaN where a component is not finite.

    Attributes:
        inputs: the inputs that are read.
    """

    def __init__(self, trace: Trace, width: int) -> None:
        components = read_inputs(trace)
        self.inputs = sorted({vector for vector, _ in components})
        self._width = width
        self._places: dict[tuple[int, int | str], int] = {}
        for vector, component in components:
            self._add(vector, component)
        for vector in self.inputs:
            self._add(vector, "test")

    def _add(self, vector: int, what: int | str) -> None:
        self._places[vector, what] = self.length

    @property
    def length(self) -> int:
        """Numbers in all columns."""
        return self._width * len(self._places)

    def component(self, vector: int, component: int) -> int:
        """Place of a component of an input."""
        return self._places[vector, component]

    def test(self, vector: int) -> int:
        """Place of the test of an input."""
        return self._places[vector, "test"]


def wide_functions(trace: Trace, width: int) -> list[str]:
    """`@wide(in, o0, ..., status)`: computes `width` states at once.

    Inputs lie by component, as `Columns` has it, outputs by row.
    """
    columns = Columns(trace, width)

    def fetch(lanes: Lanes, index: int) -> str:
        _, vector, component = trace.graph.nodes[index]
        place = columns.component(int(vector), int(component))
        return _load_column(lanes, place)

    parts = Parts(trace, width, "wide", ["ptr %in"], fetch)
    parameters = ", ".join(["ptr %in", *outs_of(trace), "ptr %status"])
    f = Function(f"define internal void @wide({parameters}) {ALIGNED}")
    lanes = Lanes(f, width)
    nodes = parts.nodes(lanes, call_block)
    tests: list[str] = []
    for vector in columns.inputs:
        test = _load_column(lanes, columns.test(vector))
        tests.append(test)
    status = status_of(nodes, tests)
    f.do(f"store {lanes.integer} {status}, ptr %status, align 8")
    values = list(map(nodes.value, trace.outputs))
    for number, size in enumerate(sizes(trace)):
        for first, length in pieces(size, width):
            piece = values[first : first + length]
            store_rows(f, piece, f"%o{number}", size, first, width)
        del values[:size]
    f.do("ret void")
    return [*parts.functions(call_block), f.text()]


def _load_column(lanes: Lanes, place: int) -> str:
    f = lanes.function
    address = f.at("%in", place)
    return f.let(f"load {lanes.kind}, ptr {address}, align {_LINE}")


def rows_function(trace: Trace, width: int) -> str:
    """`@rows(n, a0, stride0, ..., o0, ..., status)`: computes n states.

    A stride [numbers] is 0 if all states share a vector.
    """
    parameters = ["i64 %n"]
    for v in range(len(trace.inputs)):
        parameters += [f"ptr %a{v}", f"i64 %stride{v}"]
    parameters += [*outs_of(trace), "ptr %status"]
    f = Function(f"define internal void @rows({', '.join(parameters)}) noinline")
    if width == 1:
        _row_by_row(f, trace)
    else:
        _Vectors(f, trace, width).write()
    f.do("ret void")
    return f.text()


def _row_by_row(f: Function, trace: Trace) -> None:
    with f.loop(0, "%n") as row:
        places = [input_row(f, v, row) for v in range(len(trace.inputs))]
        places += output_rows(f, trace, row)
        status = f.let(f"call i64 @one({pointers(places)})")
        f.store(status, "%status", row, kind="i64")


class _Vectors:
    """Computation in vectors of states."""

    def __init__(self, f: Function, trace: Trace, width: int) -> None:
        self._f = f
        self._trace = trace
        self._width = width
        self._lanes = Lanes(f, width)
        self._places = Columns(trace, width)
        self._columns = f.slot("double", self._places.length)
        self._last = f.let("sub i64 %n, 1")

    def write(self) -> None:
        f = self._f
        for vector in self._places.inputs:
            with f.when(f.let(f"icmp eq i64 %stride{vector}, 0")):
                self._broadcast(vector)
        surplus = f.let(f"srem i64 %n, {self._width}")
        full = f.let(f"sub i64 %n, {surplus}")
        with f.loop(0, full, self._width) as row:
            self._read(row, self._transpose)
            status = f.at("%status", row, kind="i64")
            self._compute([*output_rows(f, self._trace, row), status])
        with f.when(f.let(f"icmp ne i64 {surplus}, 0")):
            self._last_vector(full, surplus)

    def _read(self, row: str, copy: Callable[[str, int], None]) -> None:
        """Copy the inputs of a vector of states to columns, except for shared ones."""
        f = self._f
        for vector in self._places.inputs:
            with f.when(f.let(f"icmp ne i64 %stride{vector}, 0")):
                copy(row, vector)

    def _broadcast(self, vector: int) -> None:
        """Copy an input that all states share."""
        values: list[str] = []
        for k in range(self._trace.inputs[vector]):
            number = self._f.load(f"%a{vector}", k)
            values.append(self._lanes.broadcast(number))
        self._store(vector, values)

    def _transpose(self, row: str, vector: int) -> None:
        """Copy an input of a full vector of states."""
        f, width = self._f, self._width
        size = self._trace.inputs[vector]
        table = f.row(f"%a{vector}", row, size)
        values: list[str] = []
        for piece in pieces(size, width):
            values += load_columns(f, table, size, piece, width)
        self._store(vector, values)

    def _store(self, vector: int, values: Sequence[str]) -> None:
        """Store the columns of an input."""
        for k, value in enumerate(values):
            place = self._places.component(vector, k)
            self._store_column(place, value)
        test = zero_if_finite(self._lanes, values)
        self._store_column(self._places.test(vector), test)

    def _store_column(self, place: int, value: str) -> None:
        address = self._f.at(self._columns, place)
        kind = self._lanes.kind
        self._f.do(f"store {kind} {value}, ptr {address}, align {_LINE}")

    def _compute(self, targets: Sequence[str]) -> None:
        """Compute a vector of states; the targets are outputs and status."""
        arguments = pointers([self._columns, *targets])
        self._f.do(f"call void @wide({arguments})")

    def _last_vector(self, row: str, count: str) -> None:
        """A vector with fewer states, filled by the last one, whose copies are thrown away."""
        f, width = self._f, self._width
        lengths = sizes(self._trace)
        results = [f.slot("double", width * size) for size in lengths]
        codes = f.slot("i64", width)
        self._read(row, self._gather)
        self._compute([*results, codes])
        with f.loop(0, count) as k:
            target = f.let(f"add i64 {row}, {k}")
            status = f.load(codes, k, kind="i64")
            f.store(status, "%status", target, kind="i64")
            for number, size in enumerate(lengths):
                source = f.row(results[number], k, size)
                place = f.row(f"%o{number}", target, size)
                self._copy(source, place, size)

    def _gather(self, row: str, vector: int) -> None:
        """Copy an input of the states up to the last one, number by number."""
        f, places = self._f, self._places
        single = Lanes(f, 1)
        with f.loop(0, self._width) as lane:
            state = f.let(f"add i64 {row}, {lane}")
            is_beyond = f.let(f"icmp sgt i64 {state}, {self._last}")
            state = f.let(f"select i1 {is_beyond}, i64 {self._last}, i64 {state}")
            source = input_row(f, vector, state)
            values: list[str] = []
            for k in range(self._trace.inputs[vector]):
                value = f.load(source, k)
                f.store(value, self._columns, places.component(vector, k), lane)
                values.append(value)
            test = zero_if_finite(single, values)
            f.store(test, self._columns, places.test(vector), lane)

    def _copy(self, source: str, target: str, size: int) -> None:
        """Copy some numbers."""
        f = self._f
        with f.loop(0, size) as k:
            value = f.load(source, k)
            f.store(value, target, k)
