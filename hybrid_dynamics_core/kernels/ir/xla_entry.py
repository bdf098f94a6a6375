"""Entry functions for XLA: handlers of its foreign function interface.

XLA calls it with a frame of buffers: the input vectors (size,) or (N, size), then the outputs
(N, *shape) and the int64 status (N,). Its offsets are those of `xla/ffi/api/c_api.h`, for pointers
of 64 bits. The caller has checked types and shapes.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..trace import Trace
from .states import sizes
from .text import Function

# offsets in bytes
_EXTENSION = 8  # of the frame: null, or what XLA asks of a handler before its first call
_INTERFACE = 16
_ARGUMENTS = 72
_RESULTS = 112
_METADATA = 24  # of the extension
_THEIR_VERSION = 32  # of the interface: two int32
_OUR_VERSION = 24  # of the metadata: the same
_OLDEST = 1 << 32  # version 0.1, whose XLA asks without its interface
_DATA = 24  # of a buffer
_RANK = 32
_LENGTHS = 40


def xla_one_entry(trace: Trace) -> str:
    """`@call(frame)`: computes one state by `@one`, and returns null, which is no error."""
    frame = _Frame(trace)
    pointers = [f"ptr {place}" for place in (*frame.inputs(), *frame.outs())]
    status = frame.f.let(f"call i64 @one({', '.join(pointers)})")
    frame.f.store(status, frame.data(frame.status), kind="i64")
    return frame.text()


def xla_rows_entry(trace: Trace) -> str:
    """`@call(frame)`: computes all rows by `@rows`, and returns null, which is no error."""
    frame = _Frame(trace)
    f = frame.f
    given = [f"i64 {frame.rows()}"]
    for place, stride in zip(frame.inputs(), frame.strides(trace.inputs), strict=True):
        given += [f"ptr {place}", f"i64 {stride}"]
    given += [f"ptr {place}" for place in (*frame.outs(), frame.data(frame.status))]
    f.do(f"call void @rows({', '.join(given)})")
    return frame.text()


def xla_32_entry(trace: Trace) -> str:
    """`@call(frame)`: the rows one after the other, of numbers and a status of 32 bits.

    They are computed in 64 bits.
    """
    frame = _Frame(trace)
    f = frame.f
    sources, strides = frame.inputs(), frame.strides(trace.inputs)
    targets, status = frame.outs(), frame.data(frame.status)
    inputs = [f.slot("double", size) for size in trace.inputs]
    outs = [f.slot("double", size) for size in sizes(trace)]
    with f.loop(0, frame.rows()) as row:
        for source, stride, slot, size in zip(sources, strides, inputs, trace.inputs, strict=True):
            first = f.let(f"mul i64 {row}, {stride}")
            with f.loop(0, size) as k:
                value = f.load(source, first, k, kind="float", align=4)
                f.store(f.let(f"fpext float {value} to double"), slot, k)
        pointers = ", ".join(f"ptr {slot}" for slot in (*inputs, *outs))
        code = f.let(f"call i64 @one({pointers})")
        f.store(f.let(f"trunc i64 {code} to i32"), status, row, kind="i32", align=4)
        for slot, target, size in zip(outs, targets, sizes(trace), strict=True):
            first = f.product(row, size)
            with f.loop(0, size) as k:
                value = f.let(f"fptrunc double {f.load(slot, k)} to float")
                f.store(value, target, first, k, kind="float", align=4)
    return frame.text()


class _Frame:
    """Writer of a handler: its answer to the first question of XLA, then the call.

    Attributes:
        f: the writer.
        arguments: buffers of the inputs.
        results: buffers of the outputs.
        status: buffer of the status.
    """

    def __init__(self, trace: Trace) -> None:
        self.f = Function("define ptr @call(ptr %frame)")
        self._answer()
        self.arguments = self._buffers(_ARGUMENTS, len(trace.inputs))
        *self.results, self.status = self._buffers(_RESULTS, len(trace.layout) + 1)

    def _answer(self) -> None:
        """If XLA asks for the version of its interface, return its own."""
        f = self.f
        extension = _field(f, "%frame", _EXTENSION)
        is_question = f.let(f"icmp ne ptr {extension}, null")
        asked, called = f.label(), f.label()
        f.branch(is_question, asked, called)
        f.begin(asked)
        oldest = f.slot("i64")
        f.store(_OLDEST, oldest, kind="i64")
        interface = _field(f, "%frame", _INTERFACE)
        theirs = f.at(interface, _THEIR_VERSION, kind="i8")
        is_absent = f.let(f"icmp eq ptr {interface}, null")
        place = f.let(f"select i1 {is_absent}, ptr {oldest}, ptr {theirs}")
        metadata = _field(f, extension, _METADATA)
        version = f.load(place, kind="i64")
        f.store(version, f.at(metadata, _OUR_VERSION, kind="i8"), kind="i64")
        f.do("ret ptr null")
        f.begin(called)

    def _buffers(self, offset: int, count: int) -> list[str]:
        """Buffers of a list in the frame."""
        first = _field(self.f, "%frame", offset)
        return [self.f.load(first, number, kind="ptr") for number in range(count)]

    def inputs(self) -> list[str]:
        """Data of the inputs."""
        return [self.data(buffer) for buffer in self.arguments]

    def strides(self, widths: Sequence[int]) -> list[str]:
        """From row to row of the inputs [numbers]; 0 for a vector that all rows share."""
        f = self.f
        strides = []
        for buffer, width in zip(self.arguments, widths, strict=True):
            rank = _field(f, buffer, _RANK, "i64")
            is_shared = f.let(f"icmp eq i64 {rank}, 1")
            strides.append(f.let(f"select i1 {is_shared}, i64 0, i64 {width}"))
        return strides

    def rows(self) -> str:
        """Number of rows."""
        return self.f.load(_field(self.f, self.status, _LENGTHS), kind="i64")

    def outs(self) -> list[str]:
        """Data of the outputs."""
        return [self.data(buffer) for buffer in self.results]

    def data(self, buffer: str) -> str:
        """Data of a buffer."""
        return _field(self.f, buffer, _DATA)

    def text(self) -> str:
        """The text of the function."""
        self.f.do("ret ptr null")
        return self.f.text()


def _field(f: Function, thing: str, offset: int, kind: str = "ptr") -> str:
    """The value at an offset [bytes] after a pointer."""
    return f.load(f.at(thing, offset, kind="i8"), kind=kind)
