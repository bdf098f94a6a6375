"""The part of a trace that is rewritten, and its way back among the other outputs.

The part is the same in all programs that have its outputs and checks. For that, the order of its
nodes depends on what they compute, and not on when a program did. The other outputs keep their
nodes as they are. Their operands stay in order, which decides which product is fused with a sum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from hashlib import blake2b

from ..graph import Graph, Operand, Symbol
from ..trace import Trace

_COMMUTATIVE = ("add", "mul")


def ordered(trace: Trace, names: Sequence[str]) -> Trace:
    """The named outputs and the checks as a trace, its nodes in an order of what they compute."""
    chosen = _chosen(trace, names)
    layout = tuple(entry for entry in trace.layout if entry[0] in names)
    part = replace(trace, outputs=tuple(chosen), layout=layout)
    kept = set(trace.graph.live(trace.kept))
    digests: dict[int, bytes] = {}
    depths: dict[int, int] = {}
    for index in part.live:
        digests[index] = _digest(part, index, digests)
        before = [depths[operand] for operand in part.graph.operands(index)]
        depths[index] = 1 + max(before, default=0)
    copy = Copy(trace.graph, Graph())
    for index in sorted(part.live, key=lambda k: (depths[k], digests[k])):
        copy.add(index, keep=index in kept)
    return replace(
        part,
        graph=copy.target,
        outputs=tuple(copy.value(x) for x in chosen),
        checks=tuple(replace(check, value=copy.value(check.value)) for check in trace.checks),
        kept=tuple(copy.at(index) for index in part.live if index in kept),
    )


def joined(trace: Trace, part: Trace) -> Trace:
    """A trace that takes its rewritable outputs and its checks from the rewritten part."""
    copy = Copy(trace.graph, part.graph)
    others = [name for name, _ in trace.layout if name not in part.rewritable]
    for index in trace.graph.live(_chosen(trace, others)):
        copy.add(index, keep=True)
    rewritten_outputs = iter(part.outputs)
    outputs: list[Operand] = []
    for x, is_other in zip(trace.outputs, _flags(trace, others), strict=True):
        if is_other:
            outputs.append(copy.value(x))
        else:
            outputs.append(next(rewritten_outputs))
    return replace(trace, graph=part.graph, outputs=tuple(outputs), checks=part.checks, kept=())


def _chosen(trace: Trace, names: Sequence[str]) -> list[Operand]:
    """The flat outputs of some names."""
    flags = _flags(trace, names)
    return [x for x, is_chosen in zip(trace.outputs, flags, strict=True) if is_chosen]


def _flags(trace: Trace, names: Sequence[str]) -> list[bool]:
    """Whether each flat output belongs to one of the names."""
    flags: list[bool] = []
    for name, shape in trace.layout:
        flags += [name in names] * math.prod(shape)
    return flags


def _digest(trace: Trace, index: int, digests: dict[int, bytes]) -> bytes:
    """A digest of what a node computes, from those of its operands."""
    op, a, b = trace.graph.nodes[index]
    parts: list[bytes] = []
    if op == "block":
        block = trace.graph.blocks[int(a)]
        parts = [digests[symbol.index] for symbol in block.symbols()]
        op = f"{block.kind} {block.size} {b}"
    elif op == "input":
        op = f"input {a} {b}"
    else:
        for x in (a, b):
            parts.append(digests[x] if isinstance(x, int) else repr(x).encode())
        if op in _COMMUTATIVE:
            parts.sort()
    return blake2b(b" ".join([op.encode(), *parts]), digest_size=12).digest()


class Copy:
    """Copies nodes from a graph to another one.

    Attributes:
        target: the other graph.
    """

    def __init__(self, source: Graph, target: Graph) -> None:
        self.target = target
        self._source = source
        self._copies: dict[int, Operand] = {}

    def add(self, index: int, *, keep: bool) -> None:
        """Copy a node whose operands are copied; they stay in order if `keep` is set."""
        op, a, b = self._source.nodes[index]
        if op == "input":
            self._copies[index] = self.target.input(int(a), int(b))
        elif op == "block":
            block = self._source.blocks[int(a)]
            arguments = [list(map(self.value, vector)) for vector in block.arguments]
            outputs = self.target.block(
                block.kind, block.size, block.outputs, arguments, block.body
            )
            self._copies[index] = outputs[int(b)]
        else:
            first, second = self._operand(a), self._operand(b)
            apply = self.target.keep if keep else self.target.apply
            self._copies[index] = apply(op, first, second)

    def at(self, index: int) -> Operand:
        """The copy of a node."""
        return self._copies[index]

    def value(self, x: Operand) -> Operand:
        """The copy of a value; constants stay as they are."""
        return self._copies[x.index] if isinstance(x, Symbol) else x

    def _operand(self, x: int | float) -> Operand:
        """The copy of an operand in the graph, which is a node or a constant."""
        return self._copies[x] if isinstance(x, int) else x
