"""Python source from a trace, for many states: one NumPy call an operation, results put into memory used again."""

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
    "atan2": "arctan2",
}
_UNARY = {"neg", "sin", "cos", "sqrt", "abs"}


class _Rows:
    """Statements for the live nodes; a row of scratch is free again after the last use of what it holds."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.lines: list[str] = []
        self.rows = 0
        self._free: list[str] = []
        self._names: dict[int, str] = {}
        self._called: set[int] = set()
        self._last = _last_uses(trace)
        self._kept = {
            o.index: f"o{k}"
            for k, o in reversed([*enumerate(trace.outputs)])
            if isinstance(o, Symbol)
        }
        for index in trace.live:
            self._node(index)

    def _node(self, index: int) -> None:
        op, a, b = self.trace.graph.nodes[index]
        if op == "input":
            self._names[index] = f"a{a}_{b}"
        elif op == "block":
            if a not in self._called:
                self._called.add(int(a))
                self.lines.append(f"b{a} = {block_call(self.trace, int(a), self.value)}")
            self._names[index] = f"b{a}[{int(b)}]"
        else:
            operands = [self._operand(x) for x in ((a,) if op in _UNARY else (a, b))]
            for x in self.trace.graph.operands(index):  # a result may lie where an operand lay
                self._release(x, index)
            name = self._names[index] = self._kept.get(index) or self._row()
            self.lines.append(f"{_CALLS[op]}({', '.join(operands)}, {name})")

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
        """Name of a node's values, or a number."""
        return self._names[x.index] if isinstance(x, Symbol) else repr(float(x))


def _last_uses(trace: Trace) -> dict[int, int]:
    """The last node that uses each; what a check looks at is kept to the end."""
    last = {x: index for index in trace.live for x in trace.graph.operands(index)}
    for check in trace.checks:
        if isinstance(check.value, Symbol):
            last[check.value.index] = len(trace.graph.nodes)
    return last


def emit_columns(trace: Trace) -> str:
    """`def kernel(a0, a1, ..., scratch, out, status)`: inputs by component, out (outputs, N) and status (N,) filled.

    `ROWS` says how many rows of N numbers the scratch needs.
    """
    rows = _Rows(trace)
    lines = [
        f"def kernel({', '.join(f'a{v}' for v in range(len(trace.inputs)))}, scratch, out, status):"
    ]
    lines += [f"a{v}_{k} = a{v}[{k}]" for v, k in sorted(trace.used_inputs())]
    lines += [f"s{k} = scratch[{k}]" for k in range(rows.rows)]
    lines += [f"o{k} = out[{k}]" for k in range(len(trace.outputs))]
    lines += rows.lines
    for k, o in enumerate(trace.outputs):
        if rows.value(o) != f"o{k}":
            lines.append(f"o{k}[:] = {rows.value(o)}")
    lines.append("status[:] = 0")
    for check in reversed(trace.checks):  # the first check that fails names the status
        lines.append(
            f"status[logical_not(greater({rows.value(check.value)}, {check.threshold!r}))] ="
            f" {check.code}"
        )
    return f"ROWS = {rows.rows}\n" + emit_bodies(trace) + "\n    ".join(lines) + "\n"
