"""Functions of blocks, with loops in their code: inverse of a matrix, and Newton's iteration.

They equal `algebra.numerics` on floats. A block computes one state; on lanes it is called for each
state.
"""

from __future__ import annotations

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP
from ..trace import Trace, body_name, trace_body
from .nodes import Fetch, Nodes
from .text import Function, Lanes, constant

_ONE, _ZERO = constant(1.0), constant(0.0)
_INFINITY, _NAN = constant(float("inf")), constant(float("nan"))
_SMALLEST = constant(1e-300)  # keeps divisors above zero


def block_functions(trace: Trace) -> list[str]:
    """The functions of the live blocks of a trace, without duplicates; inner ones come first."""
    texts: list[str] = []
    for number in trace.live_blocks():
        block = trace.graph.blocks[number]
        size = block.size
        if block.body is None:
            texts.append(_eliminate(size, size))
            texts.append(_invert(size))
        else:
            inner = trace_body(trace, number)
            texts += block_functions(inner)
            texts.append(_eliminate(size, 1))
            texts.append(_body(inner))
            texts.append(_newton(inner.name, size))
    return list(dict.fromkeys(texts))


def call_block(nodes: Nodes, number: int) -> list[str]:
    """Write a call of a block's function; returns the names of its outputs."""
    block = nodes.trace.graph.blocks[number]
    f = nodes.function
    kind = nodes.lanes.kind
    arguments: list[str] = []
    for vector in block.arguments:
        arguments += map(nodes.value, vector)
    given = f.slot(kind, len(arguments))
    answer = f.slot(kind, block.outputs)
    for k, argument in enumerate(arguments):
        f.store(argument, given, k, kind=kind)
    name = f"@newton.{body_name(nodes.trace, number)}"
    if block.body is None:
        name = f"@invert.{block.size}"
    if nodes.lanes.width == 1:
        f.do(f"call void {name}(ptr {given}, ptr {answer})")
    else:
        counts = len(arguments), block.outputs
        _call_by_lane(nodes.lanes, name, given, answer, counts)
    return [f.load(answer, k, kind=kind) for k in range(block.outputs)]


def _call_by_lane(
    lanes: Lanes, name: str, given: str, answer: str, counts: tuple[int, int]
) -> None:
    """Write a call for each lane; `counts` are the numbers of inputs and outputs."""
    f, width = lanes.function, lanes.width
    inputs, outputs = counts
    one = f.slot("double", inputs)
    result = f.slot("double", outputs)
    with f.loop(0, width) as lane:
        for k in range(inputs):
            value = f.load(given, k * width, lane)
            f.store(value, one, k)
        f.do(f"call void {name}(ptr {one}, ptr {result})")
        for k in range(outputs):
            value = f.load(result, k)
            f.store(value, answer, k * width, lane)


def _body(inner: Trace) -> str:
    """`@body.N(x, p, values)`: flat residuals and Jacobian of a Newton block."""
    f = Function(f"define internal void @body.{inner.name}(ptr %a0, ptr %a1, ptr %out)")
    fetch = fetch_input(inner)
    nodes = Nodes(inner, Lanes(f, 1), inner.live, fetch, call_block)
    for k, output in enumerate(inner.outputs):
        value = nodes.value(output)
        f.store(value, "%out", k)
    f.do("ret void")
    return f.text()


def fetch_input(trace: Trace) -> Fetch:
    """Access to the input vectors %a0, %a1, ... of one state."""

    def fetch(lanes: Lanes, index: int) -> str:
        _, vector, component = trace.graph.nodes[index]
        return lanes.function.load(f"%a{int(vector)}", int(component))

    return fetch


def _eliminate(n: int, m: int) -> str:
    """`@eliminate.N.M(a)`: Gauss and Jordan with pivoting on the rows [A | B] (n, n + m).

    It replaces B by A^-1 B and returns det A. For a singular matrix the values are not finite, and
    the determinant is 0 or NaN.
    """
    width = n + m
    f = Function(f"define internal double @eliminate.{n}.{m}(ptr %a) noinline")
    determinant = f.slot("double")
    largest = f.slot("double")
    row = f.slot("i64")
    f.store(_ONE, determinant)
    with f.loop(0, n) as c:
        line = f.row("%a", c, width)
        _find_pivot(f, n, width, c, largest, row)
        _normalise_pivot(f, width, c, line, row, determinant)
        with f.loop(0, n) as r, f.when(f.let(f"icmp ne i64 {r}, {c}")):
            target = f.row("%a", r, width)
            _subtract_line(f, width, c, line, target)
    value = f.load(determinant)
    f.do(f"ret double {value}")
    return f.text()


def _find_pivot(f: Function, n: int, width: int, c: str, largest: str, row: str) -> None:
    """Store the row of the largest entry in column c, at or below row c, in the slot `row`."""
    f.store(constant(-1.0), largest)
    f.store(c, row, kind="i64")
    with f.loop(c, n) as r:
        line = f.product(r, width)
        size = f.absolute(f.load("%a", line, c))
        is_larger = f.let(f"fcmp ogt double {size}, {f.load(largest)}")
        with f.when(is_larger):
            f.store(size, largest)
            f.store(r, row, kind="i64")


def _normalise_pivot(
    f: Function, width: int, c: str, line: str, row: str, determinant: str
) -> None:
    """Swap the pivot row with row c, divide row c by the pivot, update the determinant."""
    best = f.load(row, kind="i64")
    other = f.row("%a", best, width)
    pivot = f.load(other, c)
    is_swapped = f.let(f"icmp ne i64 {best}, {c}")
    negative = f.let(f"fneg double {pivot}")
    signed = f.let(f"select i1 {is_swapped}, double {negative}, double {pivot}")
    product = f.let(f"fmul double {f.load(determinant)}, {signed}")
    f.store(product, determinant)
    inverse = f.let(f"fdiv double {_ONE}, {pivot}")
    with f.loop(0, width) as k:
        x = f.load(line, k)
        y = f.load(other, k)
        f.store(x, other, k)
        normalised = f.let(f"fmul double {y}, {inverse}")
        f.store(normalised, line, k)


def _subtract_line(f: Function, width: int, c: str, line: str, target: str) -> None:
    """Subtract a multiple of row c from another row so that its entry in column c becomes 0."""
    lanes = Lanes(f, 1)
    factor = f.load(target, c)
    with f.loop(c, width) as k:
        part = lanes.arithmetic("fmul", factor, f.load(line, k))
        difference = lanes.arithmetic("fsub", f.load(target, k), part)
        f.store(difference, target, k)


def _invert(n: int) -> str:
    """`@invert.N(a, out)`: the inverse row by row, then the determinant.

    For a singular matrix these are NaN and 0.
    """
    f = Function(f"define internal void @invert.{n}(ptr %a, ptr %out)")
    work = f.slot("double", 2 * n * n)
    with f.loop(0, n) as r, f.loop(0, n) as c:
        line = f.product(r, 2 * n)
        is_diagonal = f.let(f"icmp eq i64 {r}, {c}")
        entry = f.load("%a", f.product(r, n), c)
        f.store(entry, work, line, c)
        entry = f.let(f"select i1 {is_diagonal}, double {_ONE}, double {_ZERO}")
        f.store(entry, work, line, c, n)
    determinant = f.let(f"call double @eliminate.{n}.{n}(ptr {work})")
    is_regular = f.let(f"fcmp one double {determinant}, {_ZERO}")
    with f.loop(0, n) as r, f.loop(0, n) as c:
        line = f.product(r, 2 * n)
        value = f.load(work, line, c, n)
        value = f.let(f"select i1 {is_regular}, double {value}, double {_NAN}")
        f.store(value, "%out", f.product(r, n), c)
    determinant = f.let(f"select i1 {is_regular}, double {determinant}, double {_ZERO}")
    f.store(determinant, "%out", n * n)
    f.do("ret void")
    return f.text()


def _newton(name: str, n: int) -> str:
    """`@newton.N(given, out)`: from guess and parameters to the solution and the iterations.

    The number of iterations is negative if they failed.
    """
    f = Function(f"define internal void @newton.{name}(ptr %given, ptr %out) noinline")
    values = f.slot("double", n + n * n)
    work = f.slot("double", n * (n + 1))
    working = f.slot("i1")
    largest = f.slot("double")
    with f.loop(0, n) as k:
        guess = f.load("%given", k)
        f.store(guess, "%out", k)
    f.store("true", working, kind="i1", align=1)
    with f.loop(1, MAX_ITERATIONS + 1, while_=working) as iteration:
        count = f.let(f"sitofp i64 {iteration} to double")
        failed = f.let(f"fneg double {count}")
        f.store(failed, "%out", n)
        parameters = f.at("%given", n)
        f.do(f"call void @body.{name}(ptr %out, ptr {parameters}, ptr {values})")
        _fill_system(f, values, work, n)
        f.let(f"call double @eliminate.{n}.1(ptr {work})")
        _largest_step(f, work, n, largest)
        longest = f.load(largest)
        is_finite = f.let(f"fcmp olt double {longest}, {_INFINITY}")
        f.store(is_finite, working, kind="i1", align=1)
        with f.when(is_finite):
            _step(f, work, n, longest)
            is_small = f.let(f"fcmp olt double {longest}, {constant(SMALL_STEP)}")
            with f.when(is_small):
                f.store(count, "%out", n)
                f.store("false", working, kind="i1", align=1)
    f.do("ret void")
    return f.text()


def _fill_system(f: Function, values: str, work: str, n: int) -> None:
    """Store residuals and Jacobian as rows [Jacobian | residual]."""
    with f.loop(0, n) as r:
        line = f.product(r, n + 1)
        with f.loop(0, n) as c:
            slope = f.load(values, f.product(r, n), n, c)
            f.store(slope, work, line, c)
        residual = f.load(values, r)
        f.store(residual, work, line, n)


def _largest_step(f: Function, work: str, n: int, largest: str) -> None:
    """Store the largest step size in a slot; infinite if one is NaN."""
    f.store(_ZERO, largest)
    with f.loop(0, n) as k:
        line = f.product(k, n + 1)
        size = f.absolute(f.load(work, line, n))
        is_no_number = f.let(f"fcmp uno double {size}, {size}")
        with f.when(is_no_number):
            f.store(_INFINITY, largest)
        is_larger = f.let(f"fcmp ogt double {size}, {f.load(largest)}")
        with f.when(is_larger):
            f.store(size, largest)


def _step(f: Function, work: str, n: int, longest: str) -> None:
    """Subtract the step from the solution, scaled so that no entry exceeds LARGEST_STEP."""
    lanes = Lanes(f, 1)
    divisor = f.let(f"call double @llvm.maxnum.f64(double {longest}, double {_SMALLEST})")
    share = f.let(f"fdiv double {constant(LARGEST_STEP)}, {divisor}")
    share = f.let(f"call double @llvm.minnum.f64(double {share}, double {_ONE})")
    with f.loop(0, n) as k:
        line = f.product(k, n + 1)
        entry = f.load(work, line, n)
        step = lanes.arithmetic("fmul", share, entry)
        moved = lanes.arithmetic("fsub", f.load("%out", k), step)
        f.store(moved, "%out", k)
