"""Python source from a trace, for one state.

It has numbered variables and numbers only, and no names of a file.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from .graph import Operand, Symbol
from .trace import Trace, body_name, trace_body

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_CALLS = {
    "sin": "sin",
    "cos": "cos",
    "sqrt": "sqrt",
    "abs": "fabs",
    "rint": "rint",
    "atan2": "atan2",
}
_DEPTH = 12  # nesting of brackets in a statement, far below the parser's limit


@dataclass
class _Term:
    text: str
    depth: int


class _Body:
    """Statements for the live nodes; a node that is used once is inlined."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.lines: list[str] = []
        self.terms: dict[int, _Term] = {}
        self._called: set[int] = set()
        uses = count_uses(trace)
        for index in trace.live:
            term = self._term(index)
            is_input = trace.graph.nodes[index][0] == "input"
            if is_input or uses[index] > 1 or term.depth >= _DEPTH:
                self.lines.append(f"v{index} = {term.text}")
                term = _Term(f"v{index}", 0)
            self.terms[index] = term

    def _operand(self, x: int | float) -> _Term:
        if isinstance(x, int):
            return self.terms[x]
        return _Term(f"({x!r})" if x < 0.0 else repr(x), 0)

    def _term(self, index: int) -> _Term:
        op, a, b = self.trace.graph.nodes[index]
        if op == "input":
            return _Term(f"a{a}_{b}", 0)
        if op == "block":
            return self._block(int(a), int(b))
        first = self._operand(a)
        if op == "neg":
            return _Term(f"(-{first.text})", first.depth + 1)
        second = self._operand(b)
        depth = max(first.depth, second.depth) + 1
        if op in _INFIX:
            return _Term(f"({first.text} {_INFIX[op]} {second.text})", depth)
        arguments = f"{first.text}, {second.text}" if op == "atan2" else first.text
        return _Term(f"{_CALLS[op]}({arguments})", depth)

    def _block(self, number: int, output: int) -> _Term:
        if number not in self._called:
            self._called.add(number)
            self.lines.append(f"b{number} = {block_call(self.trace, number, self.value)}")
        return _Term(f"b{number}[{output}]", 0)

    def value(self, x: Operand) -> str:
        """Source of an output."""
        return self.terms[x.index].text if isinstance(x, Symbol) else repr(float(x))


def count_uses(trace: Trace) -> Counter[int]:
    """Number of uses of each node; a check uses its value twice."""
    uses: Counter[int] = Counter()
    for index in trace.live:
        for operand in trace.graph.operands(index):
            uses[operand] += 1
    results = [*trace.outputs, *(2 * [check.value for check in trace.checks])]
    uses.update(x.index for x in results if isinstance(x, Symbol))
    return uses


def block_call(trace: Trace, number: int, value: Callable[[Operand], str]) -> str:
    """Source of a call of the function in `algebra.numerics` for a block."""
    block = trace.graph.blocks[number]
    vectors = [_list(map(value, vector)) for vector in block.arguments]
    if block.body is None:
        return f"{block.kind}({vectors[0]}, {block.size})"
    return f"{block.kind}({_function(body_name(trace, number))}, {', '.join(vectors)})"


def _list(values: Iterable[str]) -> str:
    return f"[{', '.join(values)}]"


def _function(name: str) -> str:
    return f"body_{name.replace('.', '_')}"


def emit_bodies(trace: Trace) -> str:
    """Source of the functions that the live Newton blocks call.

    Each function takes unknowns and parameters, and returns flat residuals and Jacobian.
    """
    text = ""
    for number in trace.live_blocks():
        if trace.graph.blocks[number].body is not None:
            inner = trace_body(trace, number)
            body = _Body(inner)
            lines = [f"def {_function(inner.name)}(a0, a1):", *_unpacking(inner), *body.lines]
            lines.append(f"return {_list(map(body.value, inner.outputs))}")
            text += emit_bodies(inner) + "\n    ".join(lines) + "\n"
    return text


def emit_scalar(trace: Trace) -> str:
    """The source of `kernel(a0, a1, ...)`.

    It takes sequences of floats, and returns the status (0 is good) and a list of floats.
    """
    body = _Body(trace)
    arguments = ", ".join(f"a{v}" for v in range(len(trace.inputs)))
    lines = [f"def kernel({arguments}):", *_unpacking(trace), *body.lines, "status = 0"]
    for check in reversed(trace.checks):  # the first failed check decides the status
        passes = f"{body.value(check.value)} > {check.threshold!r}"
        lines.append(f"if not {passes}: status = {check.code}")
    lines.append(f"return status, {_list(map(body.value, trace.outputs))}")
    return emit_bodies(trace) + "\n    ".join(lines) + "\n"


def _unpacking(trace: Trace) -> list[str]:
    """Statements that unpack the used components of the inputs."""
    used = trace.used_inputs()
    lines = []
    for vector, size in enumerate(trace.inputs):
        components = [k for k in range(size) if (vector, k) in used]
        if components:
            names = ["_"] * size
            for k in components:
                names[k] = f"a{vector}_{k}"
            lines.append(f"{', '.join(names)}{',' if size == 1 else ''} = a{vector}")
    return lines
