"""Newton's iteration on lanes: each lane iterates until it has converged or failed."""

from __future__ import annotations

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP
from ..trace import Trace
from .elimination import LARGEST_WRITTEN, Elimination, Entry
from .nodes import CallBlock, Nodes
from .text import Function, Lanes

_INFINITY = float("inf")
_SMALLEST = 1e-300  # keeps divisors above zero


def newton_name(body: str, width: int) -> str:
    """Name of the function of a Newton block, from that of its body."""
    return f"newton.{body}.{width}"


class NewtonFunction:
    """Writer of `@newton.N.W(given, out)`.

    From guess and parameters to the solution and the number of iterations. The number is negative
    where the iteration failed.

    Args:
        inner: trace of residuals and Jacobian.
        size: number of unknowns.
        width: number of lanes.
        call: writes calls of the blocks in the trace.
    """

    def __init__(self, inner: Trace, size: int, width: int, call: CallBlock) -> None:
        name = newton_name(inner.name, width)
        self.f = Function(f"define internal void @{name}(ptr %given, ptr %out) noinline")
        self.lanes = Lanes(self.f, width)
        self._inner = inner
        self._size = size
        self._call = call
        self._working = self.f.slot(self.lanes.mask)
        self._any = self.f.slot("i1")
        self._steps = self.f.slot(self.lanes.kind, size)

    def text(self) -> str:
        """The text of the function."""
        f = self.f
        lanes = self.lanes
        for k in range(self._size):
            self._store(self._load("%given", k), "%out", k)
        every = lanes.splat("i1", "true")
        f.do(f"store {lanes.mask} {every}, ptr {self._working}")
        f.store("true", self._any, kind="i1", align=1)
        with f.loop(1, MAX_ITERATIONS + 1, while_=self._any) as iteration:
            self._iterate(iteration)
        f.do("ret void")
        return f.text()

    def _iterate(self, iteration: str) -> None:
        f = self.f
        lanes = self.lanes
        n = self._size
        unknowns = [self._load("%out", k) for k in range(n)]
        working = f.let(f"load {lanes.mask}, ptr {self._working}")
        self._solve(unknowns, working)
        steps = [self._load(self._steps, k) for k in range(n)]
        longest = self._longest(steps)
        is_finite = lanes.compare("olt", longest, lanes.constant(_INFINITY))
        moves = f.let(f"and {lanes.mask} {working}, {is_finite}")
        divisor = lanes.larger(longest, lanes.constant(_SMALLEST))
        share = lanes.arithmetic("fdiv", lanes.constant(LARGEST_STEP), divisor)
        one = lanes.constant(1.0)
        is_short = lanes.compare("ogt", share, one)
        share = lanes.choose(is_short, lanes.kind, one, share)
        for k, (value, step) in enumerate(zip(unknowns, steps, strict=True)):
            part = lanes.arithmetic("fmul", share, step)
            moved = lanes.arithmetic("fsub", value, part)
            chosen = lanes.choose(moves, lanes.kind, moved, value)
            self._store(chosen, "%out", k)
        is_small = lanes.compare("olt", longest, lanes.constant(SMALL_STEP))
        converged = f.let(f"and {lanes.mask} {moves}, {is_small}")
        self._count(iteration, working, converged)
        remaining = f.let(f"and {lanes.mask} {moves}, {lanes.inverted(is_small)}")
        f.do(f"store {lanes.mask} {remaining}, ptr {self._working}")
        f.store(lanes.any(remaining), self._any, kind="i1", align=1)

    def _count(self, iteration: str, working: str, converged: str) -> None:
        """Store the number of iterations of the lanes that work: negative until converged."""
        lanes = self.lanes
        count = self.f.let(f"sitofp i64 {iteration} to double")
        count = lanes.broadcast(count)
        signed = lanes.choose(converged, lanes.kind, count, lanes.negative(count))
        before = self._load("%out", self._size)
        count = lanes.choose(working, lanes.kind, signed, before)
        self._store(count, "%out", self._size)

    def _solve(self, unknowns: list[str], working: str) -> None:
        """Store the steps that the linearised equations ask for."""
        lanes = self.lanes
        n = self._size
        values = self._body(unknowns)
        residuals = values[:n]
        entries = values[n:]
        rows = [entries[r * n : r * n + n] for r in range(n)]
        safe = lanes.inverted(working)
        if n <= LARGEST_WRITTEN:
            factors = Elimination(lanes, rows)
            safe = self.f.let(f"or {lanes.mask} {safe}, {factors.safe}")
            for k, step in enumerate(factors.solve(residuals)):
                self._store(step or lanes.constant(0.0), self._steps, k)
        system: list[Entry] = []
        for row, residual in zip(rows, residuals, strict=True):
            system += [*row, residual]
        self._solve_with_pivots(system, safe)

    def _solve_with_pivots(self, system: list[Entry], safe: str) -> None:
        """Store the steps of the lanes that are not safe.

        Args:
            system: rows [Jacobian | residual].
            safe: mask of the other lanes.
        """
        f = self.f
        lanes = self.lanes
        n = self._size
        matrix = f.slot("double", len(system))
        memory = f.slot(lanes.kind, len(system))
        with f.when(lanes.any(lanes.inverted(safe))):
            for k, value in enumerate(system):
                self._store(value or lanes.constant(0.0), memory, k)
            with lanes.each_without(safe) as lane:
                for k in range(len(system)):
                    entry = f.load(memory, k * lanes.width, lane)
                    f.store(entry, matrix, k)
                f.let(f"call double @eliminate.{n}.1(ptr {matrix})")
                for k in range(n):
                    step = f.load(matrix, k * (n + 1) + n)
                    f.store(step, self._steps, k * lanes.width, lane)

    def _body(self, unknowns: list[str]) -> list[Entry]:
        """Residuals, then the Jacobian row by row."""
        inner = self._inner

        def fetch(_lanes: Lanes, index: int) -> str:
            _, vector, component = inner.graph.nodes[index]
            if vector == 0:
                return unknowns[int(component)]
            return self._load("%given", self._size + int(component))

        nodes = Nodes(inner, self.lanes, inner.live, fetch, self._call)
        values: list[Entry] = []
        for output in inner.outputs:
            is_zero = isinstance(output, float) and output == 0.0
            values.append(None if is_zero else nodes.value(output))
        return values

    def _longest(self, steps: list[str]) -> str:
        """The largest step size; infinite if one is NaN."""
        lanes = self.lanes
        longest = lanes.constant(0.0)
        for step in steps:
            size = lanes.intrinsic("fabs", step)
            longest = lanes.larger(size, longest)
            is_no_number = lanes.compare("uno", size, size)
            infinite = lanes.constant(_INFINITY)
            longest = lanes.choose(is_no_number, lanes.kind, infinite, longest)
        return longest

    def _load(self, pointer: str, k: int) -> str:
        return self.f.load(pointer, k, kind=self.lanes.kind)

    def _store(self, value: str, pointer: str, k: int) -> None:
        self.f.store(value, pointer, k, kind=self.lanes.kind)
