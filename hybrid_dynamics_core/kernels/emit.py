"""Python source from a trace: numbered variables and numbers only, never a name out of a file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from .graph import Symbol
from .trace import Trace

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_CALLS = {"sin": "sin", "cos": "cos", "sqrt": "sqrt", "abs": "fabs", "atan2": "atan2"}
_DEPTH = 12  # nesting of brackets in one statement: readable, and far below the parser's limit


@dataclass
class _Term:
    text: str
    depth: int


class _Body:
    """Statements that compute the live nodes; a node used once is written inside its user."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.lines: list[str] = []
        self.terms: dict[int, _Term] = {}
        live = trace.live()
        uses = Counter(
            o
            for i in live
            if trace.graph.nodes[i][0] != "input"
            for o in trace.graph.nodes[i][1:]
            if isinstance(o, int)
        )
        uses.update(o.index for o in trace.outputs if isinstance(o, Symbol))
        uses.update(2 * [c.value.index for c in trace.checks if isinstance(c.value, Symbol)])
        for index in live:
            term = self._term(index)
            if trace.graph.nodes[index][0] == "input" or uses[index] > 1 or term.depth >= _DEPTH:
                self.lines.append(f"v{index} = {term.text}")
                term = _Term(f"v{index}", 0)
            self.terms[index] = term

    def _operand(self, x: int | float) -> _Term:
        return self.terms[x] if isinstance(x, int) else _Term(f"({x!r})" if x < 0.0 else repr(x), 0)

    def _term(self, index: int) -> _Term:
        op, a, b = self.trace.graph.nodes[index]
        if op == "input":
            return _Term(f"a{a}_{b}", 0)
        left = self._operand(a)
        if op == "neg":
            return _Term(f"(-{left.text})", left.depth + 1)
        right = self._operand(b)
        depth = max(left.depth, right.depth) + 1
        if op in _INFIX:
            return _Term(f"({left.text} {_INFIX[op]} {right.text})", depth)
        arguments = f"{left.text}, {right.text}" if op == "atan2" else left.text
        return _Term(f"{_CALLS[op]}({arguments})", depth)

    def value(self, x: Symbol | float) -> str:
        """Source of an output."""
        return self.terms[x.index].text if isinstance(x, Symbol) else repr(float(x))


def emit_scalar(trace: Trace) -> str:
    """`def kernel(a0, a1, ...)`: sequences of floats in; (status, list of floats) out. Status 0 is good."""
    body = _Body(trace)
    lines = [f"def kernel({', '.join(f'a{v}' for v in range(len(trace.inputs)))}):"]
    used = _used_inputs(trace)
    lines += [f"    {names} = a{v}" for v, names in enumerate(_unpacking(trace, used)) if names]
    lines += [f"    {line}" for line in body.lines]
    lines.append("    status = 0")
    for check in reversed(trace.checks):  # the first check that fails names the status
        lines.append(f"    if not {body.value(check.value)} > {check.threshold!r}: status = {check.code}")
    lines.append(f"    return status, [{', '.join(body.value(o) for o in trace.outputs)}]")
    return "\n".join(lines) + "\n"


def emit_columns(trace: Trace) -> str:
    """`def kernel(a0, a1, ..., out, status)`: arrays (size, N) in, `out` (outputs, N) and `status` (N,) filled."""
    body = _Body(trace)
    lines = [f"def kernel({', '.join(f'a{v}' for v in range(len(trace.inputs)))}, out, status):"]
    lines += [f"    a{v}_{k} = a{v}[{k}]" for v, k in sorted(_used_inputs(trace))]
    lines += [f"    {line}" for line in body.lines]
    lines += [f"    out[{k}] = {body.value(o)}" for k, o in enumerate(trace.outputs)]
    lines.append("    status[:] = 0")
    for check in reversed(trace.checks):
        lines.append(f"    status[logical_not({body.value(check.value)} > {check.threshold!r})] = {check.code}")
    return "\n".join(lines) + "\n"


def _used_inputs(trace: Trace) -> set[tuple[int, int]]:
    nodes = (trace.graph.nodes[i] for i in trace.live())
    return {(int(a), int(b)) for op, a, b in nodes if op == "input"}


def _unpacking(trace: Trace, used: set[tuple[int, int]]) -> list[str]:
    result = []
    for v, size in enumerate(trace.inputs):
        names = [f"a{v}_{k}" if (v, k) in used else "_" for k in range(size)]
        result.append(", ".join(names) + ("," if size == 1 else "") if any(n != "_" for n in names) else "")
    return result
