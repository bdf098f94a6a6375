"""A call by the machine code of the library, for CPUs. It computes in 64 bits.

Values and first derivatives are compiled kernels, which XLA calls. Derivatives of the derivatives
are those of the traced call.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp

from ...ground.lazy import lazy
from ...kernels.frameworks import jax_functions
from ...kernels.frameworks.jax_handlers import Handler
from ...kernels.run import Kernel
from ...programs import Program, kinds, of_rounded
from .calls import Call, CallTracer
from .jax_traced import components, exactly

Array = Any  # jax.Array


class _Part:
    """A compiled program of a call, whose constants are held."""

    def __init__(self, program: Program, tracer: CallTracer, label: str, bits: int) -> None:
        self._bits = bits
        self._kernel = tracer.kernel(program, label)
        self._inputs = program.inputs
        self._constants = tracer.constants

    @lazy
    def _handler(self) -> Handler:
        return Handler(self._kernel, self._bits)

    @property
    def kernel(self) -> Kernel:
        """The kernel."""
        return self._kernel

    def __call__(self, named: Mapping[str, Array]) -> tuple[dict[str, Array], Array]:
        """Results by name, and the status of the kernel."""
        values = {**self._constants, **named}
        kind = f"float{self._bits}"
        vectors = [jnp.asarray(values[name]).astype(kind) for name in self._inputs]
        outs, status = self._handler(vectors)
        return dict(zip(self._kernel.names, outs, strict=True)), status


class NativeCall:
    """Values and derivatives of a call by compiled kernels, of numbers of 64 or 32 bits."""

    def __init__(self, call: Call, tracer: CallTracer, bits: int) -> None:
        self._bits = bits
        self._call = call
        self._tracer = tracer
        self._slopes: dict[tuple[str, ...], Any] = {}

    @lazy
    def _values(self) -> _Part:
        program = self._tracer.program(self._call)
        if self._bits == 32:
            program = of_rounded(program)
        return _Part(program, self._tracer, self._call.name, self._bits)

    @lazy
    def layout(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Names and shapes of the results."""
        shapes = dict(self._values.kernel.layout)
        return tuple((name, shapes[name]) for name in self._call.results)

    def values(self, vectors: Sequence[Array]) -> tuple[Array, Array]:
        """Flat results (..., r), and the kind of the outcome (...).

        Args:
            vectors: the inputs, each (size,) for all states or (..., size).
        """
        outs, codes = self._values(self._named(vectors))
        rows = [(*codes.shape, math.prod(shape)) for _, shape in self.layout]
        names = self._call.results
        flat = [outs[name].reshape(shape) for name, shape in zip(names, rows, strict=True)]
        return jnp.concatenate(flat, axis=-1), kinds(codes, jnp.where).astype(jnp.int32)

    def change(self, vectors: Sequence[Array], moves: Mapping[str, Array]) -> Array:
        """Change (..., r) of the results for changes of inputs by name."""
        by = tuple(moves)
        if by not in self._slopes:
            self._slopes[by] = self._compiled_slopes(by)
        total: Array = 0.0
        for slope, move in zip(self._slopes[by](*vectors), moves.values(), strict=True):
            total = total + (slope * move[..., None, :]).sum(axis=-1)
        return total

    def _compiled_slopes(self, by: tuple[str, ...]) -> Any:
        """The function of the derivatives (..., r, size) by some inputs, in order."""
        count = sum(math.prod(shape) for _, shape in self.layout)
        parts: list[tuple[_Part, Mapping[str, str]]] = []
        for program, results in self._tracer.slope_programs(self._call, by):
            label = f"{self._call.name}_by_{'_'.join(results)}"
            parts.append((_Part(program, self._tracer, label, self._bits), results))

        def slopes(*vectors: Array) -> list[Array]:
            named = self._named(vectors)
            matrices: dict[str, Array] = {}
            for part, results in parts:
                outs, codes = part(named)
                for name, result in results.items():
                    size = named[name].shape[-1]
                    matrices[name] = outs[result].reshape(*codes.shape, count, size)
            return [matrices[name] for name in by]

        def tangent(vectors: Any, tangents: Any) -> Any:
            return jax.jvp(traced, vectors, tangents)

        def traced(*vectors: Array) -> list[Array]:
            return self._traced_slopes(by, vectors, count)

        function: Any = jax.custom_jvp(slopes)
        function.defjvp(tangent)
        return function

    def _traced_slopes(
        self, by: tuple[str, ...], vectors: Sequence[Array], count: int
    ) -> list[Array]:
        """The same derivatives, for XLA to compile and JAX to differentiate."""
        batch = jnp.broadcast_shapes(*[vector.shape[:-1] for vector in vectors])
        alike = [jnp.broadcast_to(vector, (*batch, vector.shape[-1])) for vector in vectors]
        parts = [components(vector) for vector in alike]
        flat, _ = jax_functions.evaluate(self._tracer.slopes(self._call, by), parts, exactly)
        matrices = []
        for name in by:
            size = self._named(vectors)[name].shape[-1]
            entries = jnp.stack(flat[: count * size], axis=-1)
            matrices.append(entries.reshape(*batch, count, size))
            flat = flat[count * size :]
        return matrices

    def _named(self, vectors: Sequence[Array]) -> dict[str, Array]:
        """The inputs by name."""
        names = (*self._call.inputs, *self._tracer.start_names())
        return dict(zip(names, vectors, strict=True))
