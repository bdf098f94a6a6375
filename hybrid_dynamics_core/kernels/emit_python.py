"""Python source from a trace, for one state: numbered variables and numbers only, never a name out of a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from .graph import Operand, Symbol
from .trace import Trace, body_name, trace_body

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
        self._called: set[int] = set()
        live = trace.live
        uses = Counter(o for i in live for o in trace.graph.operands(i))
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
        if op == "block":
            return self._block(int(a), int(b))
        left = self._operand(a)
        if op == "neg":
            return _Term(f"(-{left.text})", left.depth + 1)
        right = self._operand(b)
        depth = max(left.depth, right.depth) + 1
        if op in _INFIX:
            return _Term(f"({left.text} {_INFIX[op]} {right.text})", depth)
        arguments = f"{left.text}, {right.text}" if op == "atan2" else left.text
        return _Term(f"{_CALLS[op]}({arguments})", depth)

    def _block(self, number: int, output: int) -> _Term:
        if number not in self._called:
            self._called.add(number)
            self.lines.append(f"b{number} = {block_call(self.trace, number, self.value)}")
        return _Term(f"b{number}[{output}]", 0)

    def value(self, x: Operand) -> str:
        """Source of an output."""
        return self.terms[x.index].text if isinstance(x, Symbol) else repr(float(x))


def block_call(trace: Trace, number: int, value: Callable[[Operand], str]) -> str:
    """Source of a call of the function in `algebra.numerics` that does a block."""
    block = trace.graph.blocks[number]
    vectors = [f"[{', '.join(value(x) for x in vector)}]" for vector in block.arguments]
    if block.body is None:
        return f"{block.kind}({vectors[0]}, {block.size})"
    return f"{block.kind}({_function(body_name(trace, number))}, {', '.join(vectors)})"


def _function(name: str) -> str:
    return f"body_{name.replace('.', '_')}"


def emit_bodies(trace: Trace) -> str:
    """Source of what the live blocks iterate: unknowns and parameters in, flat residuals and Jacobian out."""
    text = ""
    for number in trace.live_blocks():
        if trace.graph.blocks[number].body is not None:
            inner = trace_body(trace, number)
            body = _Body(inner)
            lines = [f"def {_function(inner.name)}(a0, a1):", *_unpacking(inner), *body.lines]
            lines.append(f"return [{', '.join(body.value(o) for o in inner.outputs)}]")
            text += emit_bodies(inner) + "\n    ".join(lines) + "\n"
    return text


def emit_scalar(trace: Trace) -> str:
    """`def kernel(a0, a1, ...)`: sequences of floats in; (status, list of floats) out.

    Status 0 is good.
    """
    body = _Body(trace)
    head = f"def kernel({', '.join(f'a{v}' for v in range(len(trace.inputs)))}):"
    lines = [head, *_unpacking(trace), *body.lines, "status = 0"]
    lines += [  # the first check that fails names the status
        f"if not {body.value(check.value)} > {check.threshold!r}: status = {check.code}"
        for check in reversed(trace.checks)
    ]
    lines.append(f"return status, [{', '.join(body.value(o) for o in trace.outputs)}]")
    return emit_bodies(trace) + "\n    ".join(lines) + "\n"


def _unpacking(trace: Trace) -> list[str]:
    used = trace.used_inputs()
    lines = []
    for v, size in enumerate(trace.inputs):
        names = [f"a{v}_{k}" if (v, k) in used else "_" for k in range(size)]
        if any(n != "_" for n in names):
            lines.append(f"{', '.join(names)}{',' if size == 1 else ''} = a{v}")
    return lines
