"""Python source from a trace: numbered variables and numbers only, never a name out of a file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from .graph import Block, Symbol
from .trace import Results, Trace, trace

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
        self.bodies: list[str] = []  # sources of the functions that Newton iterates
        self._called: set[int] = set()
        live = trace.live()
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
        block = self.trace.graph.blocks[number]
        if number not in self._called:
            self._called.add(number)
            vectors = [f"[{', '.join(self.value(x) for x in vector)}]" for vector in block.arguments]
            if block.body is None:
                call = f"{block.kind}({vectors[0]}, {block.size})"
            else:
                self.bodies.append(_emit_body(f"body{number}", block))
                call = f"{block.kind}(body{number}, {', '.join(vectors)})"
            self.lines.append(f"b{number} = {call}")
        return _Term(f"b{number}[{output}]", 0)

    def value(self, x: Symbol | float) -> str:
        """Source of an output."""
        return self.terms[x.index].text if isinstance(x, Symbol) else repr(float(x))


def _emit_body(name: str, block: Block) -> str:
    """`def name(a0, a1)`: unknowns and parameters in, flat residuals and Jacobian out."""
    assert block.body is not None  # noqa: S101  only Newton has one
    function = block.body
    inner = trace(lambda x, p: Results({"values": function(x, p)}, []), [len(v) for v in block.arguments])
    body = _Body(inner)
    lines = [f"def {name}(a0, a1):"]
    lines += [f"    {names} = a{v}" for v, names in enumerate(_unpacking(inner, _used_inputs(inner))) if names]
    lines += [f"    {line}" for line in body.lines]
    lines.append(f"    return [{', '.join(body.value(o) for o in inner.outputs)}]")
    return "\n".join(lines) + "\n"


def emit_scalar(traced: Trace) -> str:
    """`def kernel(a0, a1, ...)`: sequences of floats in; (status, list of floats) out. Status 0 is good."""
    body = _Body(traced)
    lines = [f"def kernel({', '.join(f'a{v}' for v in range(len(traced.inputs)))}):"]
    used = _used_inputs(traced)
    lines += [f"    {names} = a{v}" for v, names in enumerate(_unpacking(traced, used)) if names]
    lines += [f"    {line}" for line in body.lines]
    lines.append("    status = 0")
    for check in reversed(traced.checks):  # the first check that fails names the status
        lines.append(f"    if not {body.value(check.value)} > {check.threshold!r}: status = {check.code}")
    lines.append(f"    return status, [{', '.join(body.value(o) for o in traced.outputs)}]")
    return "".join(body.bodies) + "\n".join(lines) + "\n"


def emit_columns(traced: Trace) -> str:
    """`def kernel(a0, a1, ..., out, status)`: arrays (size, N) in, `out` (outputs, N) and `status` (N,) filled."""
    body = _Body(traced)
    lines = [f"def kernel({', '.join(f'a{v}' for v in range(len(traced.inputs)))}, out, status):"]
    lines += [f"    a{v}_{k} = a{v}[{k}]" for v, k in sorted(_used_inputs(traced))]
    lines += [f"    {line}" for line in body.lines]
    lines += [f"    out[{k}] = {body.value(o)}" for k, o in enumerate(traced.outputs)]
    lines.append("    status[:] = 0")
    for check in reversed(traced.checks):
        lines.append(f"    status[logical_not({body.value(check.value)} > {check.threshold!r})] = {check.code}")
    return "".join(body.bodies) + "\n".join(lines) + "\n"


def _used_inputs(trace: Trace) -> set[tuple[int, int]]:
    nodes = (trace.graph.nodes[i] for i in trace.live())
    return {(int(a), int(b)) for op, a, b in nodes if op == "input"}


def _unpacking(trace: Trace, used: set[tuple[int, int]]) -> list[str]:
    result = []
    for v, size in enumerate(trace.inputs):
        names = [f"a{v}_{k}" if (v, k) in used else "_" for k in range(size)]
        result.append(", ".join(names) + ("," if size == 1 else "") if any(n != "_" for n in names) else "")
    return result
