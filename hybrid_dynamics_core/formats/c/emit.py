"""C99 source from a trace: a function of arrays for one state, without allocation.

It has numbered variables and numbers only, and no names of a file. Its loops are bounded. They
equal `algebra.numerics` on floats. The same text is C++17.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...algebra.numerics import MAX_ITERATIONS
from ...kernels.emit_python import count_uses
from ...kernels.graph import Operand, Symbol
from ...kernels.trace import Trace, body_name, trace_body
from .parts import Text, in_parts, indented
from .solvers import ELIMINATE, INVERT, NEWTON, SMALL

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_CALLS = {
    "sin": "sin",
    "cos": "cos",
    "sqrt": "sqrt",
    "abs": "fabs",
    "rint": "nearest",
    "atan2": "angle",
}
_LONGEST = 160  # characters of an expression that is used once and stays inside another


@dataclass(frozen=True)
class Split:
    """The outputs of a trace that alone read one of its inputs, which may be NULL.

    Attributes:
        vector: the input.
        first: the first of these outputs; they are the last ones.
        always: nodes of all other outputs and of the checks, in order.
        sometimes: the other live nodes, in order.
    """

    vector: int
    first: int
    always: Sequence[int]
    sometimes: Sequence[int]


def split_at(trace: Trace, vector: int, first: int) -> Split | None:
    """The split of the outputs from `first` on; None if others read the input too."""
    values = [*trace.outputs[:first], *(check.value for check in trace.checks)]
    always = trace.graph.live(values)
    sometimes = [index for index in trace.live if index not in set(always)]
    nodes = trace.graph.nodes
    reads = any(nodes[index][:2] == ("input", vector) for index in always)
    if reads or any(nodes[index][0] == "block" for index in sometimes):
        return None
    return Split(vector, first, always, sometimes)


class Body:
    """Statements for nodes of a trace; a node that is used once is inlined.

    Attributes:
        trace: the trace.
        lines: the statements.
    """

    def __init__(
        self,
        trace: Trace,
        nodes: Sequence[int] | None = None,
        given: Mapping[int, str] | None = None,
    ) -> None:
        """Write the statements.

        Args:
            trace: the trace.
            nodes: what they compute, in order; all live nodes if None.
            given: sources of other nodes.
        """
        self.trace = trace
        self.lines: list[str] = []
        self._terms: dict[int, str] = dict(given or {})
        self._called: set[int] = set()
        uses = count_uses(trace)
        for index in trace.live if nodes is None else nodes:
            text = self._term(index)
            is_short = trace.graph.nodes[index][0] in ("input", "block")
            if not is_short and (uses[index] > 1 or len(text) > _LONGEST):
                self.lines.append(f"const double v{index} = {text};")
                text = f"v{index}"
            self._terms[index] = text

    def term(self, index: int) -> str:
        """Source of a node."""
        return self._terms[index]

    def value(self, x: Operand) -> str:
        """Source of an output."""
        return self._operand(x.index if isinstance(x, Symbol) else float(x))

    def _operand(self, x: int | float) -> str:
        if isinstance(x, int):
            return self._terms[x]
        return constant(x)

    def _term(self, index: int) -> str:
        op, a, b = self.trace.graph.nodes[index]
        if op == "input":
            return f"a{a}[{b}]"
        if op == "block":
            return self._block(int(a), int(b))
        first = self._operand(a)
        if op == "neg":
            return f"(-{first})"
        if op in _INFIX:
            return f"({first} {_INFIX[op]} {self._operand(b)})"
        if op == "atan2":
            return f"angle({first}, {self._operand(b)})"
        return f"{_CALLS[op]}({first})"

    def _block(self, number: int, output: int) -> str:
        if number not in self._called:
            self._called.add(number)
            self._call(number)
        return f"b{number}[{output}]"

    def _call(self, number: int) -> None:
        """Write the call of a block."""
        block = self.trace.graph.blocks[number]
        n = block.size
        vectors = [[self.value(x) for x in vector] for vector in block.arguments]
        if block.body is None:
            entries = ", ".join(vectors[0])
            self._add_call(
                f"const double m{number}[] = {{{entries}}};",
                f"double w{number}[{2 * n * n}];",
                f"double b{number}[{block.outputs}];",
                f"invert({n}, m{number}, w{number}, b{number});",
            )
            return
        guess, parameters = vectors
        body = function_name(body_name(self.trace, number))
        self._add_call(
            f"const double p{number}[] = {{{', '.join(parameters or ['0.0'])}}};",
            f"double b{number}[{block.outputs}] = {{{', '.join(guess)}}};",
            f"double e{number}[{n + n * n}];",
            f"double w{number}[{n * (n + 1)}];",
            f"newton({body}, {n}, p{number}, e{number}, w{number}, b{number});",
        )

    def _add_call(self, *lines: str) -> None:
        """Add the lines of a call as one statement."""
        self.lines.append("\n".join(lines))


def constant(x: float) -> str:
    """Source of a number, to the last bit."""
    if math.isnan(x):
        return "(double)NAN"
    if math.isinf(x):
        return "(double)INFINITY" if x > 0.0 else "(-(double)INFINITY)"
    return f"({x!r})" if x < 0.0 else repr(x)


def function_name(name: str) -> str:
    """Name of the C function of a trace."""
    return f"f_{name.replace('.', '_')}"


def emit_functions(trace: Trace, split: Split | None = None) -> list[str]:
    """The C functions of a trace, without duplicates; those that others call come first.

    The last one is `static int f_NAME(const double *a0, ..., double *out)`. It returns 0, or the
    code of the first check that fails: then `out` is not written.

    Args:
        trace: the trace.
        split: outputs that are left out where one of the inputs is NULL.
    """
    if split is None:
        body = Body(trace)
        outputs = outputs_of(trace, body)
    else:
        body = Body(trace, split.always)
        given = {index: body.term(index) for index in split.always}
        after = Body(trace, split.sometimes, given)
        outputs = outputs_of(trace, after)
        lines = "\n".join([*after.lines, *outputs[split.first :]])
        optional = indented(lines)
        outputs[split.first :] = [f"if (a{split.vector}) {{\n{optional}\n}}"]
    last = [*checks_of(trace, body), *outputs, "return 0;"]
    text = Text("int", function_name(trace.name), len(trace.inputs), body.lines, last)
    return with_helpers([*block_functions(trace), *in_parts(text)])


def with_helpers(functions: Sequence[str]) -> list[str]:
    """The functions, after the small ones that they call."""
    joined = "".join(functions)
    return [*(helper for call, helper in SMALL.items() if call in joined), *functions]


def checks_of(trace: Trace, body: Body) -> list[str]:
    """Statements that return the code of the first check that fails."""
    lines = []
    for check in trace.checks:
        test = f"!({body.value(check.value)} > {constant(check.threshold)})"
        lines.append(f"if ({test}) {{\n    return {check.code};\n}}")
    return lines


def block_functions(trace: Trace) -> list[str]:
    """The functions that the live blocks of a trace call."""
    texts: list[str] = []
    for number in trace.live_blocks():
        texts.append(ELIMINATE)
        if trace.graph.blocks[number].body is None:
            texts.append(INVERT)
            continue
        inner = trace_body(trace, number)
        body = Body(inner)
        text = Text("void", function_name(inner.name), 2, body.lines, outputs_of(inner, body))
        texts += [NEWTON, *block_functions(inner), *in_parts(text)]
    return list(dict.fromkeys(texts))


def outputs_of(trace: Trace, body: Body) -> list[str]:
    """Statements that hand out the outputs."""
    return [f"out[{k}] = {body.value(x)};" for k, x in enumerate(trace.outputs)]


def count_operations(trace: Trace) -> int:
    """Number of floating-point operations of a call at most, all iterations included."""
    nodes = trace.graph.nodes
    count = sum(nodes[index][0] not in ("input", "block") for index in trace.live)
    for number in trace.live_blocks():
        block = trace.graph.blocks[number]
        n = block.size
        if block.body is None:
            count += _eliminations(n, 2 * n)
            continue
        inner = count_operations(trace_body(trace, number))
        count += MAX_ITERATIONS * (inner + _eliminations(n, n + 1) + 4 * n)
    return count


def _eliminations(n: int, width: int) -> int:
    """Operations of `eliminate` at most."""
    return n * (n + 2 + width + 2 * (n - 1) * width)
