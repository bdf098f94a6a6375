"""A trace as sums of products of atoms.

An atom is an input, or the result of another operation than +, - and *. A sum that is used more
than once, or multiplied, is an atom too.
"""

from __future__ import annotations

from collections import Counter

from ..graph import Graph, Operand, Symbol
from ..trace import Trace

LONGEST = 6  # [factors] the operands of a longer product become atoms
ROUNDING = 5e-16  # a coefficient as near as this to 1 or -1 is 1 or -1

Factors = tuple[int, ...]  # atoms in ascending order
Sum = dict[Factors, float]  # coefficient of each product, in order of appearance
Value = int | float  # an atom or a constant


class Sums:
    """The sums of products of a trace.

    Attributes:
        trace: the trace.
        kept: nodes that are not rewritten; each is an atom.
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
            self.blocks[number] = [list(map(self._operand, vector)) for vector in arguments]

    def _node(self, index: int) -> Sum:
        """A node as a sum of products of atoms."""
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
        """An operand of a sum as terms of it; a sum with more uses stays an atom."""
        if isinstance(x, float):
            return {(): x}
        if len(self._read[x]) > 1 and self._uses[x] > 1:
            self._cut(x)
        return self._read[x]

    def _product(self, a: int, b: int) -> Sum:
        """The product of two nodes."""
        first, coefficient = self._factors(a)
        second, other = self._factors(b)
        if len(first) + len(second) > LONGEST:
            self._cut(a)
            self._cut(b)
            first, coefficient = self._factors(a)
            second, other = self._factors(b)
        factors = tuple(sorted(first + second))
        return _times({factors: 1.0}, coefficient * other)

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
        """The atom of a node; a node that is none becomes one."""
        terms = self._read[index]
        if len(terms) == 1:
            ((factors, coefficient),) = terms.items()
            if coefficient == 1.0 and len(factors) == 1:
                return factors[0]
        self.sums[index] = terms
        self._read[index] = {(index,): 1.0}
        return index


def _uses(trace: Trace) -> Counter[int]:
    """How often each node is used; arguments of blocks count twice, so that sums stay atoms."""
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
    """A sum times a constant."""
    scaled: Sum = {}
    for factors, coefficient in terms.items():
        k = coefficient * factor
        if abs(abs(k) - 1.0) < ROUNDING:
            k = round(k)
        scaled[factors] = float(k)
    return scaled
