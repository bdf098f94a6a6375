"""Shared sums of products as a trace."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from ..graph import Graph, Operand
from ..trace import Check, Trace
from .part import joined, ordered
from .read import Factors, Sums, Value
from .share import SharedSums, share

# [nodes] up to which a trace is rewritten, and rewritten twice, which saves 1 % more operations.
# Longer traces would take seconds.
LONGEST_TRACES = (20_000, 5000)


def rewritten(trace: Trace) -> Trace:
    """A trace whose rewritable outputs take fewer operations, equal but for rounding.

    Programs with iterations stay as they are: the calls of one state would become slower.
    """
    names = trace.rewritable
    if not names or trace.live_blocks() or len(trace.live) > LONGEST_TRACES[0]:
        return trace
    part = ordered(trace, names)
    shorter = part
    for longest in LONGEST_TRACES:
        if len(part.live) <= longest:
            sums = Sums(shorter)
            candidate = _Writer(sums, share(sums)).write()
            shorter = min(shorter, candidate, key=_cost)
    if shorter is part:
        return trace
    return joined(trace, shorter)


def _cost(trace: Trace) -> int:
    """Number of operations; multiplications count twice, since additions run beside them."""
    operations = Counter(trace.graph.nodes[index][0] for index in trace.live)
    return 2 * operations["mul"] + operations["add"] + operations["sub"] + operations["neg"]


class _Writer:
    """Writes atoms into a new graph, each after what it depends on."""

    def __init__(self, sums: Sums, shared: SharedSums) -> None:
        self._sums = sums
        self._shared = shared
        self._graph = Graph()
        self._written: dict[int, Operand] = dict(shared.constants)
        self._negated: set[int] = set()  # atoms that are written with the other sign

    def write(self) -> Trace:
        """The trace of all outputs and checks."""
        trace = self._sums.trace
        for vector, size in enumerate(trace.inputs):
            for k in range(size):
                self._graph.input(vector, k)
        for value in [*self._sums.checks, *self._sums.outputs]:
            if isinstance(value, int):
                self._write_with_operands(value)
        outputs = tuple(self._value(x) for x in self._sums.outputs)
        checks: list[Check] = []
        for check, value in zip(trace.checks, self._sums.checks, strict=True):
            checks.append(Check(self._value(value), check.threshold, check.code))
        kept = tuple(self._written[atom] for atom in self._sums.kept if atom in self._written)
        return replace(trace, graph=self._graph, outputs=outputs, checks=tuple(checks), kept=kept)

    def _write_with_operands(self, root: int) -> None:
        """Write an atom after what it depends on, depth first: values are used soon."""
        waiting = [(root, False)]
        while waiting:
            atom, is_ready = waiting.pop()
            if atom in self._written:
                continue
            if is_ready:
                self._written[atom] = self._node(atom)
                continue
            waiting.append((atom, True))
            operands = reversed(self._operands(atom))
            waiting += [(x, False) for x in operands if x not in self._written]

    def _operands(self, atom: int) -> list[int]:
        """The atoms that an atom is computed from."""
        operands: list[Value] = []
        if atom in self._shared.terms:
            for _, factors in self._shared.terms[atom]:
                operands += factors
        elif atom in self._sums.operations:
            _, *operands = self._sums.operations[atom]
        else:
            op, number, _ = self._sums.trace.graph.nodes[atom]
            if op != "block":
                return self._sums.trace.graph.operands(atom)
            for vector in self._sums.blocks[int(number)]:
                operands += vector
        return [x for x in operands if isinstance(x, int)]

    def _node(self, atom: int) -> Operand:
        """Write an atom whose operands are written."""
        if atom in self._shared.terms:
            return self._sum(atom)
        if atom in self._sums.operations:
            op, a, b = self._sums.operations[atom]
            return self._graph.apply(op, self._value(a), self._value(b))
        op, a, b = self._sums.trace.graph.nodes[atom]
        if op == "input":
            return self._graph.input(int(a), int(b))
        if op == "neg":
            return self._other_sign(atom, int(a))
        if op != "block":
            return self._graph.keep(op, self._value(a), self._value(b))
        block = self._sums.trace.graph.blocks[int(a)]
        arguments = [list(map(self._value, vector)) for vector in self._sums.blocks[int(a)]]
        outputs = self._graph.block(block.kind, block.size, block.outputs, arguments, block.body)
        return outputs[int(b)]

    def _other_sign(self, atom: int, operand: int) -> Operand:
        """An atom as its operand, with the other sign."""
        if operand not in self._negated:
            self._negated.add(atom)
        return self._written[operand]

    def _sum(self, atom: int) -> Operand:
        """A sum that begins with a positive term, which saves a change of sign.

        Where there is none, the sum is written with the other sign. Without terms it is zero.
        """
        terms = [(self._sign(sign, factors), factors) for sign, factors in self._shared.terms[atom]]
        if not terms:
            return 0.0
        positive = [k for k, (sign, _) in enumerate(terms) if sign > 0]
        first = 0
        if positive:
            first = positive[0]
        else:
            self._negated.add(atom)
            terms = [(-sign, factors) for sign, factors in terms]
        terms = [terms[first], *terms[:first], *terms[first + 1 :]]
        total: Operand = 0.0
        for sign, factors in terms:
            product: Operand = 1.0
            for factor in reversed(factors):  # constants come last
                product = self._written[factor] * product
            total = total + product if sign > 0 else total - product
        return total

    def _sign(self, sign: int, factors: Factors) -> int:
        """The sign of a term whose factors are as they are written."""
        for factor in factors:
            if factor in self._negated:
                sign = -sign
        return sign

    def _value(self, x: Value) -> Operand:
        """The operand of an atom that is written, or a constant."""
        if isinstance(x, float):
            return x
        if x in self._negated:
            return -self._written[x]
        return self._written[x]
