"""Entry for users: it holds vectors of the robot, takes those of the state, and makes the results.

`self` has addresses as for the other entry (`Address`), then those of `Holding`, then one for each
input: that of a held vector, or zero for an input that the caller gives. Calls of any other kind,
and states without an answer, go to a fallback in Python, with the same arguments.
"""

from __future__ import annotations

from enum import IntEnum

from ..status import GOOD
from ..trace import Trace
from .entry import Address, Entry, Header
from .states import sizes

_FLOAT64_NUMBER = 12  # NumPy's number of the type of doubles

DECLARATIONS = """
declare ptr @PyObject_Vectorcall(ptr, ptr, i64, ptr)
declare ptr @PyTuple_New(i64)
declare i32 @PyTuple_SetItem(ptr, i64, ptr)
declare void @Py_IncRef(ptr)
declare void @Py_DecRef(ptr)
"""


class Holding(IntEnum):
    """Indices of further addresses in `self`."""

    FALLBACK = len(Address)
    OUT = FALLBACK + 1  # the keyword `out`, as Python keeps names
    NEW_ARRAY = OUT + 1  # NumPy's PyArray_New
    INPUTS = NEW_ARRAY + 1  # the first one of the inputs


class _HeldEntry(Entry):
    """Writer of the entry."""

    def __init__(self, trace: Trace, header: Header) -> None:
        super().__init__("held", header, "ptr %self, ptr %args, i64 %count, ptr %names")
        self._trace = trace
        self._position = self.f.slot("i64")

    def text(self) -> str:
        """The text of the function."""
        f, trace = self.f, self._trace
        f.store(0, self._position, kind="i64")
        inputs = [self._input(k, size) for k, size in enumerate(trace.inputs)]
        taken = f.load(self._position, kind="i64")
        has_names = f.let("icmp ne ptr %names, null")
        given_all = f.let(f"icmp eq i64 {taken}, %count")
        is_plain = f.let(f"icmp eq i1 {has_names}, false")
        is_plain = f.let(f"and i1 {is_plain}, {given_all}")
        plain, other = f.label(), f.label()
        f.branch(is_plain, plain, other)
        f.begin(plain)
        self._new_results(inputs)
        f.begin(other)
        if len(trace.layout) == 1:
            self._given_result(inputs, taken, has_names)
        else:
            f.do(f"br label %{self.not_taken}")
        f.begin(self.not_taken)
        fallback = f.load(self.addresses, Holding.FALLBACK, kind="ptr")
        arguments = f"ptr {fallback}, ptr %args, i64 %count, ptr %names"
        result = f.let(f"call ptr @PyObject_Vectorcall({arguments})")
        f.do(f"ret ptr {result}")
        return f.text()

    def _input(self, k: int, size: int) -> str:
        """The data of an input: held, or of the next argument."""
        f = self.f
        place = f.slot("ptr")
        held = f.load(self.addresses, Holding.INPUTS + k, kind="ptr")
        f.store(held, place, kind="ptr")
        with f.when(f.let(f"icmp eq ptr {held}, null")):
            position = f.load(self._position, kind="i64")
            self.require(f"icmp slt i64 {position}, %count")
            data = self.array(position, [size], writable=False)
            f.store(data, place, kind="ptr")
            following = f.let(f"add i64 {position}, 1")
            f.store(following, self._position, kind="i64")
        return f.load(place, kind="ptr")

    def _new_results(self, inputs: list[str]) -> None:
        """Return new arrays, or a tuple of them."""
        f = self.f
        arrays = [self._new_array(shape) for _, shape in self._trace.layout]
        outs = [self.field(array, self.header.data) for array in arrays]
        status = self._run(inputs, outs)
        good, bad = f.label(), f.label()
        f.branch(f.let(f"icmp eq i64 {status}, {GOOD}"), good, bad)
        f.begin(bad)
        for array in arrays:
            f.do(f"call void @Py_DecRef(ptr {array})")
        f.do(f"br label %{self.not_taken}")
        f.begin(good)
        result = arrays[0]
        if len(arrays) > 1:
            result = f.let(f"call ptr @PyTuple_New(i64 {len(arrays)})")
            for k, array in enumerate(arrays):
                f.let(f"call i32 @PyTuple_SetItem(ptr {result}, i64 {k}, ptr {array})")
        f.do(f"ret ptr {result}")

    def _new_array(self, shape: tuple[int, ...]) -> str:
        """A new array; without memory, the function returns Python's error."""
        f = self.f
        lengths = f.slot("i64", len(shape))
        for k, length in enumerate(shape):
            f.store(length, lengths, k, kind="i64")
        make = f.load(self.addresses, Holding.NEW_ARRAY, kind="ptr")
        kind = f.load(self.addresses, Address.ARRAY_TYPE, kind="ptr")
        number = f"i32 {_FLOAT64_NUMBER}"
        head = f"ptr {kind}, i32 {len(shape)}, ptr {lengths}, {number}"
        array = f.let(f"call ptr {make}({head}, ptr null, ptr null, i32 0, i32 0, ptr null)")
        none, some = f.label(), f.label()
        f.branch(f.let(f"icmp eq ptr {array}, null"), none, some)
        f.begin(none)
        f.do("ret ptr null")
        f.begin(some)
        return array

    def _given_result(self, inputs: list[str], taken: str, has_names: str) -> None:
        """Fill and return the array that the caller gave as `out`, by name or after the inputs."""
        f, trace = self.f, self._trace
        named, unnamed, checked = f.label(), f.label(), f.label()
        f.branch(has_names, named, unnamed)
        f.begin(named)
        count = self.field("%names", self.header.size, "i64")
        name = self.field("%names", self.header.size + 8)
        expected = f.load(self.addresses, Holding.OUT, kind="ptr")
        self.require(
            f"icmp eq i64 {count}, 1",
            f"icmp eq ptr {name}, {expected}",
            f"icmp eq i64 {taken}, %count",
        )
        f.do(f"br label %{checked}")
        f.begin(unnamed)
        before_last = f.let("sub i64 %count, 1")
        self.require(f"icmp eq i64 {taken}, {before_last}")
        f.do(f"br label %{checked}")
        f.begin(checked)
        ((_, shape),) = trace.layout
        array = self.argument(taken, Address.FLOAT64, writable=True)
        data = self.data(array, list(shape))
        (size,) = sizes(trace)
        self.require_apart(list(zip(inputs, trace.inputs, strict=True)), [(data, size)])
        status = self._run(inputs, [data])
        self.require(f"icmp eq i64 {status}, {GOOD}")
        f.do(f"call void @Py_IncRef(ptr {array})")
        f.do(f"ret ptr {array}")

    def _run(self, inputs: list[str], outs: list[str]) -> str:
        arguments = ", ".join(f"ptr {pointer}" for pointer in inputs + outs)
        return self.f.let(f"call i64 @one({arguments})")


def held_entry(trace: Trace, header: Header) -> str:
    """`held(state vectors, out=None)` for one state."""
    return _HeldEntry(trace, header).text()
