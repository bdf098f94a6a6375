"""C99 source from a trace: a function of arrays for one state, without allocation.

It has numbered variables and numbers only, and no names of a file. Its loops are bounded. They
equal `algebra.numerics` on floats. The same text is C++17.
"""

from __future__ import annotations

import math

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP, TINY
from ...kernels.emit_python import count_uses
from ...kernels.graph import Operand, Symbol
from ...kernels.trace import Trace, body_name, trace_body

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_CALLS = {
    "sin": "sin",
    "cos": "cos",
    "sqrt": "sqrt",
    "abs": "fabs",
    "rint": "rint",
    "atan2": "atan2",
}
_LONGEST = 160  # characters of an expression that is used once and stays inside another

_ELIMINATE = """\
/* Gauss and Jordan with pivoting on the rows [A | B] (n, width): B becomes A^-1 B. Returns det A.
   The values of a singular matrix are not finite. */
static double eliminate(double *a, int n, int width)
{
    double determinant = 1.0;
    for (int c = 0; c < n; ++c) {
        double *line = a + c * width;
        double *other = line;
        double largest = -1.0;
        for (int r = c; r < n; ++r) {
            const double size = fabs(a[r * width + c]);
            if (size > largest) {
                largest = size;
                other = a + r * width;
            }
        }
        const double pivot = other[c];
        const double inverse = 1.0 / pivot;
        determinant *= (other == line) ? pivot : -pivot;
        for (int k = 0; k < width; ++k) {
            const double x = line[k];
            const double y = other[k];
            other[k] = x;
            line[k] = y * inverse;
        }
        for (int r = 0; r < n; ++r) {
            double *target = a + r * width;
            if (r != c) {
                const double factor = target[c];
                for (int k = c; k < width; ++k) {
                    target[k] -= factor * line[k];
                }
            }
        }
    }
    return determinant;
}
"""

_INVERT = """\
/* The inverse of a (n, n) row by row, then the determinant; NaN and 0 of a singular matrix. */
static void invert(int n, const double *a, double *work, double *out)
{
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) {
            work[2 * n * r + c] = a[n * r + c];
            work[2 * n * r + n + c] = (r == c) ? 1.0 : 0.0;
        }
    }
    const double determinant = eliminate(work, n, 2 * n);
    const int regular = determinant < 0.0 || determinant > 0.0;
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) {
            out[n * r + c] = regular ? work[2 * n * r + n + c] : (double)NAN;
        }
    }
    out[n * n] = regular ? determinant : 0.0;
}
"""

_NEWTON = f"""\
typedef void equations(const double *x, const double *p, double *values);

/* Newton's iteration from the guess x (n,) to the solution in its place. x[n] becomes the number
   of iterations, at most {MAX_ITERATIONS}; negative where they fail. */
static void newton(
    equations *body, int n, const double *p, double *values, double *work, double *x)
{{
    for (int count = 1; count <= {MAX_ITERATIONS}; ++count) {{
        double longest = 0.0;
        x[n] = -(double)count;
        body(x, p, values);
        for (int r = 0; r < n; ++r) {{
            for (int c = 0; c < n; ++c) {{
                work[(n + 1) * r + c] = values[n + n * r + c];
            }}
            work[(n + 1) * r + n] = values[r];
        }}
        (void)eliminate(work, n, n + 1);
        for (int r = 0; r < n; ++r) {{
            const double size = fabs(work[(n + 1) * r + n]);
            if (!(size < (double)INFINITY)) {{
                return;
            }}
            if (size > longest) {{
                longest = size;
            }}
        }}
        const double share = {LARGEST_STEP!r} / (longest > {TINY!r} ? longest : {TINY!r});
        for (int r = 0; r < n; ++r) {{
            x[r] -= (share < 1.0 ? share : 1.0) * work[(n + 1) * r + n];
        }}
        if (longest < {SMALL_STEP!r}) {{
            x[n] = (double)count;
            return;
        }}
    }}
}}
"""


class _Body:
    """Statements for the live nodes; a node that is used once is inlined."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.lines: list[str] = []
        self._terms: dict[int, str] = {}
        self._called: set[int] = set()
        uses = count_uses(trace)
        for index in trace.live:
            text = self._term(index)
            is_short = trace.graph.nodes[index][0] in ("input", "block")
            if not is_short and (uses[index] > 1 or len(text) > _LONGEST):
                self.lines.append(f"const double v{index} = {text};")
                text = f"v{index}"
            self._terms[index] = text

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
            return f"atan2({first}, {self._operand(b)})"
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
            self.lines += [
                f"const double m{number}[] = {{{entries}}};",
                f"double w{number}[{2 * n * n}];",
                f"double b{number}[{block.outputs}];",
                f"invert({n}, m{number}, w{number}, b{number});",
            ]
            return
        guess, parameters = vectors
        body = function_name(body_name(self.trace, number))
        self.lines += [
            f"const double p{number}[] = {{{', '.join(parameters or ['0.0'])}}};",
            f"double b{number}[{block.outputs}] = {{{', '.join(guess)}}};",
            f"double e{number}[{n + n * n}];",
            f"double w{number}[{n * (n + 1)}];",
            f"newton({body}, {n}, p{number}, e{number}, w{number}, b{number});",
        ]


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


def emit_functions(trace: Trace) -> list[str]:
    """The C functions of a trace, without duplicates; those that others call come first.

    The last one is `static int f_NAME(const double *a0, ..., double *out)`. It returns 0, or the
    code of the first check that fails: then `out` is not written.
    """
    body = _Body(trace)
    lines = list(body.lines)
    for check in trace.checks:
        test = f"!({body.value(check.value)} > {constant(check.threshold)})"
        lines += [f"if ({test}) {{", f"    return {check.code};", "}"]
    lines += _outputs(trace, body)
    lines.append("return 0;")
    vectors = range(len(trace.inputs))
    arguments = "".join(f"const double *a{v}, " for v in vectors)
    head = f"static int {function_name(trace.name)}({arguments}double *out)"
    return [*_block_functions(trace), _function(head, [*_unused(trace), *lines])]


def _block_functions(trace: Trace) -> list[str]:
    """The functions that the live blocks of a trace call."""
    texts: list[str] = []
    for number in trace.live_blocks():
        texts.append(_ELIMINATE)
        if trace.graph.blocks[number].body is None:
            texts.append(_INVERT)
            continue
        inner = trace_body(trace, number)
        body = _Body(inner)
        head = f"static void {function_name(inner.name)}(const double *a0, const double *a1, "
        lines = [*_unused(inner), *body.lines, *_outputs(inner, body)]
        texts += [_NEWTON, *_block_functions(inner), _function(f"{head}double *out)", lines)]
    return list(dict.fromkeys(texts))


def _outputs(trace: Trace, body: _Body) -> list[str]:
    return [f"out[{k}] = {body.value(x)};" for k, x in enumerate(trace.outputs)]


def _unused(trace: Trace) -> list[str]:
    """Statements that name the inputs that nothing depends on, so that compilers do not warn."""
    used = {vector for vector, _ in trace.used_inputs()}
    return [f"(void)a{v};" for v in range(len(trace.inputs)) if v not in used]


def _function(head: str, lines: list[str]) -> str:
    body = "\n".join(f"    {line}" for line in lines)
    return f"{head}\n{{\n{body}\n}}\n"


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
