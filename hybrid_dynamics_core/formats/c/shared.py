"""Functions of large robots, traced in one graph: what several of them need is written once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ...kernels.graph import Graph, Symbol
from ...kernels.trace import Trace
from .emit import Body, block_functions, checks_of, function_name, outputs_of, with_helpers
from .parts import Text, in_parts

LARGE = 10_000  # operations of all functions above which they share
LEAST = 200  # operations of a shared function
CallSet = frozenset[int]


@dataclass(frozen=True)
class _Group:
    """A shared function.

    Attributes:
        calls: which functions need it.
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
        exports = [k for k in group.nodes if k in plan.slots]
        last = [f"out[{plan.slots[k]}] = {body.term(k)};" for k in exports]
        texts += in_parts(Text("void", f"shared{number}", vectors + 1, body.lines, last))
    for number, trace in enumerate(traces):
        nodes = plan.nodes_of(number)
        body = Body(plan.all, nodes, plan.places(vectors))
        last = [*checks_of(trace, body), *outputs_of(trace, body), "return 0;"]
        name = f"{function_name(trace.name)}_after"
        texts += in_parts(Text("int", name, vectors + 1, body.lines, last))
        texts.append(_caller(trace, plan, number, vectors))
    return with_helpers(texts)


class _Plan:
    """Which operations are shared, and where their values are handed on.

    Attributes:
        all: a trace of everything.
        groups: the shared functions, those that more functions need first.
        slots: places of values in the array `shared`, by node.
    """

    def __init__(self, traces: Sequence[Trace]) -> None:
        self._graph: Graph = traces[0].graph
        outputs = [y for trace in traces for y in trace.outputs]
        checks = [check for trace in traces for check in trace.checks]
        self.all = replace(
            traces[0], outputs=tuple(outputs), checks=tuple(checks), layout=(), name="shared"
        )
        self._roots = [_roots(trace) for trace in traces]
        calls = self._calls_of_nodes(traces)
        sizes: dict[CallSet, int] = {}
        for members in calls.values():
            sizes[members] = sizes.get(members, 0) + 1
        is_shared = [x for x, size in sizes.items() if len(x) > 1 and size >= LEAST]
        self.groups: list[_Group] = []
        for members in sorted(is_shared, key=len, reverse=True):
            wanted = [k for k, x in calls.items() if x == members]
            nodes = self._missing(wanted, self._available(members))
            self.groups.append(_Group(members, nodes))
        self._number_slots(len(traces))

    def places(self, vector: int) -> dict[int, str]:
        """Where values are read that a group has written, by node."""
        return {k: f"a{vector}[{slot}]" for k, slot in self.slots.items()}

    def nodes_of(self, call: int) -> list[int]:
        """What a function computes after its groups."""
        return self._missing(self._roots[call], self._available(frozenset([call])))

    def _calls_of_nodes(self, traces: Sequence[Trace]) -> dict[int, CallSet]:
        """The functions that need each node; all outputs of a block are needed together."""
        calls: dict[int, set[int]] = {}
        blocks: dict[int, set[int]] = {}
        for number, trace in enumerate(traces):
            for k in trace.live:
                op, a, _ = self._graph.nodes[k]
                members = blocks.setdefault(int(a), set()) if op == "block" else set[int]()
                calls.setdefault(k, members).add(number)
        return {k: frozenset(calls[k]) for k in sorted(calls)}

    def _available(self, calls: CallSet) -> set[int]:
        """What the groups compute that run before, for some functions."""
        before: set[int] = set()
        for group in self.groups:
            if group.calls >= calls:
                before.update(k for k in group.nodes if self._graph.nodes[k][0] != "input")
        return before

    def _missing(self, wanted: Iterable[int], available: set[int]) -> list[int]:
        """Nodes to compute for the wanted ones, in order."""
        missing: set[int] = set()
        ahead = [k for k in wanted if k not in available]
        while ahead:
            k = ahead.pop()
            if k not in missing:
                missing.add(k)
                ahead += [x for x in self._graph.operands(k) if x not in available]
        return sorted(missing)

    def _number_slots(self, count: int) -> None:
        """Give a place to every value that is read outside of its group."""
        self.slots: dict[int, int] = {}
        units = [(group.nodes, group.nodes) for group in self.groups]
        for call in range(count):
            nodes = self.nodes_of(call)
            units.append((nodes, [*nodes, *self._roots[call]]))
        for nodes, read in units:
            needed = {x for k in nodes for x in self._graph.operands(k)}
            for k in sorted({*needed, *read} - {*nodes}):
                self.slots.setdefault(k, len(self.slots))


def _roots(trace: Trace) -> list[int]:
    values = [*trace.outputs, *(check.value for check in trace.checks)]
    return [x.index for x in values if isinstance(x, Symbol)]


def _caller(trace: Trace, plan: _Plan, number: int, vectors: int) -> str:
    """The function of a trace: it calls its groups, then the rest."""
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
