"""The graph of elementary operations that a program records when it runs on symbols.

Equal operations share a node, and constants are folded. A product with the constant 0 is the
constant 0, so structural zeros do not reach the generated code. This module does not depend on
robots.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Union

Operand = Union["Symbol", float]
Body = Callable[[Sequence[Any], Sequence[Any]], list[Any]]
# (operation, operands); an operand is a node index (int) or a constant (float)
Key = tuple[str, int | float, int | float]
_COMMUTATIVE = ("add", "mul")


@dataclass(frozen=True)
class Block:
    """An operation on vectors: the inverse of a matrix, or Newton's iteration.

    Attributes:
        kind: name of its function in `algebra.numerics`.
        size: rows of the matrix, or number of unknowns.
        arguments: vectors of operands.
        body: function of unknowns and parameters that Newton's method calls; None for an inverse.
    """

    kind: str
    size: int
    arguments: list[list[Operand]]
    body: Body | None

    @property
    def outputs(self) -> int:
        """Number of outputs.

        They are the inverse, or the solution and the number of iterations.
        """
        if self.body is None:
            return self.size**2
        return self.size + 1

    def symbols(self) -> list[Symbol]:
        """Symbols among the arguments, in order."""
        operands = chain.from_iterable(self.arguments)
        return [x for x in operands if isinstance(x, Symbol)]


class Graph:
    """Nodes in order of creation: operands come before their uses.

    A node ("block", b, k) is output k of block b.
    """

    def __init__(self) -> None:
        self.nodes: list[Key] = []
        self.blocks: list[Block] = []
        self._block_numbers: dict[tuple[object, ...], int] = {}
        self._numbers: dict[tuple[type, type], dict[Key, int]] = defaultdict(dict)

    def input(self, vector: int, component: int) -> Symbol:
        """A symbol for one component of an input vector."""
        return Symbol(self, self._node(("input", vector, component)))

    def apply(self, op: str, a: Operand, b: Operand = 0.0) -> Symbol:
        """The symbol of an operation; an equal earlier one is reused."""
        first, second = _operand(a), _operand(b)
        are_nodes = isinstance(first, int) and isinstance(second, int)
        if are_nodes and second < first and op in _COMMUTATIVE:
            first, second = second, first
        return Symbol(self, self._node((op, first, second)))

    def keep(self, op: str, a: Operand, b: Operand = 0.0) -> Symbol:
        """The symbol of an operation with its operands in this order."""
        return Symbol(self, self._node((op, _operand(a), _operand(b))))

    def block(
        self,
        kind: str,
        size: int,
        outputs: int,
        arguments: list[list[Operand]],
        body: Body | None = None,
    ) -> list[Symbol]:
        """Symbols for the outputs of a block, shared with an equal earlier one."""
        operands = tuple(tuple(map(_key_of, vector)) for vector in arguments)
        key = (kind, size, operands, body)
        number = self._block_numbers.get(key)
        if number is None:
            number = self._block_numbers[key] = len(self.blocks)
            self.blocks.append(Block(kind, size, arguments, body))
        return [self.output(number, k) for k in range(outputs)]

    def output(self, block: int, k: int) -> Symbol:
        """The symbol for an output of a block."""
        return Symbol(self, self._node(("block", block, k)))

    def operands(self, index: int) -> list[int]:
        """Operands of a node that are nodes."""
        op, a, b = self.nodes[index]
        if op == "input":
            return []
        if op == "block":
            symbols = self.blocks[int(a)].symbols()
            return [x.index for x in symbols]
        if not isinstance(b, int):
            return [a] if isinstance(a, int) else []
        return [a, b] if isinstance(a, int) else [b]

    def live(self, roots: Sequence[Operand]) -> list[int]:
        """The roots and all nodes that they depend on, in order."""
        wanted = bytearray(len(self.nodes))
        for root in roots:
            if isinstance(root, Symbol):
                wanted[root.index] = True
        last = wanted.rfind(True)
        for index in range(last, -1, -1):  # operands come before their uses
            if wanted[index]:
                for operand in self.operands(index):
                    wanted[operand] = True
        return [index for index in range(last + 1) if wanted[index]]

    def _node(self, key: Key) -> int:
        # node 1 and the constant 1.0 compare equal, so each type of operands has its own numbers
        _, a, b = key
        numbers = self._numbers[a.__class__, b.__class__]
        number = numbers.get(key)
        if number is None:
            number = numbers[key] = len(self.nodes)
            self.nodes.append(key)
        return number


def _operand(x: Operand) -> int | float:
    return x.index if isinstance(x, Symbol) else float(x)


def _key_of(x: Operand) -> tuple[bool, int | float]:
    return isinstance(x, Symbol), _operand(x)


class Symbol:
    """A scalar that records its operations in a graph."""

    __slots__ = ("graph", "index")
    __array_ufunc__ = None  # lets NumPy scalars on the left defer to these methods

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph = graph
        self.index = index

    def _negated(self) -> Symbol | None:
        """The operand if this is a negation, otherwise None."""
        node = self.graph.nodes[self.index]
        return Symbol(self.graph, int(node[1])) if node[0] == "neg" else None

    def __add__(self, other: Operand) -> Operand:
        if not isinstance(other, Symbol):
            return self._plus(float(other))
        inner = other._negated()
        if inner is not None:
            return self - inner
        inner = self._negated()
        if inner is not None:
            return other - inner
        return self.graph.apply("add", self, other)

    __radd__ = __add__

    def _plus(self, constant: float) -> Operand:
        """The sum with a constant, which joins a constant that was added before."""
        if constant == 0.0:
            return self
        op, a, b = self.graph.nodes[self.index]
        if op == "neg":
            return self.graph.apply("sub", constant, Symbol(self.graph, int(a)))
        if op in ("add", "sub") and isinstance(b, float):
            signed = b if op == "add" else -b
            return Symbol(self.graph, int(a)) + (signed + constant)
        if op == "sub" and isinstance(a, float):
            subtracted = Symbol(self.graph, int(b))
            rest = a + constant
            return -subtracted if rest == 0.0 else self.graph.apply("sub", rest, subtracted)
        return self.graph.apply("add", self, constant)

    def __sub__(self, other: Operand) -> Operand:
        if not isinstance(other, Symbol):
            return self._plus(-float(other))
        if other.index == self.index:
            return 0.0
        inner = other._negated()
        if inner is not None:
            return self + inner
        inner = self._negated()
        if inner is not None:
            return -(inner + other)  # what follows may take the sign
        return self.graph.apply("sub", self, other)

    def __rsub__(self, other: float) -> Operand:
        if other == 0.0:
            return -self
        return self.graph.apply("sub", float(other), self)

    def __mul__(self, other: Operand) -> Operand:
        if not isinstance(other, Symbol):
            return self._times(float(other))
        nodes = self.graph.nodes
        if nodes[self.index][0] != "neg" and nodes[other.index][0] != "neg":
            return self.graph.apply("mul", self, other)
        a, b = self._negated(), other._negated()
        first = self if a is None else a
        second = other if b is None else b
        product = first * second
        is_negative = a is None or b is None
        return -product if is_negative else product

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
        if other == 0.0:
            return 0.0
        return self.reciprocal() * other

    def reciprocal(self) -> Operand:
        """1 / self, shared by all divisions by this symbol."""
        inner = self._negated()
        if inner is not None:
            return -inner.reciprocal()
        return self.graph.apply("div", 1.0, self)

    def __pow__(self, power: int) -> Operand:
        result: Operand = 1.0
        for _ in range(power):
            result = result * self
        return result

    def __neg__(self) -> Symbol:
        inner = self._negated()
        if inner is not None:
            return inner
        return self.graph.apply("neg", self)

    def sin(self) -> Symbol:
        """Sine."""
        return self.graph.apply("sin", self)

    def cos(self) -> Symbol:
        """Cosine."""
        return self.graph.apply("cos", self)

    def sqrt(self) -> Symbol:
        """Square root; NaN below zero."""
        return self.graph.apply("sqrt", self)

    def rint(self) -> Symbol:
        """Nearest integer."""
        return self.graph.apply("rint", self)

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
