"""A trace as sums of products of atoms.

An atom is an input, the result of another operation than +, - and *, or a sum that is used more
than once or multiplied.
"""

from __future__ import annotations

from collections import Counter

from ..graph import Graph, Operand, Symbol
from ..trace import Trace

LONGEST = 6  # [factors] a longer product is divided
ROUNDING = 5e-16  # a coefficient that near to 1 is 1

Factors = tuple[int, ...]  # atoms in ascending order
Sum = dict[Factors, float]  # coefficient of each product, in order of appearance
Value = int | float  # an atom or a constant


class Sums:
    """The sums of products of a trace.

    Attributes:
        trace: the trace.
        kept: atoms that are computed as they are written.
        sums: definition of each atom that is a sum.
        operations: operation and operands of each atom that is the result of another operation.
        blocks: arguments of each live block.
        outputs: values of the outputs.
        checks: values of the checks.
    """

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self._graph = trace.graph
        self._uses = _uses(trace)
        self.kept = {x.index for x in trace.kept if isinstance(x, Symbol)}
        self.sums: dict[int, Sum] = {}
        self.operations: dict[int, tuple[str, Value, Value]] = {}
        self._read: dict[int, Sum] = {}
        for index in trace.live:
            self._read[index] = self._node(index)
        self.outputs = [self._operand(x) for x in trace.outputs]
        self.checks = [self._operand(check.value) for check in trace.checks]
        self.blocks: dict[int, list[list[Value]]] = {}
        for number in trace.live_blocks():
            arguments = self._graph.blocks[number].arguments
            self.blocks[number] = [[self._operand(x) for x in vector] for vector in arguments]

    def _node(self, index: int) -> Sum:
        op, a, b = self._graph.nodes[index]
        if op in ("input", "block") or index in self.kept:
            return {(index,): 1.0}
        if op in ("add", "sub"):
            sign = 1.0 if op == "add" else -1.0
            return _total(self._term(a), self._term(b), sign)
        if op == "neg":
            return _times(self._term(a), -1.0)
        if op == "mul":
            if isinstance(b, float):
                return _times(self._term(a), b)
            return self._product(int(a), int(b))
        self.operations[index] = op, self._operand(a), self._operand(b)
        return {(index,): 1.0}

    def _term(self, x: Value) -> Sum:
        """An operand of a sum."""
        if isinstance(x, float):
            return {(): x}
        if len(self._read[x]) > 1 and self._uses[x] > 1:
            self._cut(x)
        return self._read[x]

    def _product(self, a: int, b: int) -> Sum:
        first, k = self._factors(a)
        second, m = self._factors(b)
        if len(first) + len(second) > LONGEST:
            self._cut(a)
            self._cut(b)
            first, k = self._factors(a)
            second, m = self._factors(b)
        return _times({tuple(sorted(first + second)): 1.0}, k * m)

    def _factors(self, index: int) -> tuple[Factors, float]:
        """A node as one product with its coefficient."""
        if len(self._read[index]) != 1:
            self._cut(index)
        ((factors, coefficient),) = self._read[index].items()
        return factors, coefficient

    def _operand(self, x: Operand | Value) -> Value:
        """An operand as an atom or a constant."""
        if isinstance(x, float):
            return x
        index = x.index if isinstance(x, Symbol) else x
        return self._cut(index)

    def _cut(self, index: int) -> int:
        """The atom of a node; it becomes one if it is not."""
        terms = self._read[index]
        if len(terms) == 1:
            ((factors, coefficient),) = terms.items()
            if coefficient == 1.0 and len(factors) == 1:
                return factors[0]
        self.sums[index] = terms
        self._read[index] = {(index,): 1.0}
        return index


def _uses(trace: Trace) -> Counter[int]:
    """How often each node is used; arguments of blocks count as two uses."""
    graph: Graph = trace.graph
    uses: Counter[int] = Counter()
    for value in [*trace.outputs, *(check.value for check in trace.checks)]:
        if isinstance(value, Symbol):
            uses[value.index] += 1
    for number in trace.live_blocks():
        for symbol in graph.blocks[number].symbols():
            uses[symbol.index] += 2
    for index in trace.live:
        if graph.nodes[index][0] != "block":
            uses.update(graph.operands(index))
    return uses


def _total(a: Sum, b: Sum, sign: float) -> Sum:
    """a + sign b, without terms that cancel."""
    total = dict(a)
    for factors, coefficient in b.items():
        total[factors] = total.get(factors, 0.0) + sign * coefficient
    return {factors: k for factors, k in total.items() if k != 0.0}


def _times(terms: Sum, factor: float) -> Sum:
    scaled: Sum = {}
    for factors, coefficient in terms.items():
        k = coefficient * factor
        if abs(abs(k) - 1.0) < ROUNDING:
            k = round(k)
        scaled[factors] = float(k)
    return scaled
