"""JAX functions of a trace, whose values are arrays of one shape (...).

A trace has no branches, so the functions can be compiled, batched and differentiated by JAX.
Newton's iteration is a loop. It is differentiated by the implicit function theorem, in either
direction and to any order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP, TINY
from ..graph import Operand, Symbol
from ..trace import Check, Trace, trace_body

Array = Any  # jax.Array; JAX is no dependency of type checks
Vectors = Sequence[Sequence[Array]]

_UNARY: Mapping[str, Callable[[Array], Array]] = {
    "neg": lax.neg,
    "sin": lax.sin,
    "cos": lax.cos,
    "sqrt": lax.sqrt,
    "abs": lax.abs,
    "rint": jnp.rint,
}
_BINARY: Mapping[str, Callable[[Array, Array], Array]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "atan2": jnp.arctan2,
}
_SMALL_STEP_32 = 1e-4  # squared, it is below the rounding of 32 bits


class Values(NamedTuple):
    """Values of a trace.

    Attributes:
        outputs: all outputs, in order, each (...,).
        status: code of the first check that fails (...,), 0 if none does.
    """

    outputs: list[Array]
    status: Array


def evaluate(trace: Trace, vectors: Vectors, tolerance: Callable[[Check], float]) -> Values:
    """Evaluate a trace.

    Args:
        trace: the traced program.
        vectors: the components (...) of its inputs, of one type and one shape.
        tolerance: by how much the value of a check may be below its threshold.
    """
    nodes = _Nodes(trace, vectors)
    status = jnp.zeros(_first(vectors).shape, jnp.int32)
    for check in reversed(trace.checks):  # the first failed check decides
        value = nodes.value(check.value)
        passes = value > check.threshold - tolerance(check)
        status = jnp.where(passes, status, jnp.int32(check.code))
    return Values([nodes.array(x) for x in trace.outputs], status)


class _Nodes:
    """The values of the live nodes of a trace."""

    def __init__(self, trace: Trace, vectors: Vectors) -> None:
        self._trace = trace
        self._vectors = vectors
        self._zero = jnp.zeros_like(_first(vectors))
        self._values: dict[int, Array] = {}
        self._blocks: dict[int, Sequence[Array]] = {}
        for index in trace.live:
            self._values[index] = self._node(index)

    def value(self, x: Operand) -> Array:
        """The value of an operand."""
        if isinstance(x, Symbol):
            return self._values[x.index]
        return float(x)

    def array(self, x: Operand) -> Array:
        """The value of an operand as an array, constants too."""
        if isinstance(x, Symbol):
            return self._values[x.index]
        return self._zero + float(x)

    def _operand(self, x: int | float) -> Array:
        """The value of a node, or a constant."""
        if isinstance(x, int):
            return self._values[x]
        return x

    def _node(self, index: int) -> Array:
        """The value of a node whose operands are computed."""
        op, a, b = self._trace.graph.nodes[index]
        if op == "input":
            return self._vectors[int(a)][int(b)]
        if op == "block":
            return self._block(int(a))[int(b)]
        first = self._operand(a)
        if op in _UNARY:
            return _UNARY[op](first)
        return _BINARY[op](first, self._operand(b))

    def _block(self, number: int) -> Sequence[Array]:
        """The results of a block, computed once."""
        if number not in self._blocks:
            block = self._trace.graph.blocks[number]
            arguments = [list(map(self.array, vector)) for vector in block.arguments]
            arguments = lax.optimization_barrier(arguments)
            if block.body is None:
                self._blocks[number] = _inverted(arguments[0], block.size)
            else:
                body = trace_body(self._trace, number)
                self._blocks[number] = _solved(body, block.size, *arguments)
        return self._blocks[number]


def _first(vectors: Vectors) -> Array:
    """The first component of all: it has the type and the shape (...) of each."""
    return next(chain.from_iterable(vectors))


def _inverted(entries: Sequence[Array], size: int) -> list[Array]:
    """The inverse of a matrix row by row."""
    rows = _rows(entries, size)
    one = jnp.ones_like(entries[0])
    zero = jnp.zeros_like(entries[0])
    unit = [[zero] * size for _ in range(size)]
    for k in range(size):
        unit[k][k] = one
    return [*chain.from_iterable(_eliminated(rows, unit))]


def _solved(
    body: Trace, size: int, guess: Sequence[Array], parameters: Sequence[Array]
) -> Sequence[Array]:
    """Solution of a Newton block, then its number of iterations, negative if they fail.

    Args:
        body: trace of its residuals, and of their derivatives by the unknowns row by row.
        size: number of unknowns.
        guess: start of the iteration.
        parameters: parameters of the equations.
    """

    def equations(x: Sequence[Array], p: Sequence[Array]) -> list[Array]:
        """Residuals, then their derivatives by the unknowns row by row."""
        return evaluate(body, (x, p), _exactly).outputs

    def values(guess: Sequence[Array], p: Sequence[Array]) -> list[Array]:
        return _newton(equations, size, guess, p)

    def tangent(primals: Vectors, tangents: Vectors) -> tuple[list[Array], list[Array]]:
        """The solution with its change: that of the guess does not matter."""
        *x, count = solve(*primals)
        p = primals[1]
        move = tangents[1]

        def residuals(p: Sequence[Array]) -> list[Array]:
            return equations(x, p)[:size]

        _, slopes = jax.jvp(residuals, (p,), (move,))
        jacobian = _rows(equations(x, p)[size:], size)
        change = _solve_linear(jacobian, [-slope for slope in slopes])
        return [*x, count], [*change, jnp.zeros_like(count)]

    solve: Any = jax.custom_jvp(values)
    solve.defjvp(tangent)
    solution: list[Array] = solve(list(guess), list(parameters))
    return solution


def _exactly(_check: Check) -> float:
    """No tolerance for a check."""
    return 0.0


def _newton(
    equations: Callable[[Sequence[Array], Sequence[Array]], list[Array]],
    size: int,
    guess: Sequence[Array],
    p: Sequence[Array],
) -> list[Array]:
    """Newton's iteration: the solution, then the number of iterations, negative if they fail.

    Every state stops by itself.
    """
    like = guess[0]
    small = _SMALL_STEP_32
    if like.dtype == jnp.float64:
        small = SMALL_STEP

    def advance(state: _Iteration) -> _Iteration:
        """One step of all states that are still iterated."""
        values = equations(state.x, p)
        step = _solve_linear(_rows(values[size:], size), values[:size])
        longest = _maximum([jnp.abs(x) for x in step])
        finite = longest < jnp.inf
        share = jnp.minimum(1.0, LARGEST_STEP / jnp.maximum(longest, TINY))
        share = jnp.where(state.works & finite, share, 0.0)
        x: list[Array] = []
        for a, b in zip(state.x, step, strict=True):
            moved = a - share * b
            x.append(jnp.where(share > 0.0, moved, a))  # b may be infinite
        count = jnp.where(state.works, state.count + 1, state.count)
        converged = state.converged | (state.works & (longest < small))
        works = state.works & finite & ~converged & (count < MAX_ITERATIONS)
        return _Iteration(x, count, works, converged)

    nowhere = jnp.zeros(like.shape, bool)
    start = _Iteration(
        list(guess),
        jnp.zeros_like(like),
        ~nowhere,
        nowhere,
    )
    last = lax.while_loop(_goes_on, advance, start)
    count = jnp.where(last.converged, last.count, -last.count)
    return [*last.x, count]


class _Iteration(NamedTuple):
    """States of Newton's iteration.

    Attributes:
        x: the unknowns (...).
        count: number of iterations so far (...).
        works: whether a state is still iterated (...).
        converged: whether it has converged (...).
    """

    x: list[Array]
    count: Array
    works: Array
    converged: Array


def _goes_on(state: _Iteration) -> Array:
    return jnp.any(state.works)


def _rows(flat: Sequence[Array], width: int) -> list[list[Array]]:
    """Rows of a matrix whose entries come row by row."""
    return [list(flat[k : k + width]) for k in range(0, len(flat), width)]


def _maximum(values: Sequence[Array]) -> Array:
    """The largest of some values (...), state by state."""
    largest = values[0]
    for value in values[1:]:
        largest = jnp.maximum(largest, value)
    return largest


def _solve_linear(rows: list[list[Array]], right: Sequence[Array]) -> list[Array]:
    """A^-1 b; not finite if A is singular."""
    solution = _eliminated(rows, [[x] for x in right])
    return [row[0] for row in solution]


def _eliminated(left: list[list[Array]], right: list[list[Array]]) -> list[list[Array]]:
    """A^-1 B, by Gauss-Jordan elimination with pivoting, state by state.

    LAPACK would take longer for the few unknowns of a loop than the whole closure.
    """
    size = len(left)
    rows = [[*a, *b] for a, b in zip(left, right, strict=True)]
    for c in range(size):
        for r in range(c + 1, size):
            upper = rows[c]
            lower = rows[r]
            swaps = jnp.abs(lower[c]) > jnp.abs(upper[c])
            pairs = list(zip(upper, lower, strict=True))
            rows[c] = [jnp.where(swaps, b, a) for a, b in pairs]
            rows[r] = [jnp.where(swaps, a, b) for a, b in pairs]
        pivot = rows[c][c]
        rows[c] = [x / pivot for x in rows[c]]
        for r in range(size):
            if r != c:
                factor = rows[r][c]
                pairs = list(zip(rows[r], rows[c], strict=True))
                rows[r] = [x - factor * y for x, y in pairs]
        rows = lax.optimization_barrier(rows)  # XLA would repeat a column in each later entry
    return [row[size:] for row in rows]
