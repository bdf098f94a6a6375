"""A program run on symbols leaves a graph of elementary operations: equal ones merged, constants folded.

Nothing here knows robots. A symbol behaves as a scalar; a product with the constant 0 is the
constant 0, so the structural zeros of a mechanism never reach the generated code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Union

Operand = Union["Symbol", float]
Body = Callable[[Sequence[Any], Sequence[Any]], list[Any]]
Key = tuple[
    str, int | float, int | float
]  # operation, operands: node index (int) or constant (float)


@dataclass(frozen=True)
class Block:
    """An iterative or matrix operation: `kind` names the function of `algebra.numerics` that does it.

    `arguments`: vectors of operands; `body`: the traced function that Newton iterates, None
    otherwise.
    """

    kind: str
    size: int
    arguments: list[list[Operand]]
    body: Body | None


class Graph:
    """Nodes in order of creation: operands come before their uses.

    A node ("block", b, k) is output k of block b.
    """

    def __init__(self) -> None:
        self.nodes: list[Key] = []
        self.blocks: list[Block] = []
        self._index: dict[tuple[str, bool, int | float, bool, int | float], int] = {}

    def input(self, vector: int, component: int) -> Symbol:
        """A symbol for one component of an input vector."""
        return Symbol(self, self._node(("input", vector, component)))

    def apply(self, op: str, a: Operand, b: Operand = 0.0) -> Symbol:
        """The symbol of an operation, shared with an equal earlier one."""
        left, right = _operand(a), _operand(b)
        if (
            op in ("add", "mul")
            and isinstance(left, int)
            and isinstance(right, int)
            and left > right
        ):
            left, right = right, left
        return Symbol(self, self._node((op, left, right)))

    def block(
        self,
        kind: str,
        size: int,
        outputs: int,
        arguments: list[list[Operand]],
        body: Body | None = None,
    ) -> list[Symbol]:
        """Symbols for the outputs of a new block."""
        self.blocks.append(Block(kind, size, arguments, body))
        return [
            Symbol(self, self._node(("block", len(self.blocks) - 1, k))) for k in range(outputs)
        ]

    def output(self, block: int, k: int) -> Symbol:
        """The symbol for an output of a block."""
        return Symbol(self, self._node(("block", block, k)))

    def operands(self, index: int) -> list[int]:
        """Nodes that a node is computed from."""
        op, a, b = self.nodes[index]
        if op == "input":
            return []
        if op == "block":
            return [
                x.index
                for vector in self.blocks[int(a)].arguments
                for x in vector
                if isinstance(x, Symbol)
            ]
        return [x for x in (a, b) if isinstance(x, int)]

    def live(self, roots: Sequence[Operand]) -> list[int]:
        """Nodes that the roots are computed from, and the roots, in order; constants among them are passed over."""
        wanted = bytearray(len(self.nodes))
        for root in roots:
            if isinstance(root, Symbol):
                wanted[root.index] = True
        last = wanted.rfind(True)
        for index in range(last, -1, -1):  # what a node is computed from stands before it
            if wanted[index]:
                for operand in self.operands(index):
                    wanted[operand] = True
        return [index for index in range(last + 1) if wanted[index]]

    def _node(self, key: Key) -> int:
        op, a, b = key
        # node 1 and the number 1.0 compare equal, so the kind of each operand is part of what is
        # looked up
        full = (op, isinstance(a, int), a, isinstance(b, int), b)
        index = self._index.get(full)
        if index is None:
            index = self._index[full] = len(self.nodes)
            self.nodes.append(key)
        return index


def _operand(x: Operand) -> int | float:
    return x.index if isinstance(x, Symbol) else float(x)


class Symbol:
    """A scalar that records what is done to it."""

    __slots__ = ("graph", "index")
    __array_ufunc__ = None  # NumPy scalars on the left give way

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph = graph
        self.index = index

    def _negated(self) -> Symbol | None:
        op, operand, _ = self.graph.nodes[self.index]
        return Symbol(self.graph, int(operand)) if op == "neg" else None

    def __add__(self, other: Operand) -> Operand:
        if isinstance(other, Symbol):
            inner = other._negated()
            if inner is not None:
                return self - inner
            inner = self._negated()
            if inner is not None:
                return other - inner
            return self.graph.apply("add", self, other)
        return self if other == 0.0 else self.graph.apply("add", self, float(other))

    __radd__ = __add__

    def __sub__(self, other: Operand) -> Operand:
        if isinstance(other, Symbol):
            if other.index == self.index:
                return 0.0
            inner = other._negated()
            return self + inner if inner is not None else self.graph.apply("sub", self, other)
        return self if other == 0.0 else self.graph.apply("sub", self, float(other))

    def __rsub__(self, other: float) -> Operand:
        return -self if other == 0.0 else self.graph.apply("sub", float(other), self)

    def __mul__(self, other: Operand) -> Operand:
        if isinstance(other, Symbol):
            a, b = self._negated(), other._negated()
            if a is not None or b is not None:
                product = (self if a is None else a) * (other if b is None else b)
                return product if a is not None and b is not None else -product
            return self.graph.apply("mul", self, other)
        return self._times(float(other))

    __rmul__ = __mul__

    def _times(self, factor: float) -> Operand:
        if factor == 0.0:
            return 0.0
        if factor == 1.0:
            return self
        if factor == -1.0:
            return -self
        inner = self._negated()
        if inner is not None:
            return inner * -factor
        op, a, b = self.graph.nodes[self.index]
        if op == "mul" and isinstance(b, float):
            return Symbol(self.graph, int(a)) * (b * factor)
        return -self._times(-factor) if factor < 0.0 else self.graph.apply("mul", self, factor)

    def __truediv__(self, other: Operand) -> Operand:
        if isinstance(other, Symbol):
            return self * other.reciprocal()
        return self._times(1.0 / other)

    def __rtruediv__(self, other: float) -> Operand:
        return 0.0 if other == 0.0 else self.reciprocal() * other

    def reciprocal(self) -> Operand:
        """1 / self: one division, however many are divided by it."""
        inner = self._negated()
        return -inner.reciprocal() if inner is not None else self.graph.apply("div", 1.0, self)

    def __neg__(self) -> Symbol:
        inner = self._negated()
        return inner if inner is not None else self.graph.apply("neg", self)

    def sin(self) -> Symbol:
        """Sine."""
        return self.graph.apply("sin", self)

    def cos(self) -> Symbol:
        """Cosine."""
        return self.graph.apply("cos", self)

    def sqrt(self) -> Symbol:
        """Square root; NaN below zero."""
        return self.graph.apply("sqrt", self)

    def absolute(self) -> Symbol:
        """Absolute value."""
        return self.graph.apply("abs", self)

    def atan2(self, x: Operand) -> Symbol:
        """Angle of the vector (x, self)."""
        return self.graph.apply("atan2", self, x)

    def atan2_of(self, y: float) -> Symbol:
        """Angle of the vector (self, y)."""
        return self.graph.apply("atan2", float(y), self)

    def __bool__(self) -> bool:
        raise TypeError("a symbol has no truth value: a traced program cannot branch on it")
