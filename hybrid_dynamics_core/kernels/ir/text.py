"""A function of LLVM IR written line by line: fresh names, constants, loops and branches."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager


def constant(value: float) -> str:
    """A double, exactly."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


class Function:
    """The body of one function; every name is a number with a letter before it."""

    def __init__(self, head: str) -> None:
        self.head = head
        self._slots: list[str] = []
        self._lines: list[str] = []
        self._count = 0
        self.products: dict[str, tuple[str, str]] = {}  # factors of the values that are products

    def fresh(self) -> int:
        """A number not used yet."""
        self._count += 1
        return self._count

    def let(self, instruction: str) -> str:
        """Add an instruction; the name of its value."""
        name = f"%v{self.fresh()}"
        self._lines.append(f"  {name} = {instruction}")
        return name

    def product(self, index: str, factor: int) -> str:
        """An index times a number."""
        return self.let(f"mul i64 {index}, {factor}")

    def row(self, pointer: str, index: str, width: int) -> str:
        """The address of a row of a table of doubles."""
        return self.at(pointer, self.product(index, width))

    def absolute(self, value: str) -> str:
        """The size of a double."""
        return self.let(f"call double @llvm.fabs.f64(double {value})")

    def do(self, instruction: str) -> None:
        """Add an instruction without a value."""
        self._lines.append(f"  {instruction}")

    def slot(self, kind: str, count: int = 1) -> str:
        """Memory on the stack for `count` values of a type, kept for the whole call."""
        name = f"%s{self.fresh()}"
        self._slots.append(f"  {name} = alloca [{max(count, 1)} x {kind}], align 64")
        return name

    def at(self, pointer: str, *indices: str | int, kind: str = "double") -> str:
        """The address `indices` (summed) entries of a type after a pointer."""
        for index in indices:
            if index != 0:
                pointer = self.let(f"getelementptr {kind}, ptr {pointer}, i64 {index}")
        return pointer

    def load(self, pointer: str, *indices: str | int, kind: str = "double", align: int = 8) -> str:
        """The value `indices` entries after a pointer."""
        return self.let(f"load {kind}, ptr {self.at(pointer, *indices, kind=kind)}, align {align}")

    def store(
        self,
        value: str | int,
        pointer: str,
        *indices: str | int,
        kind: str = "double",
        align: int = 8,
    ) -> None:
        """Put a value `indices` entries after a pointer."""
        self.do(f"store {kind} {value}, ptr {self.at(pointer, *indices, kind=kind)}, align {align}")

    def label(self) -> str:
        """A new label."""
        return f"b{self.fresh()}"

    def begin(self, label: str) -> None:
        """Start the block of a label."""
        self._lines.append(f"{label}:")

    def branch(self, condition: str, yes: str, no: str) -> None:
        """End the block: on to one label or the other."""
        self.do(f"br i1 {condition}, label %{yes}, label %{no}")

    @contextmanager
    def loop(
        self, start: str | int, stop: str | int, step: int = 1, while_: str | None = None
    ) -> Iterator[str]:
        """Do what is written inside for each index.

        Args:
            start: the first index.
            stop: the index before which it ends.
            step: from one index to the next.
            while_: a slot (i1); the loop ends where it is not set.
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
        """Do what is written inside if the condition holds."""
        yes, on = self.label(), self.label()
        self.branch(condition, yes, on)
        self.begin(yes)
        yield
        self.do(f"br label %{on}")
        self.begin(on)

    def text(self) -> str:
        """The whole definition."""
        return "\n".join([f"{self.head} {{", "entry:", *self._slots, *self._lines, "}", ""])


class Lanes:
    """Arithmetic inside a function, on one double (width 1) or on a vector, one state a lane."""

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

        Where a term of a sum is a product, both are one fused operation if the processor has it.
        This code and not LLVM decides which ones, so that one state and many are rounded alike:
        they agree to the last bit.
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
        """The value with its other sign."""
        return self.function.let(f"fneg {self.kind} {a}")

    def intrinsic(self, name: str, *values: str) -> str:
        """One of LLVM's functions on doubles."""
        arguments = ", ".join(f"{self.kind} {value}" for value in values)
        return self.function.let(f"call {self.kind} @llvm.{name}.{self.suffix}({arguments})")

    def compare(self, relation: str, a: str, b: str) -> str:
        """An ordered comparison: false where a or b is not a number."""
        return self.function.let(f"fcmp {relation} {self.kind} {a}, {b}")

    def choose(self, mask: str, kind: str, yes: str, no: str) -> str:
        """`yes` where the mask is set, `no` elsewhere."""
        return self.function.let(f"select {self.mask} {mask}, {kind} {yes}, {kind} {no}")


def declarations(width: int) -> list[str]:
    """LLVM's functions on doubles of a width, and the ones of C."""
    lanes = Lanes(Function(""), width)
    one, two = f"({lanes.kind})", f"({lanes.kind}, {lanes.kind})"
    three = f"({', '.join([lanes.kind] * 3)})"
    functions = [(name, one) for name in ("sqrt", "fabs", "rint", "sin", "cos")]
    functions += [(name, two) for name in ("minnum", "maxnum")]
    functions.append(("fmuladd", three))
    lines = []
    for name, arguments in functions:
        lines.append(f"declare {lanes.kind} @llvm.{name}.{lanes.suffix}{arguments}")
    if width > 1:
        lines.append(f"declare i1 @llvm.vector.reduce.and.v{width}i1({lanes.mask})")
    return lines
