"""Elimination: written out in a fixed order of the rows, or with pivoting where that is not safe.

A fixed order needs no search, no exchange of rows and no branch, so it runs on lanes. The caller
puts the rows in an order that suits most states. `safe` tells the lanes in which each pivot is
large enough beside its column. In others, `@eliminate` pivots.
"""

from __future__ import annotations

from collections.abc import Sequence

from .text import Function, Lanes, constant

# rows of the largest matrix that is written out
LARGEST_WRITTEN = 8
# factor by which an entry below may exceed its pivot
GROWTH = 8.0
_ONE, _ZERO = constant(1.0), constant(0.0)
_NAN = constant(float("nan"))
_INFINITE = constant(float("inf"))

# name of a value; None for an entry that is always zero
Entry = str | None


class Elimination:
    """Writer of the factors L U of a matrix, without exchange of rows.

    Attributes:
        safe: mask of the lanes in which the factors may be used.
    """

    def __init__(self, lanes: Lanes, matrix: Sequence[Sequence[Entry]]) -> None:
        self._lanes = lanes
        self._rows = [list(row) for row in matrix]
        self._inverses: list[str] = []
        self.safe = lanes.splat("i1", "true")
        for k in range(len(self._rows)):
            self._eliminate(k)

    def solve(self, rhs: Sequence[Entry]) -> list[Entry]:
        """x with matrix x = rhs."""
        x = list(rhs)
        size = len(x)
        for k in range(size):
            for i in range(k + 1, size):
                x[i] = self._minus_product(x[i], self._rows[i][k], x[k])
        for k in reversed(range(size)):
            for j in range(k + 1, size):
                x[k] = self._minus_product(x[k], self._rows[k][j], x[j])
            x[k] = self._product(x[k], self._inverses[k])
        return x

    def _eliminate(self, k: int) -> None:
        """Eliminate column k below row k; factors take the place of the entries."""
        lanes = self._lanes
        pivot = self._rows[k][k] or lanes.constant(0.0)
        below = range(k + 1, len(self._rows))
        self._watch(pivot, [self._rows[i][k] for i in below])
        inverse = lanes.arithmetic("fdiv", lanes.constant(1.0), pivot)
        self._inverses.append(inverse)
        for i in below:
            row = self._rows[i]
            row[k] = self._product(row[k], inverse)
            for j in range(k + 1, len(row)):
                row[j] = self._minus_product(row[j], row[k], self._rows[k][j])

    def _watch(self, pivot: str, entries: Sequence[Entry]) -> None:
        """A lane is safe if the pivot is not small beside the entries below."""
        lanes = self._lanes
        largest = lanes.constant(0.0)
        for entry in entries:
            if entry is not None:
                largest = lanes.larger(lanes.intrinsic("fabs", entry), largest)
        size = lanes.intrinsic("fabs", pivot)
        bound = lanes.arithmetic("fmul", size, lanes.constant(GROWTH))
        is_large = lanes.compare("ogt", bound, largest)
        self.safe = lanes.function.let(f"and {lanes.mask} {self.safe}, {is_large}")

    def _product(self, a: Entry, b: Entry) -> Entry:
        if a is None or b is None:
            return None
        return self._lanes.arithmetic("fmul", a, b)

    def _minus_product(self, total: Entry, a: Entry, b: Entry) -> Entry:
        product = self._product(a, b)
        if product is None:
            return total
        if total is None:
            return self._lanes.negative(product)
        return self._lanes.arithmetic("fsub", total, product)


def invert_function(n: int, zeros: int, width: int) -> str:
    """`@invert.N.Z.W(a, out)`: the inverse row by row, in each lane.

    Args:
        n: number of rows.
        zeros: bits of the entries that are always zero.
        width: number of lanes.
    """
    f = Function(f"define internal void @{invert_name(n, zeros, width)}(ptr %a, ptr %out) noinline")
    lanes = Lanes(f, width)
    values: list[Entry] = []
    for k in range(n * n):
        is_zero = zeros >> k & 1
        values.append(None if is_zero else f.load("%a", k, kind=lanes.kind))
    safe = lanes.splat("i1", "false")
    if n <= LARGEST_WRITTEN:
        factors = Elimination(lanes, [values[r * n : r * n + n] for r in range(n)])
        safe = factors.safe
        for c in range(n):
            unit: list[Entry] = [None] * n
            unit[c] = lanes.constant(1.0)
            for r, value in enumerate(factors.solve(unit)):
                entry = value or lanes.constant(0.0)
                f.store(entry, "%out", r * n + c, kind=lanes.kind)
    matrix, result = f.slot("double", n * n), f.slot("double", n * n)
    with lanes.each_without(safe) as lane:
        for k in range(n * n):
            f.store(f.load("%a", k * width, lane), matrix, k)
        f.do(f"call void @invert.{n}(ptr {matrix}, ptr {result})")
        for k in range(n * n):
            f.store(f.load(result, k), "%out", k * width, lane)
    f.do("ret void")
    return f.text()


def invert_name(n: int, zeros: int, width: int) -> str:
    """Name of the function of an inverse."""
    return f"invert.{n}.{zeros:x}.{width}"


def pivoting_function(n: int, m: int) -> str:
    """`@eliminate.N.M(a)`: Gauss and Jordan with pivoting on the rows [A | B] (n, n + m).

    It replaces B by A^-1 B and returns the size of the least pivot. For a singular matrix the
    values are not finite, and the least pivot is 0.
    """
    width = n + m
    f = Function(f"define internal double @eliminate.{n}.{m}(ptr %a) noinline")
    least = f.slot("double")
    largest = f.slot("double")
    row = f.slot("i64")
    f.store(_INFINITE, least)
    with f.loop(0, n) as c:
        line = f.row("%a", c, width)
        _find_pivot(f, n, width, c, largest, row)
        _normalise_pivot(f, width, c, line, row, least)
        with f.loop(0, n) as r, f.when(f.let(f"icmp ne i64 {r}, {c}")):
            target = f.row("%a", r, width)
            _subtract_line(f, width, c, line, target)
    value = f.load(least)
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


def _normalise_pivot(f: Function, width: int, c: str, line: str, row: str, least: str) -> None:
    """Swap the pivot row with row c, divide row c by the pivot, update the least pivot."""
    best = f.load(row, kind="i64")
    other = f.row("%a", best, width)
    pivot = f.load(other, c)
    size, before = f.absolute(pivot), f.load(least)
    is_less = f.let(f"fcmp olt double {size}, {before}")
    f.store(f.let(f"select i1 {is_less}, double {size}, double {before}"), least)
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


def pivoting_invert(n: int) -> str:
    """`@invert.N(a, out)`: the inverse row by row; NaN for a singular matrix."""
    f = Function(f"define internal void @invert.{n}(ptr %a, ptr %out)")
    work = f.slot("double", 2 * n * n)
    with f.loop(0, n) as r, f.loop(0, n) as c:
        line = f.product(r, 2 * n)
        is_diagonal = f.let(f"icmp eq i64 {r}, {c}")
        entry = f.load("%a", f.product(r, n), c)
        f.store(entry, work, line, c)
        entry = f.let(f"select i1 {is_diagonal}, double {_ONE}, double {_ZERO}")
        f.store(entry, work, line, c, n)
    least = f.let(f"call double @eliminate.{n}.{n}(ptr {work})")
    is_regular = f.let(f"fcmp ogt double {least}, {_ZERO}")
    with f.loop(0, n) as r, f.loop(0, n) as c:
        line = f.product(r, 2 * n)
        value = f.load(work, line, c, n)
        value = f.let(f"select i1 {is_regular}, double {value}, double {_NAN}")
        f.store(value, "%out", f.product(r, n), c)
    f.do("ret void")
    return f.text()
