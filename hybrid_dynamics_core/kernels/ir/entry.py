"""Entry functions for Python, which check arrays and read them in place.

Nothing is converted or allocated. `self` is an array of addresses of this process (`Address`). An
array must be exactly numpy.ndarray, float64 in native byte order, of the right shape, in C order
and aligned, and writable if it is an output. The result is a status as a Python integer.
`NOT_TAKEN` means that an argument is different, and nothing was computed.
"""

from __future__ import annotations

from enum import IntEnum
from itertools import product
from typing import NamedTuple

from ..status import NOT_TAKEN
from ..trace import Trace
from .states import sizes
from .text import Function

_ORDER = 0x0001 | 0x0100  # flags C_CONTIGUOUS and ALIGNED of an array
_WRITABLE = 0x0400


class Address(IntEnum):
    """Indices of the addresses in `self`."""

    ARRAY_TYPE = 0
    FLOAT64 = 1
    INT64 = 2


class Header:
    """Offsets of the fields of an array object, in bytes.

    Attributes:
        size: size of the header of every Python object.
        type: type of the object.
        data: address of the first number.
        ndim: number of axes.
        dims: address of the lengths.
        descr: address of the type of the numbers.
        flags: bits for order and alignment.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.type = size - 8
        self.data = size
        self.ndim = size + 8
        self.dims = size + 16
        self.descr = size + 40
        self.flags = size + 48


class Range(NamedTuple):
    """Memory: the name of its address, and its size in bytes."""

    start: str
    size: int


DECLARATIONS = """
declare ptr @PyLong_FromLongLong(i64)
declare ptr @PyEval_SaveThread()
declare void @PyEval_RestoreThread(ptr)
"""


PARAMETERS = "ptr %self, ptr %args, i64 %count"


class Entry:
    """Writer of a function that checks its arguments in order; `finish` ends it."""

    def __init__(self, name: str, header: Header, parameters: str = PARAMETERS) -> None:
        self.f = Function(f"define ptr @{name}({parameters})")
        self.header = header
        self.not_taken = self.f.label()
        self.addresses = self.field("%self", header.data)

    @classmethod
    def counted(cls, name: str, arguments: int, header: Header) -> Entry:
        """The writer of a function with a number of arguments."""
        entry = cls(name, header)
        entry.require(f"icmp eq i64 %count, {arguments}")
        return entry

    def field(self, thing: str, offset: int, kind: str = "ptr") -> str:
        """The value at an offset [bytes] after a pointer."""
        place = self.f.let(f"getelementptr i8, ptr {thing}, i64 {offset}")
        alignment = 4 if kind == "i32" else 8
        return self.f.let(f"load {kind}, ptr {place}, align {alignment}")

    def require(self, *conditions: str) -> None:
        """Continue only if all conditions hold."""
        f = self.f
        holds = f.let(conditions[0])
        for condition in conditions[1:]:
            also = f.let(condition)
            holds = f.let(f"and i1 {holds}, {also}")
        on = f.label()
        f.branch(holds, on, self.not_taken)
        f.begin(on)

    def argument(self, number: int | str, kind: Address, writable: bool) -> str:
        """Argument `number`, checked for its type; its shape is checked later."""
        f, header = self.f, self.header
        place = f.at("%args", number, kind="ptr")
        thing = f.let(f"load ptr, ptr {place}, align 8")
        actual = self.field(thing, header.type)
        expected = f.load(self.addresses, Address.ARRAY_TYPE, kind="ptr")
        self.require(f"icmp eq ptr {actual}, {expected}")
        flags = _ORDER
        if writable:
            flags |= _WRITABLE
        actual = self.field(thing, header.descr)
        bits = self.field(thing, header.flags, "i32")
        expected = f.load(self.addresses, kind, kind="ptr")
        bits = f.let(f"and i32 {bits}, {flags}")
        self.require(f"icmp eq ptr {actual}, {expected}", f"icmp eq i32 {bits}, {flags}")
        return thing

    def array(self, number: int | str, shape: list[int | str], writable: bool) -> str:
        """The data of argument `number`, an array of doubles of a shape."""
        thing = self.argument(number, Address.FLOAT64, writable)
        return self.data(thing, shape)

    def data(self, thing: str, shape: list[int | str]) -> str:
        """The data of an array, checked for its shape."""
        self._require_rank(thing, len(shape))
        if shape:
            lengths = self._lengths(thing, len(shape))
            pairs = zip(lengths, shape, strict=True)
            self.require(*(f"icmp eq i64 {length}, {size}" for length, size in pairs))
        return self.field(thing, self.header.data)

    def lengths(self, number: int, rank: int) -> list[str]:
        """The shape of argument `number`, an array with `rank` axes."""
        thing = self.argument(number, Address.FLOAT64, writable=False)
        return self.shape(thing, rank)

    def shape(self, thing: str, rank: int) -> list[str]:
        """The shape of an array, checked for its number of axes."""
        self._require_rank(thing, rank)
        return self._lengths(thing, rank)

    def _require_rank(self, thing: str, rank: int) -> None:
        actual = self.field(thing, self.header.ndim, "i32")
        self.require(f"icmp eq i32 {actual}, {rank}")

    def _lengths(self, thing: str, rank: int) -> list[str]:
        dims = self.field(thing, self.header.dims)
        return [self.f.load(dims, axis, kind="i64") for axis in range(rank)]

    def shared_or_rows(self, number: int, size: int, rows: str) -> tuple[str, str]:
        """An input (size,) or (rows, size).

        Returns:
            The data, and the stride from state to state in numbers.
        """
        f = self.f
        thing = self.argument(number, Address.FLOAT64, writable=False)
        rank = self.field(thing, self.header.ndim, "i32")
        dims = self.field(thing, self.header.dims)
        is_vector = f.let(f"icmp eq i32 {rank}, 1")
        is_table = f.let(f"icmp eq i32 {rank}, 2")
        self.require(f"or i1 {is_vector}, {is_table}")
        axis = f.let(f"select i1 {is_vector}, i64 0, i64 1")
        last = f.load(dims, axis, kind="i64")
        first = f.load(dims, kind="i64")
        count = f.let(f"select i1 {is_vector}, i64 {rows}, i64 {first}")
        self.require(f"icmp eq i64 {last}, {size}", f"icmp eq i64 {count}, {rows}")
        data = self.field(thing, self.header.data)
        stride = f.let(f"select i1 {is_vector}, i64 0, i64 {size}")
        return data, stride

    def require_apart(self, inputs: list[tuple[str, int]], outs: list[tuple[str, int]]) -> None:
        """Require that no output overlaps an input, since a fallback may read the inputs again.

        Args:
            inputs: pointers, and numbers of doubles.
            outs: the same.
        """
        input_ranges = [self._range(pointer, size) for pointer, size in inputs]
        out_ranges = [self._range(pointer, size) for pointer, size in outs]
        conditions = []
        for a, out in product(input_ranges, out_ranges):
            if a.size and out.size:
                is_after = self._is_beyond(a, out)
                is_before = self._is_beyond(out, a)
                conditions.append(f"or i1 {is_before}, {is_after}")
        if conditions:
            self.require(*conditions)

    def _range(self, pointer: str, size: int) -> Range:
        start = self.f.let(f"ptrtoint ptr {pointer} to i64")
        return Range(start, 8 * size)

    def _is_beyond(self, a: Range, b: Range) -> str:
        """Whether a begins at or after the end of b."""
        end = self.f.let(f"add i64 {b.start}, {b.size}")
        return self.f.let(f"icmp uge i64 {a.start}, {end}")

    def finish(self, status: str) -> str:
        """Return the status; gives the text of the function."""
        self._return(status)
        self.f.begin(self.not_taken)
        self._return(str(NOT_TAKEN))
        return self.f.text()

    def _return(self, status: str) -> None:
        number = self.f.let(f"call ptr @PyLong_FromLongLong(i64 {status})")
        self.f.do(f"ret ptr {number}")


def one_entry(trace: Trace, header: Header) -> str:
    """`call(a0, ..., o0, ...)` for one state: inputs (size,), and outputs to fill."""
    count = len(trace.inputs)
    entry = Entry.counted("call", count + len(trace.layout), header)
    inputs = []
    for k, size in enumerate(trace.inputs):
        inputs.append(entry.array(k, [size], writable=False))
    outs = []
    for k, (_, shape) in enumerate(trace.layout):
        outs.append(entry.array(count + k, list(shape), writable=True))
    sized_inputs = list(zip(inputs, trace.inputs, strict=True))
    sized_outs = list(zip(outs, sizes(trace), strict=True))
    entry.require_apart(sized_inputs, sized_outs)
    arguments = ", ".join(f"ptr {pointer}" for pointer in inputs + outs)
    status = entry.f.let(f"call i64 @one({arguments})")
    return entry.finish(status)


def path_entry(trace: Trace, header: Header) -> str:
    """`call(a0, ..., o0, ..., status)` for rows that each start from the previous one.

    The first input is (N, size), all others are (size,); outputs (N, *shape) and int64 status (N,)
    are filled up to the first row without an answer; the answer is 0.
    """
    inputs, outs = len(trace.inputs), len(trace.layout)
    entry = Entry.counted("call", inputs + outs + 1, header)
    f = entry.f
    status = entry.argument(inputs + outs, Address.INT64, writable=True)
    (n,) = entry.shape(status, 1)
    arguments = [f"i64 {n}"]
    for k, size in enumerate(trace.inputs):
        shape: list[int | str] = [n, size] if k == 0 else [size]
        arguments.append(f"ptr {entry.array(k, shape, writable=False)}")
    for k, (_, shape_of_one) in enumerate(trace.layout):
        pointer = entry.array(inputs + k, [n, *shape_of_one], writable=True)
        arguments.append(f"ptr {pointer}")
    codes = entry.field(status, header.data)
    arguments.append(f"ptr {codes}")
    thread = f.let("call ptr @PyEval_SaveThread()")
    f.do(f"call void @path({', '.join(arguments)})")
    f.do(f"call void @PyEval_RestoreThread(ptr {thread})")
    return entry.finish("0")


def rows_entry(trace: Trace, header: Header) -> str:
    """`call(a0, ..., o0, ..., status)` for many states, without the GIL.

    Inputs are (N, size), or (size,) for all states. Outputs (N, *shape) and int64 status (N,) are
    filled. The result is 0.
    """
    inputs, outs = len(trace.inputs), len(trace.layout)
    entry = Entry.counted("call", inputs + outs + 1, header)
    f = entry.f
    status = entry.argument(inputs + outs, Address.INT64, writable=True)
    (n,) = entry.shape(status, 1)
    arguments = [f"i64 {n}"]
    for k, size in enumerate(trace.inputs):
        pointer, stride = entry.shared_or_rows(k, size, n)
        arguments += [f"ptr {pointer}", f"i64 {stride}"]
    for k, (_, shape) in enumerate(trace.layout):
        pointer = entry.array(inputs + k, [n, *shape], writable=True)
        arguments.append(f"ptr {pointer}")
    codes = entry.field(status, header.data)
    arguments.append(f"ptr {codes}")
    thread = f.let("call ptr @PyEval_SaveThread()")
    is_some = f.let(f"icmp sgt i64 {n}, 0")
    with f.when(is_some):
        f.do(f"call void @rows({', '.join(arguments)})")
    f.do(f"call void @PyEval_RestoreThread(ptr {thread})")
    return entry.finish("0")
