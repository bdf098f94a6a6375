"""Entry functions for XLA: handlers of its foreign function interface.

XLA calls it with a frame of buffers: the input vectors (size,) or (N, size), then the outputs
(N, *shape) and the int64 status (N,). Its offsets are those of `xla/ffi/api/c_api.h`, for pointers
of 64 bits. The caller has checked types and shapes.
"""

from __future__ import annotations

from ..trace import Trace
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
    rows = f.load(_field(f, frame.status, _LENGTHS), kind="i64")
    given = [f"i64 {rows}"]
    for place, buffer, size in zip(frame.inputs(), frame.arguments, trace.inputs, strict=True):
        rank = _field(f, buffer, _RANK, "i64")
        is_shared = f.let(f"icmp eq i64 {rank}, 1")
        stride = f.let(f"select i1 {is_shared}, i64 0, i64 {size}")
        given += [f"ptr {place}", f"i64 {stride}"]
    given += [f"ptr {place}" for place in (*frame.outs(), frame.data(frame.status))]
    f.do(f"call void @rows({', '.join(given)})")
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
