"""The C functions of a large robot, traced in one graph: what several need is written once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from ...kernels.graph import Graph, Symbol
from ...kernels.trace import Trace
from .emit import Body, block_functions, checks_of, function_name, outputs_of, with_helpers
from .parts import Text, in_parts

LARGE = 10_000  # operations of all functions above which they share
LEAST = 200  # operations that are worth a shared function
CallSet = frozenset[int]  # numbers of functions that are called


@dataclass(frozen=True)
class _Group:
    """A shared function, whose results several functions need.

    Attributes:
        calls: numbers of the functions that need it.
        nodes: what it computes, in order.
    """

    calls: CallSet
    nodes: list[int]


def emit_shared(traces: Sequence[Trace]) -> list[str]:
    """The C functions of traces of one graph; those that others call come first."""
    plan = _Plan(traces)
    vectors = len(traces[0].inputs)
    texts = block_functions(plan.all)
    for number, group in enumerate(plan.groups):
        body = Body(plan.all, group.nodes, plan.places(vectors))
        results = [k for k in group.nodes if k in plan.slots]
        last = [f"out[{plan.slots[k]}] = {body.term(k)};" for k in results]
        text = Text("void", f"shared{number}", vectors + 1, body.lines, last)
        texts += in_parts(text)
    for number, trace in enumerate(traces):
        nodes = plan.nodes_of(number)
        body = Body(plan.all, nodes, plan.places(vectors))
        last = [*checks_of(trace, body), *outputs_of(trace, body), "return 0;"]
        name = f"{function_name(trace.name)}_after"
        text = Text("int", name, vectors + 1, body.lines, last)
        texts += in_parts(text)
        texts.append(_caller(trace, plan, number, vectors))
    return with_helpers(texts)


class _Plan:
    """Which operations are shared, and where their values are passed on.

    Attributes:
        all: one trace with the outputs and checks of all functions.
        groups: the shared functions; those that more functions need come first.
        slots: indices of values in the C array `shared`, by node.
    """

    def __init__(self, traces: Sequence[Trace]) -> None:
        self._graph: Graph = traces[0].graph
        self.all = replace(
            traces[0],
            outputs=tuple(chain.from_iterable(trace.outputs for trace in traces)),
            checks=tuple(chain.from_iterable(trace.checks for trace in traces)),
            layout=(),
            name="shared",
        )
        self._roots = [_roots(trace) for trace in traces]
        calls_of = self._calls_of_nodes(traces)
        sizes = Counter(calls_of.values())
        large = [calls for calls, size in sizes.items() if len(calls) > 1 and size >= LEAST]
        self.groups: list[_Group] = []
        for calls in sorted(large, key=len, reverse=True):
            wanted = [k for k, needed_by in calls_of.items() if needed_by == calls]
            nodes = self._missing(wanted, self._available(calls))
            self.groups.append(_Group(calls, nodes))
        self._number_slots(len(traces))

    def places(self, vector: int) -> dict[int, str]:
        """C terms for values that a group has written, by node; they are in an input vector."""
        return {k: f"a{vector}[{slot}]" for k, slot in self.slots.items()}

    def nodes_of(self, call: int) -> list[int]:
        """Nodes that a function computes after its groups, in order."""
        return self._missing(self._roots[call], self._available(frozenset([call])))

    def _calls_of_nodes(self, traces: Sequence[Trace]) -> dict[int, CallSet]:
        """The functions that need each node; all outputs of a block are needed together."""
        calls: dict[int, set[int]] = {}
        blocks: dict[int, set[int]] = {}
        for number, trace in enumerate(traces):
            for k in trace.live:
                op, a, _ = self._graph.nodes[k]
                members: set[int] = set()
                if op == "block":
                    members = blocks.setdefault(int(a), members)
                calls.setdefault(k, members).add(number)
        return {k: frozenset(calls[k]) for k in sorted(calls)}

    def _available(self, calls: CallSet) -> set[int]:
        """Nodes of the groups that all of some functions call; inputs are read where needed."""
        available: set[int] = set()
        for group in self.groups:
            if group.calls >= calls:
                available.update(k for k in group.nodes if self._graph.nodes[k][0] != "input")
        return available

    def _missing(self, wanted: Iterable[int], available: set[int]) -> list[int]:
        """The wanted nodes and all they depend on, without available ones, in order."""
        missing: set[int] = set()
        ahead = [k for k in wanted if k not in available]
        while ahead:
            k = ahead.pop()
            if k not in missing:
                missing.add(k)
                ahead += [x for x in self._graph.operands(k) if x not in available]
        return sorted(missing)

    def _number_slots(self, count: int) -> None:
        """Give an index to every value that is read outside of its group."""
        self.slots: dict[int, int] = {}
        functions = [(group.nodes, group.nodes) for group in self.groups]
        for call in range(count):
            nodes = self.nodes_of(call)
            functions.append((nodes, [*nodes, *self._roots[call]]))
        for nodes, results in functions:
            read = set(results)
            for k in nodes:
                read.update(self._graph.operands(k))
            for k in sorted(read.difference(nodes)):
                self.slots.setdefault(k, len(self.slots))


def _roots(trace: Trace) -> list[int]:
    """Nodes that are outputs or values of checks."""
    values = [*trace.outputs, *(check.value for check in trace.checks)]
    return [x.index for x in values if isinstance(x, Symbol)]


def _caller(trace: Trace, plan: _Plan, number: int, vectors: int) -> str:
    """The C function of a trace: it calls its groups, then computes what only it needs."""
    arguments = "".join(f"const double *a{v}, " for v in range(vectors))
    passed = "".join(f"a{v}, " for v in range(vectors))
    lines = [f"double shared[{max(1, len(plan.slots))}];", "shared[0] = 0.0;"]
    for index, group in enumerate(plan.groups):
        if number in group.calls:
            lines.append(f"shared{index}({passed}shared, shared);")
    name = function_name(trace.name)
    lines.append(f"return {name}_after({passed}shared, out);")
    body = "\n".join(f"    {line}" for line in lines)
    return f"static int {name}({arguments}double *out)\n{{\n{body}\n}}\n"
