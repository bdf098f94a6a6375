"""Functions that Python calls: arrays are checked and read where they lie, nothing is converted or allocated.

`self` is an array of addresses of this process (`Address`). What an array must be: of the type
numpy.ndarray itself, float64 in the machine's order, of the right shape, in C order, aligned, and
writable where it is filled. The answer is a status as a Python integer; `NOT_TAKEN` says that some
argument is something else, and that nothing was computed.
"""

from __future__ import annotations

from enum import IntEnum

from ..status import NOT_TAKEN
from ..trace import Trace
from .states import sizes
from .text import Function

_ORDER = 0x0001 | 0x0100  # flags C_CONTIGUOUS and ALIGNED of an array
_WRITABLE = 0x0400


class Address(IntEnum):
    """What the entries of `self` point to."""

    ARRAY_TYPE = 0
    FLOAT64 = 1
    INT64 = 2


class Header:
    """Where the fields of an array object lie, in bytes; `size` of the header that every Python object has."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.type, self.data, self.ndim, self.dims = size - 8, size, size + 8, size + 16
        self.descr, self.flags = size + 40, size + 48


DECLARATIONS = """
declare ptr @PyLong_FromLongLong(i64)
declare ptr @PyEval_SaveThread()
declare void @PyEval_RestoreThread(ptr)
"""


class Entry:
    """A function of so many arguments, which are looked at one after the other; `finish` ends it."""

    def __init__(self, name: str, arguments: int, header: Header) -> None:
        self.f = Function(f"define ptr @{name}(ptr %self, ptr %args, i64 %count)")
        self.header = header
        self.refuse = self.f.label()
        self.addresses = self.field("%self", header.data)
        self.require(f"icmp eq i64 %count, {arguments}")

    def field(self, thing: str, offset: int, kind: str = "ptr") -> str:
        """What lies so many bytes after a pointer."""
        place = self.f.let(f"getelementptr i8, ptr {thing}, i64 {offset}")
        return self.f.let(f"load {kind}, ptr {place}, align {4 if kind == 'i32' else 8}")

    def require(self, *conditions: str) -> None:
        """Go on only if all hold."""
        f = self.f
        good = f.let(conditions[0])
        for condition in conditions[1:]:
            good = f.let(f"and i1 {good}, {f.let(condition)}")
        on = f.label()
        f.branch(good, on, self.refuse)
        f.begin(on)

    def argument(self, number: int, kind: Address, writable: bool) -> str:
        """Argument `number`, if it is an array of a type; its shape is not looked at yet."""
        f, header = self.f, self.header
        thing = f.let(f"load ptr, ptr {f.at('%args', number, kind='ptr')}, align 8")
        own, wanted = (
            self.field(thing, header.type),
            f.load(self.addresses, Address.ARRAY_TYPE, kind="ptr"),
        )
        self.require(f"icmp eq ptr {own}, {wanted}")
        flags = _ORDER | (_WRITABLE if writable else 0)
        descr, has = self.field(thing, header.descr), self.field(thing, header.flags, "i32")
        wanted = f.load(self.addresses, kind, kind="ptr")
        masked = f.let(f"and i32 {has}, {flags}")
        self.require(f"icmp eq ptr {descr}, {wanted}", f"icmp eq i32 {masked}, {flags}")
        return thing

    def array(self, number: int, shape: list[int | str], writable: bool) -> str:
        """The data of argument `number`, an array of doubles of a shape."""
        thing = self.argument(number, Address.FLOAT64, writable)
        rank = self.field(thing, self.header.ndim, "i32")
        self.require(f"icmp eq i32 {rank}, {len(shape)}")
        if shape:
            dims = self.field(thing, self.header.dims)
            lengths = [self.f.load(dims, axis, kind="i64") for axis in range(len(shape))]
            self.require(
                *(f"icmp eq i64 {has}, {size}" for has, size in zip(lengths, shape, strict=True))
            )
        return self.field(thing, self.header.data)

    def lengths(self, number: int, rank: int) -> list[str]:
        """The shape of argument `number`, an array of so many axes."""
        thing = self.argument(number, Address.FLOAT64, writable=False)
        self.require(f"icmp eq i32 {self.field(thing, self.header.ndim, 'i32')}, {rank}")
        dims = self.field(thing, self.header.dims)
        return [self.f.load(dims, axis, kind="i64") for axis in range(rank)]

    def shared_or_rows(self, number: int, size: int, rows: str) -> tuple[str, str]:
        """The data of an input (size,) or (rows, size), and its stride from state to state in numbers."""
        f, header = self.f, self.header
        thing = self.argument(number, Address.FLOAT64, writable=False)
        rank, dims = self.field(thing, header.ndim, "i32"), self.field(thing, header.dims)
        single, many = f.let(f"icmp eq i32 {rank}, 1"), f.let(f"icmp eq i32 {rank}, 2")
        self.require(f"or i1 {single}, {many}")
        last = f.load(dims, f.let(f"select i1 {single}, i64 0, i64 1"), kind="i64")
        first = f.load(dims, kind="i64")
        count = f.let(f"select i1 {single}, i64 {rows}, i64 {first}")
        self.require(f"icmp eq i64 {last}, {size}", f"icmp eq i64 {count}, {rows}")
        return self.field(thing, header.data), f.let(f"select i1 {single}, i64 0, i64 {size}")

    def require_apart(self, inputs: list[tuple[str, int]], outs: list[tuple[str, int]]) -> None:
        """No output may lie on an input, which is read again where there is no answer: pointers, and their doubles."""
        f = self.f
        ranges = [[f.let(f"ptrtoint ptr {p} to i64") for p, _ in side] for side in (inputs, outs)]
        conditions = []
        for a, (_, length) in zip(ranges[0], inputs, strict=True):
            for o, (_, size) in zip(ranges[1], outs, strict=True):
                if length and size:
                    after = f.let(f"icmp uge i64 {a}, {f.let(f'add i64 {o}, {8 * size}')}")
                    before = f.let(f"icmp uge i64 {o}, {f.let(f'add i64 {a}, {8 * length}')}")
                    conditions.append(f"or i1 {before}, {after}")
        if conditions:
            self.require(*conditions)

    def finish(self, status: str) -> str:
        """Give the status back; the text of the function."""
        for value in (status, str(NOT_TAKEN)):
            self.f.do(f"ret ptr {self.f.let(f'call ptr @PyLong_FromLongLong(i64 {value})')}")
            if value is status:
                self.f.begin(self.refuse)
        return self.f.text()


def one_entry(trace: Trace, header: Header) -> str:
    """`call(a0, ..., o0, ...)` for one state: inputs (size,), outputs of their shapes, which are filled."""
    k = len(trace.inputs)
    entry = Entry("call", k + len(trace.layout), header)
    inputs = [entry.array(v, [size], writable=False) for v, size in enumerate(trace.inputs)]
    outs = [
        entry.array(k + j, list(shape), writable=True) for j, (_, shape) in enumerate(trace.layout)
    ]
    entry.require_apart(
        list(zip(inputs, trace.inputs, strict=True)), list(zip(outs, sizes(trace), strict=True))
    )
    arguments = ", ".join(f"ptr {p}" for p in inputs + outs)
    return entry.finish(entry.f.let(f"call i64 @one({arguments})"))


def rows_entry(trace: Trace, header: Header) -> str:
    """`call(a0, ..., o0, ..., status)` for many states, other Python threads running meanwhile.

    Inputs (N, size), or (size,) for all states; outputs (N, *shape) and int64 status (N,) are
    filled; the answer is 0.
    """
    k, m = len(trace.inputs), len(trace.layout)
    entry = Entry("call", k + m + 1, header)
    f = entry.f
    status = entry.argument(k + m, Address.INT64, writable=True)
    entry.require(f"icmp eq i32 {entry.field(status, header.ndim, 'i32')}, 1")
    n = f.load(entry.field(status, header.dims), kind="i64")
    arguments = [f"i64 {n}"]
    for v, size in enumerate(trace.inputs):
        pointer, stride = entry.shared_or_rows(v, size, n)
        arguments += [f"ptr {pointer}", f"i64 {stride}"]
    for j, (_, shape) in enumerate(trace.layout):
        arguments.append(f"ptr {entry.array(k + j, [n, *shape], writable=True)}")
    arguments.append(f"ptr {entry.field(status, header.data)}")
    thread = f.let("call ptr @PyEval_SaveThread()")
    with f.when(f.let(f"icmp sgt i64 {n}, 0")):
        f.do(f"call void @rows({', '.join(arguments)})")
    f.do(f"call void @PyEval_RestoreThread(ptr {thread})")
    return entry.finish("0")
