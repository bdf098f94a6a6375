"""The operations of a trace in an order in which few values wait for their use.

A processor has few registers, and what does not fit waits in memory. Operations stay the same, so
results are equal to the last bit.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

from ..graph import Graph, Symbol
from ..trace import Check, Trace
from .part import Copy


def scheduled(trace: Trace) -> Trace:
    """The same trace in another order."""
    target = Graph()
    copy = Copy(trace.graph, target)
    for index in _Schedule(trace).order():
        copy.add(index, keep=True)
    outputs = tuple(map(copy.value, trace.outputs))
    checks: list[Check] = []
    for check in trace.checks:
        value = copy.value(check.value)
        checks.append(replace(check, value=value))
    return replace(trace, graph=target, outputs=outputs, checks=tuple(checks), kept=())


class _Schedule:
    """Depth first from checks and last outputs; what frees registers is computed at once.

    The last outputs come first, since the last joints of a chain need all that is before them. Of
    two operands, the one that takes more operations one after the other comes first.
    """

    def __init__(self, trace: Trace) -> None:
        self._trace = trace
        self._graph = trace.graph
        self._operands: dict[int, list[int]] = {}
        self._users: dict[int, list[int]] = defaultdict(list)
        self._missing: dict[int, int] = {}  # operands that are not computed yet
        self._depths: dict[int, int] = {}  # operations one after the other up to a node
        self._blocks: dict[int, list[int]] = defaultdict(list)  # outputs of each block
        for index in trace.live:
            self._read(index)
        self._uses = {index: len(users) for index, users in self._users.items()}
        self._order: dict[int, None] = {}

    def _read(self, index: int) -> None:
        nodes = self._graph.nodes
        kind, number, _ = nodes[index]
        if kind == "block":
            self._blocks[int(number)].append(index)
        distinct = dict.fromkeys(self._graph.operands(index))
        # inputs wait in memory anyway
        operands = [operand for operand in distinct if nodes[operand][0] != "input"]
        self._operands[index] = operands
        self._missing[index] = len(operands)
        depths = [self._depths[operand] for operand in operands]
        self._depths[index] = 1 + max(depths, default=0)
        for operand in operands:
            self._users[operand].append(index)

    def order(self) -> list[int]:
        """All live nodes, operands before their uses."""
        for index in self._trace.live:
            if self._graph.nodes[index][0] == "input":
                self._add(index)
        for root in self._roots():
            for index in self._depth_first(root):
                self._compute(index)
        return list(self._order)

    def _roots(self) -> Iterator[int]:
        checks = [check.value for check in self._trace.checks]
        for value in [*checks, *reversed(self._trace.outputs)]:
            if isinstance(value, Symbol):
                self._uses[value.index] = self._uses.get(value.index, 0) + 1
                yield value.index

    def _depth_first(self, root: int) -> Iterator[int]:
        """What a node depends on and is not computed, and the node."""
        waiting = [root]
        while waiting:
            index = waiting[-1]
            operands = [x for x in self._operands[index] if x not in self._order]
            if operands:
                waiting += sorted(operands, key=self._depths.__getitem__)  # the last is next
                continue
            waiting.pop()
            yield index

    def _compute(self, index: int) -> None:
        """Compute a node, then all for which a register gets free."""
        ready = [index]
        while ready:
            current = ready.pop()
            if current in self._order:
                continue
            if current != index and not self._frees(current):
                continue
            self._add(current)
            ready += self._ready(current)
            for operand in self._operands[current]:
                ready += self._ready(operand)

    def _ready(self, index: int) -> list[int]:
        """Uses of a node whose other operands are there too."""
        return [user for user in self._users[index] if not self._missing[user]]

    def _frees(self, index: int) -> bool:
        """Whether a node is the last use of one of its operands."""
        return any(self._uses[x] == 1 for x in self._operands[index])

    def _add(self, index: int) -> None:
        """Put a node into the order; outputs of a block come together."""
        kind, number, _ = self._graph.nodes[index]
        together = [index]
        if kind == "block":
            together = self._blocks[int(number)]
        for node in together:
            self._order[node] = None
            for operand in self._operands[node]:
                self._uses[operand] -= 1
            for user in self._users[node]:
                self._missing[user] -= 1
