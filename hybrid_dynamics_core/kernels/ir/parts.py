"""Division of a long trace into several functions, which pass values through memory.

LLVM's time for a function grows faster than the function's length. Parts keep it proportional to
the trace. But an undivided function runs faster, since it needs no memory between parts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..graph import Symbol
from ..trace import Trace
from .nodes import CallBlock, Fetch, Nodes
from .text import ALIGNED, Function, Lanes

UNDIVIDED = 20_000  # [nodes] longest trace in one part
PART = 2000  # [nodes] part of a longer trace


class Parts:
    """The live nodes of a trace, divided into parts.

    Attributes:
        trace: the trace.
        width: number of states per vector.
        name: name of the functions.
        parameters: parameters of the functions, with types.
        slots: number of memory slots between parts.
    """

    def __init__(
        self, trace: Trace, width: int, name: str, parameters: Sequence[str], fetch: Fetch
    ) -> None:
        self.trace = trace
        self.width = width
        self.name = name
        self.parameters = list(parameters)
        self._fetch_input = fetch
        self._divided = _divide(trace)
        self._place, self.slots = _places(trace, self._divided)

    def nodes(self, lanes: Lanes, call: CallBlock) -> Nodes:
        """Access to the values of all nodes in a function with the same parameters."""
        if len(self._divided) == 1:
            return Nodes(self.trace, lanes, self._divided[0], self._fetch_input, call)
        memory = lanes.function.slot(lanes.kind, self.slots)
        arguments = ", ".join([*self.parameters, f"ptr {memory}"])
        for k in range(len(self._divided)):
            lanes.function.do(f"call void @{self.name}.{k}({arguments})")
        return Nodes(self.trace, lanes, [], self._from(memory), call)

    def functions(self, call: CallBlock) -> list[str]:
        """The functions of the parts; empty if the trace is undivided."""
        if len(self._divided) == 1:
            return []
        return [self._function(k, call) for k in range(len(self._divided))]

    def _function(self, k: int, call: CallBlock) -> str:
        parameters = ", ".join([*self.parameters, "ptr %memory"])
        f = Function(f"define internal void @{self.name}.{k}({parameters}) {ALIGNED}")
        lanes = Lanes(f, self.width)
        part = self._divided[k]
        nodes = Nodes(self.trace, lanes, part, self._from("%memory"), call)
        for index in part:
            if index in self._place:
                value = nodes.value(index)
                place = self._address(f, "%memory", index)
                f.do(f"store {lanes.kind} {value}, ptr {place}, align 8")
        f.do("ret void")
        return f.text()

    def _from(self, memory: str) -> Fetch:
        def fetch(lanes: Lanes, index: int) -> str:
            if index not in self._place:
                return self._fetch_input(lanes, index)
            place = self._address(lanes.function, memory, index)
            return lanes.function.let(f"load {lanes.kind}, ptr {place}, align 8")

        return fetch

    def _address(self, f: Function, memory: str, index: int) -> str:
        return f.at(memory, self._place[index] * self.width)


def _divide(trace: Trace) -> list[list[int]]:
    """Live nodes in parts of about equal length; outputs of one block stay together."""
    total = len(trace.live)
    count = 1
    if total > UNDIVIDED:
        count = math.ceil(total / PART)
    length = max(1, math.ceil(total / count))
    parts: list[list[int]] = [[]]
    for index in trace.live:
        kind = trace.graph.nodes[index][0]
        if len(parts[-1]) >= length and kind != "block":
            parts.append([])
        parts[-1].append(index)
    return parts


def _last_uses(trace: Trace, parts: list[list[int]]) -> dict[int, int]:
    """For each node used in a later part, the last such part; results count as used at the end."""
    owner = _owners(trace, parts)
    last: dict[int, int] = {}
    for k, part in enumerate(parts):
        for index in part:
            for operand in trace.graph.operands(index):
                if owner.get(operand, k) < k:
                    last[operand] = k
    checked = [check.value for check in trace.checks]
    for result in (*trace.outputs, *checked):
        if isinstance(result, Symbol) and result.index in owner:
            last[result.index] = len(parts)
    return last


def _owners(trace: Trace, parts: list[list[int]]) -> dict[int, int]:
    """The part that computes each node."""
    owner: dict[int, int] = {}
    for k, part in enumerate(parts):
        for index in part:
            if trace.graph.nodes[index][0] != "input":
                owner[index] = k
    return owner


def _places(trace: Trace, parts: list[list[int]]) -> tuple[dict[int, int], int]:
    """The memory slot of each node that a later part needs, and the number of slots.

    A slot is reused after the last use of its node.
    """
    last = _last_uses(trace, parts)
    place: dict[int, int] = {}
    free: list[int] = []
    total = 0
    for k, part in enumerate(parts):
        for index, end in last.items():
            if end == k - 1 and index in place:
                free.append(place[index])
        for index in part:
            if index in last:
                if not free:
                    free.append(total)
                    total += 1
                place[index] = free.pop()
    return place, total
