"""NumPy source from a trace, for many states: one call per operation, with reused memory."""

from __future__ import annotations

from .emit_python import block_call, emit_bodies
from .graph import Operand, Symbol
from .trace import Trace

_CALLS = {
    "add": "add",
    "sub": "subtract",
    "mul": "multiply",
    "div": "divide",
    "neg": "negative",
    "sin": "sin",
    "cos": "cos",
    "sqrt": "sqrt",
    "abs": "absolute",
    "rint": "rint",
    "atan2": "arctan2",
}
_UNARY = {"neg", "sin", "cos", "sqrt", "abs", "rint"}


class _Rows:
    """Statements for the live nodes, with allocation of rows of scratch memory."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.lines: list[str] = []
        self.rows = 0
        self._free: list[str] = []
        self._names: dict[int, str] = {}
        self._called: set[int] = set()
        self._last = _last_uses(trace)
        self._outputs = _output_rows(trace)
        for index in trace.live:
            self._node(index)

    def _node(self, index: int) -> None:
        op, a, b = self.trace.graph.nodes[index]
        if op == "input":
            self._names[index] = f"a{a}_{b}"
        elif op == "block":
            self._call(int(a))
            self._names[index] = f"b{a}[{int(b)}]"
        else:
            operands = [self._operand(a)]
            if op not in _UNARY:
                operands.append(self._operand(b))
            for x in self.trace.graph.operands(index):  # a result may reuse the row of an operand
                self._release(x, index)
            name = self._outputs.get(index) or self._row()
            self._names[index] = name
            self.lines.append(f"{_CALLS[op]}({', '.join(operands)}, {name})")

    def _call(self, number: int) -> None:
        if number not in self._called:
            self._called.add(number)
            self.lines.append(f"b{number} = {block_call(self.trace, number, self.value)}")

    def _operand(self, x: int | float) -> str:
        return self._names[x] if isinstance(x, int) else repr(x)

    def _release(self, node: int, user: int) -> None:
        name = self._names[node]
        if self._last[node] == user and name[0] == "s" and name not in self._free:
            self._free.append(name)

    def _row(self) -> str:
        if not self._free:
            self._free.append(f"s{self.rows}")
            self.rows += 1
        return self._free.pop()

    def value(self, x: Operand) -> str:
        """Name of a node's array, or a number."""
        return self._names[x.index] if isinstance(x, Symbol) else repr(float(x))


def _output_rows(trace: Trace) -> dict[int, str]:
    """For each node that is an output, the name of its first output."""
    names: dict[int, str] = {}
    for k, output in enumerate(trace.outputs):
        if isinstance(output, Symbol):
            names.setdefault(output.index, f"o{k}")
    return names


def _last_uses(trace: Trace) -> dict[int, int]:
    """For each node, the last one that uses it; values of checks are kept to the end."""
    last: dict[int, int] = {}
    for index in trace.live:
        for x in trace.graph.operands(index):
            last[x] = index
    for check in trace.checks:
        if isinstance(check.value, Symbol):
            last[check.value.index] = len(trace.graph.nodes)
    return last


def emit_columns(trace: Trace) -> str:
    """The source of `kernel(a0, a1, ..., scratch, out, status)`.

    Inputs are arrays of components; `out` (outputs, N) and `status` (N,) are filled. `ROWS` is the
    number of rows of N numbers in `scratch`.
    """
    rows = _Rows(trace)
    arguments = ", ".join(f"a{v}" for v in range(len(trace.inputs)))
    lines = [f"def kernel({arguments}, scratch, out, status):"]
    lines += [f"a{v}_{k} = a{v}[{k}]" for v, k in sorted(trace.used_inputs())]
    lines += [f"s{k} = scratch[{k}]" for k in range(rows.rows)]
    lines += [f"o{k} = out[{k}]" for k in range(len(trace.outputs))]
    lines += rows.lines
    for k, output in enumerate(trace.outputs):
        name = rows.value(output)
        if name != f"o{k}":
            lines.append(f"o{k}[:] = {name}")
    lines.append("status[:] = 0")
    for check in reversed(trace.checks):  # the first failed check decides the status
        fails = f"logical_not(greater({rows.value(check.value)}, {check.threshold!r}))"
        lines.append(f"status[{fails}] = {check.code}")
    return f"ROWS = {rows.rows}\n" + emit_bodies(trace) + "\n    ".join(lines) + "\n"
