"""A call traced into JAX: XLA compiles it, for any device and in 32 bits too."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import jax
import jax.numpy as jnp

from ...ground.lazy import lazy
from ...kernels.frameworks import jax_functions
from ...kernels.trace import Check, Trace
from ...programs import SLACK_32, OutcomeKind
from .calls import Call, CallTracer

Array = Any  # jax.Array


class TracedCall:
    """Values and derivatives of a call, traced into JAX."""

    def __init__(self, call: Call, tracer: CallTracer) -> None:
        self._call = call
        self._tracer = tracer

    @lazy
    def _trace(self) -> Trace:
        return self._tracer.values(self._call)

    @property
    def layout(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Names and shapes of the results."""
        return self._trace.layout

    def values(self, vectors: Iterable[Array]) -> tuple[Array, Array]:
        """Flat results (..., r), and the kind of the outcome (...), of vectors (..., size)."""
        parts = [components(vector) for vector in vectors]
        tolerance = _tolerance(parts[0][0].dtype)
        outputs, status = jax_functions.evaluate(self._trace, parts, tolerance)
        if self._trace.live_blocks():  # XLA would compute what results share once for each of them
            outputs = jax.lax.optimization_barrier(outputs)
        return jnp.stack(outputs, axis=-1), status

    def change(self, vectors: Iterable[Array], moves: Mapping[str, Array]) -> Array:
        """Change (..., r) of the results for changes (..., size) of inputs by name."""
        parts = [components(vector) for vector in vectors]
        derivatives = self._tracer.slopes(self._call, list(moves))
        slopes, _ = jax_functions.evaluate(derivatives, parts, exactly)
        return _pushed(slopes, [components(move) for move in moves.values()])


def components(vector: Array) -> list[Array]:
    """The components (...) of a vector (..., size)."""
    return [vector[..., k] for k in range(vector.shape[-1])]


def _pushed(slopes: list[Array], moves: list[list[Array]]) -> Array:
    """Changes (..., count) of results: derivatives times changes of the inputs.

    Args:
        slopes: derivatives (...) by each input, row by row.
        moves: changes of the components (...) of each input.
    """
    count = len(slopes) // sum(map(len, moves))
    totals: list[Array] = [0.0] * count
    first = 0
    for move in moves:
        for k in range(count):
            for change in move:
                totals[k] = totals[k] + slopes[first] * change
                first += 1
    return jnp.stack(totals, axis=-1)


def exactly(_check: Check) -> float:
    """No tolerance for a check."""
    return 0.0


def _tolerance(dtype: Any) -> Callable[[Check], float]:
    """By how much the value of a check may be below its threshold, for rounding."""
    if dtype == jnp.float64:
        return exactly
    return lambda check: SLACK_32.get(OutcomeKind(check.code), 0.0)
