"""Blocks of a trace as functions with loops: the inverse of a matrix, and Newton's iteration.

They do what `algebra.numerics` does on floats. A block works on one state; on lanes it is called
state by state.
"""

from __future__ import annotations

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP
from ..graph import Block
from ..trace import Trace, body_name, trace_body
from .nodes import Fetch, Nodes
from .text import Function, Lanes, constant


def block_functions(trace: Trace) -> list[str]:
    """The functions that the live blocks of a trace call, inner ones first; equal ones once."""
    result: dict[str, None] = {}
    for number in trace.live_blocks():
        block = trace.graph.blocks[number]
        if block.body is None:
            result[_eliminate(block.size, block.size)] = None
            result[_invert(block.size)] = None
        else:
            inner = trace_body(trace, number)
            for text in block_functions(inner):
                result[text] = None
            result[_eliminate(block.size, 1)] = None
            result[_body(inner)] = None
            result[_newton(inner.name, block)] = None
    return list(result)


def call_block(nodes: Nodes, number: int) -> list[str]:
    """Call the function of a block from straight-line code; the names of its outputs."""
    block = nodes.trace.graph.blocks[number]
    f, lanes = nodes.function, nodes.lanes
    known = [nodes.value(x) for vector in block.arguments for x in vector]
    given, answer = f.slot(lanes.kind, len(known)), f.slot(lanes.kind, outputs(block))
    for k, name in enumerate(known):
        f.store(name, given, k, kind=lanes.kind)
    name = (
        f"@invert.{block.size}"
        if block.body is None
        else f"@newton.{body_name(nodes.trace, number)}"
    )
    if lanes.width == 1:
        f.do(f"call void {name}(ptr {given}, ptr {answer})")
    else:
        one, result = f.slot("double", len(known)), f.slot("double", outputs(block))
        with f.loop(0, lanes.width) as lane:
            for k in range(len(known)):
                f.store(f.load(given, k * lanes.width, lane), one, k)
            f.do(f"call void {name}(ptr {one}, ptr {result})")
            for k in range(outputs(block)):
                f.store(f.load(result, k), answer, k * lanes.width, lane)
    return [f.load(answer, k, kind=lanes.kind) for k in range(outputs(block))]


def outputs(block: Block) -> int:
    """Number of outputs: the inverse and the determinant, or the solution and the number of iterations."""
    return block.size + 1 if block.body is not None else block.size**2 + 1


def _body(inner: Trace) -> str:
    """`@body.N(x, p, values)`: flat residuals and Jacobian of what Newton iterates."""
    f = Function(f"define internal void @body.{inner.name}(ptr %a0, ptr %a1, ptr %out)")
    nodes = Nodes(inner, Lanes(f, 1), inner.live, fetch_input(inner), call_block)
    for k, value in enumerate(inner.outputs):
        f.store(nodes.value(value), "%out", k)
    f.do("ret void")
    return f.text()


def fetch_input(trace: Trace) -> Fetch:
    """Inputs from the vectors %a0, %a1, ... of one state."""

    def fetch(lanes: Lanes, index: int) -> str:
        _, vector, component = trace.graph.nodes[index]
        return lanes.function.load(f"%a{int(vector)}", int(component))

    return fetch


def _eliminate(n: int, m: int) -> str:
    """`@eliminate.N.M(a)`: Gauss and Jordan with pivoting on the rows [A | B] (n, n + m); A^-1 B in B, det A returned.

    A singular matrix leaves values that are not finite, and a determinant of 0 or none.
    """
    width = n + m
    f = Function(f"define internal double @eliminate.{n}.{m}(ptr %a) noinline")
    lanes = Lanes(f, 1)
    determinant, largest, row = f.slot("double"), f.slot("double"), f.slot("i64")
    f.store(constant(1.0), determinant)
    with f.loop(0, n) as c:
        own = f.at("%a", f.let(f"mul i64 {c}, {width}"))
        f.store(constant(-1.0), largest)
        f.store(c, row, kind="i64")
        with f.loop(c, n) as r:
            size = f.let(
                "call double @llvm.fabs.f64(double"
                f" {f.load('%a', f.let(f'mul i64 {r}, {width}'), c)})"
            )
            with f.when(f.let(f"fcmp ogt double {size}, {f.load(largest)}")):
                f.store(size, largest)
                f.store(r, row, kind="i64")
        best = f.load(row, kind="i64")
        other = f.at("%a", f.let(f"mul i64 {best}, {width}"))
        pivot = f.load(other, c)
        moved = f.let(f"icmp ne i64 {best}, {c}")
        signed = f.let(f"select i1 {moved}, double {f.let(f'fneg double {pivot}')}, double {pivot}")
        f.store(f.let(f"fmul double {f.load(determinant)}, {signed}"), determinant)
        inverse = f.let(f"fdiv double {constant(1.0)}, {pivot}")
        with f.loop(0, width) as k:
            x, y = f.load(own, k), f.load(other, k)
            f.store(x, other, k)
            f.store(f.let(f"fmul double {y}, {inverse}"), own, k)
        with f.loop(0, n) as r, f.when(f.let(f"icmp ne i64 {r}, {c}")):
            line = f.at("%a", f.let(f"mul i64 {r}, {width}"))
            factor = f.load(line, c)
            with f.loop(c, width) as k:
                part = lanes.arithmetic("fmul", factor, f.load(own, k))
                f.store(lanes.arithmetic("fsub", f.load(line, k), part), line, k)
    f.do(f"ret double {f.load(determinant)}")
    return f.text()


def _invert(n: int) -> str:
    """`@invert.N(a, out)`: the inverse row by row, then the determinant; NaN and 0 for a singular matrix."""
    f = Function(f"define internal void @invert.{n}(ptr %a, ptr %out)")
    work = f.slot("double", 2 * n * n)
    with f.loop(0, n) as r, f.loop(0, n) as c:
        line, diagonal = f.let(f"mul i64 {r}, {2 * n}"), f.let(f"icmp eq i64 {r}, {c}")
        f.store(f.load("%a", f.let(f"mul i64 {r}, {n}"), c), work, line, c)
        one = f.let(f"select i1 {diagonal}, double {constant(1.0)}, double {constant(0.0)}")
        f.store(one, work, line, c, n)
    determinant = f.let(f"call double @eliminate.{n}.{n}(ptr {work})")
    good = f.let(f"fcmp one double {determinant}, {constant(0.0)}")
    with f.loop(0, n) as r, f.loop(0, n) as c:
        value = f.load(work, f.let(f"mul i64 {r}, {2 * n}"), c, n)
        value = f.let(f"select i1 {good}, double {value}, double {constant(float('nan'))}")
        f.store(value, "%out", f.let(f"mul i64 {r}, {n}"), c)
    f.store(f.let(f"select i1 {good}, double {determinant}, double {constant(0.0)}"), "%out", n * n)
    f.do("ret void")
    return f.text()


def _newton(name: str, block: Block) -> str:
    """`@newton.N(given, out)`: from guess and parameters to the solution and the iterations, negative if it failed."""
    n = block.size
    f = Function(f"define internal void @newton.{name}(ptr %given, ptr %out) noinline")
    lanes = Lanes(f, 1)
    values, work = f.slot("double", n + n * n), f.slot("double", n * (n + 1))
    working, largest = f.slot("i1"), f.slot("double")
    with f.loop(0, n) as k:
        f.store(f.load("%given", k), "%out", k)
    f.store("true", working, kind="i1", align=1)
    with f.loop(1, MAX_ITERATIONS + 1, while_=working) as iteration:
        count = f.let(f"sitofp i64 {iteration} to double")
        f.store(f.let(f"fneg double {count}"), "%out", n)
        f.do(f"call void @body.{name}(ptr %out, ptr {f.at('%given', n)}, ptr {values})")
        with f.loop(0, n) as r:
            line = f.let(f"mul i64 {r}, {n + 1}")
            with f.loop(0, n) as c:
                f.store(f.load(values, f.let(f"mul i64 {r}, {n}"), n, c), work, line, c)
            f.store(f.load(values, r), work, line, n)
        f.let(f"call double @eliminate.{n}.1(ptr {work})")
        _largest_step(f, work, n, largest)
        most = f.load(largest)
        finite = f.let(f"fcmp olt double {most}, {constant(float('inf'))}")
        f.store(finite, working, kind="i1", align=1)
        with f.when(finite):
            least = f.let(f"call double @llvm.maxnum.f64(double {most}, double {constant(1e-300)})")
            share = f.let(f"fdiv double {constant(LARGEST_STEP)}, {least}")
            share = f.let(f"call double @llvm.minnum.f64(double {share}, double {constant(1.0)})")
            with f.loop(0, n) as k:
                step = lanes.arithmetic(
                    "fmul", share, f.load(work, f.let(f"mul i64 {k}, {n + 1}"), n)
                )
                f.store(lanes.arithmetic("fsub", f.load("%out", k), step), "%out", k)
            with f.when(f.let(f"fcmp olt double {most}, {constant(SMALL_STEP)}")):
                f.store(count, "%out", n)
                f.store("false", working, kind="i1", align=1)
    f.do("ret void")
    return f.text()


def _largest_step(f: Function, work: str, n: int, largest: str) -> None:
    """The largest size of a step in the slot; infinite where one is not a number."""
    f.store(constant(0.0), largest)
    with f.loop(0, n) as k:
        size = f.let(
            f"call double @llvm.fabs.f64(double {f.load(work, f.let(f'mul i64 {k}, {n + 1}'), n)})"
        )
        with f.when(f.let(f"fcmp uno double {size}, {size}")):
            f.store(constant(float("inf")), largest)
        with f.when(f.let(f"fcmp ogt double {size}, {f.load(largest)}")):
            f.store(size, largest)
