"""Writer of LLVM IR: fresh names, constants, loops and branches."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager

# Attributes of a function whose vectors in memory lie within lines of the cache. LLVM aligns its
# stack by itself only where there are slots.
ALIGNED = 'noinline "stackrealign"'


def constant(value: float) -> str:
    """The exact text of a double."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


class Function:
    """Writer of one function; a name is a letter and a number."""

    def __init__(self, head: str) -> None:
        self.head = head
        self._slots: list[str] = []
        self._lines: list[str] = []
        self._count = 0
        self.products: dict[str, tuple[str, str]] = {}  # factors of values that are products

    def fresh(self) -> int:
        """A number that was not used yet."""
        self._count += 1
        return self._count

    def let(self, instruction: str) -> str:
        """Add an instruction; returns the name of its value."""
        name = f"%v{self.fresh()}"
        self._lines.append(f"  {name} = {instruction}")
        return name

    def product(self, index: str, factor: int) -> str:
        """Write an index times a number."""
        return self.let(f"mul i64 {index}, {factor}")

    def row(self, pointer: str, index: str, width: int) -> str:
        """The address of a row in a table of doubles."""
        return self.at(pointer, self.product(index, width))

    def absolute(self, value: str) -> str:
        """The absolute value of a double."""
        return self.let(f"call double @llvm.fabs.f64(double {value})")

    def do(self, instruction: str) -> None:
        """Add an instruction without a value."""
        self._lines.append(f"  {instruction}")

    def slot(self, kind: str, count: int = 1) -> str:
        """Allocate stack memory for `count` values of a type."""
        name = f"%s{self.fresh()}"
        self._slots.append(f"  {name} = alloca [{max(count, 1)} x {kind}], align 64")
        return name

    def at(self, pointer: str, *indices: str | int, kind: str = "double") -> str:
        """The address of an entry after a pointer; `indices` are summed."""
        for index in indices:
            if index != 0:
                pointer = self.let(f"getelementptr {kind}, ptr {pointer}, i64 {index}")
        return pointer

    def load(self, pointer: str, *indices: str | int, kind: str = "double", align: int = 8) -> str:
        """Load the entry after a pointer at `indices` (summed)."""
        return self.let(f"load {kind}, ptr {self.at(pointer, *indices, kind=kind)}, align {align}")

    def store(
        self,
        value: str | int,
        pointer: str,
        *indices: str | int,
        kind: str = "double",
        align: int = 8,
    ) -> None:
        """Store a value after a pointer at `indices` (summed)."""
        self.do(f"store {kind} {value}, ptr {self.at(pointer, *indices, kind=kind)}, align {align}")

    def label(self) -> str:
        """A new label."""
        return f"b{self.fresh()}"

    def begin(self, label: str) -> None:
        """Start the block of a label."""
        self._lines.append(f"{label}:")

    def branch(self, condition: str, yes: str, no: str) -> None:
        """End the block with a conditional branch."""
        self.do(f"br i1 {condition}, label %{yes}, label %{no}")

    @contextmanager
    def loop(
        self, start: str | int, stop: str | int, step: int = 1, while_: str | None = None
    ) -> Iterator[str]:
        """A loop around the instructions written in its context.

        Args:
            start: the first index.
            stop: the index at which it ends, excluded.
            step: the increment.
            while_: a slot (i1); the loop ends when it is false.
        """
        counter = self.slot("i64")
        head, check, body, done = (self.label() for _ in range(4))
        self.store(start, counter, kind="i64")
        self.do(f"br label %{head}")
        self.begin(head)
        index = self.load(counter, kind="i64")
        self.branch(self.let(f"icmp slt i64 {index}, {stop}"), check, done)
        self.begin(check)
        if while_ is None:
            self.do(f"br label %{body}")
        else:
            self.branch(self.load(while_, kind="i1", align=1), body, done)
        self.begin(body)
        yield index
        self.store(self.let(f"add i64 {index}, {step}"), counter, kind="i64")
        self.do(f"br label %{head}")
        self.begin(done)

    @contextmanager
    def when(self, condition: str) -> Iterator[None]:
        """A condition for the instructions written in its context."""
        yes, on = self.label(), self.label()
        self.branch(condition, yes, on)
        self.begin(yes)
        yield
        self.do(f"br label %{on}")
        self.begin(on)

    def text(self) -> str:
        """The text of the function."""
        return "\n".join([f"{self.head} {{", "entry:", *self._slots, *self._lines, "}", ""])


class Lanes:
    """Arithmetic on one double (width 1) or on a vector with one state per lane."""

    def __init__(self, function: Function, width: int) -> None:
        self.function = function
        self.width = width
        self.kind = self._vector("double")
        self.integer = self._vector("i64")
        self.mask = self._vector("i1")
        self.suffix = "f64" if width == 1 else f"v{width}f64"

    def _vector(self, kind: str) -> str:
        return kind if self.width == 1 else f"<{self.width} x {kind}>"

    def constant(self, value: float) -> str:
        """The same number in every lane."""
        return self.splat("double", constant(value))

    def splat(self, kind: str, value: str | int) -> str:
        """The same constant of any type in every lane."""
        if self.width == 1:
            return str(value)
        return f"<{', '.join([f'{kind} {value}'] * self.width)}>"

    def arithmetic(self, operation: str, a: str, b: str) -> str:
        """fadd, fsub, fmul or fdiv.

        A product and a sum are fused if the processor can. This code decides it, not LLVM, so that
        one state and many agree to the last bit.
        """
        products = self.function.products
        if operation in ("fadd", "fsub"):
            is_sum = operation == "fadd"
            if a in products:
                return self.intrinsic("fmuladd", *products[a], b if is_sum else self.negative(b))
            if b in products:
                factor, other = products[b]
                signed = factor if is_sum else self.negative(factor)
                return self.intrinsic("fmuladd", signed, other, a)
        value = self.function.let(f"{operation} {self.kind} {a}, {b}")
        if operation == "fmul":
            products[value] = a, b
        return value

    def negative(self, a: str) -> str:
        """The negated value."""
        return self.function.let(f"fneg {self.kind} {a}")

    def intrinsic(self, name: str, *values: str) -> str:
        """Name of an LLVM intrinsic on doubles."""
        arguments = ", ".join(f"{self.kind} {value}" for value in values)
        return self.function.let(f"call {self.kind} @llvm.{name}.{self.suffix}({arguments})")

    def compare(self, relation: str, a: str, b: str) -> str:
        """An ordered comparison: false if a or b is NaN."""
        return self.function.let(f"fcmp {relation} {self.kind} {a}, {b}")

    def larger(self, a: str, b: str) -> str:
        """The larger value; b if a or b is NaN."""
        return self.choose(self.compare("ogt", a, b), self.kind, a, b)

    def broadcast(self, value: str) -> str:
        """A double in every lane."""
        if self.width == 1:
            return value
        f = self.function
        first = f.let(f"insertelement {self.kind} poison, double {value}, i64 0")
        lanes = f"<{self.width} x i32> zeroinitializer"
        return f.let(f"shufflevector {self.kind} {first}, {self.kind} poison, {lanes}")

    def inverted(self, mask: str) -> str:
        """The lanes in which a mask is not set."""
        return self.function.let(f"xor {self.mask} {mask}, {self.splat('i1', 'true')}")

    def any(self, mask: str) -> str:
        """Whether a mask is set in some lane."""
        if self.width == 1:
            return mask
        name = f"@llvm.vector.reduce.or.v{self.width}i1"
        return self.function.let(f"call i1 {name}({self.mask} {mask})")

    @contextmanager
    def each_without(self, mask: str) -> Iterator[str]:
        """The instructions written in its context, for each lane in which a mask is not set."""
        f = self.function
        others = self.inverted(mask)
        with f.when(self.any(others)), f.loop(0, self.width) as lane:
            bit = others
            if self.width > 1:
                bit = f.let(f"extractelement {self.mask} {others}, i64 {lane}")
            with f.when(bit):
                yield lane

    def choose(self, mask: str, kind: str, yes: str, no: str) -> str:
        """Select `yes` where the mask is set, and `no` elsewhere."""
        return self.function.let(f"select {self.mask} {mask}, {kind} {yes}, {kind} {no}")


def declarations(width: int) -> list[str]:
    """Declarations of LLVM intrinsics for a width, and of C functions."""
    lanes = Lanes(Function(""), width)
    one, two = f"({lanes.kind})", f"({lanes.kind}, {lanes.kind})"
    three = f"({', '.join([lanes.kind] * 3)})"
    functions = [(name, one) for name in ("sqrt", "fabs", "rint", "sin", "cos")]
    functions += [(name, two) for name in ("copysign",)]
    functions.append(("fmuladd", three))
    lines = []
    for name, arguments in functions:
        lines.append(f"declare {lanes.kind} @llvm.{name}.{lanes.suffix}{arguments}")
    if width > 1:
        mask = f"v{width}i1({lanes.mask})"
        lines += [f"declare i1 @llvm.vector.reduce.{name}.{mask}" for name in ("and", "or")]
    return lines
