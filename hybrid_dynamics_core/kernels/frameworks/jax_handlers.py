"""Compiled kernels as functions of JAX, through the foreign function interface of XLA.

On a CPU, XLA calls the machine code directly. The functions can be compiled and mapped by JAX. They
have no derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp

from ...ground.lazy import lazy
from ..ir.module import Form
from ..llvm import LoadedCode
from ..run import Kernel

Array = Any  # jax.Array; JAX is no dependency of type checks
Results = tuple[list[Array], Array]
_REGISTERED: list[LoadedCode] = []  # XLA may call them at any time


class Handler:
    """A kernel that XLA calls, as a function of vectors of 64 or 32 bits.

    Each is (size,) for all states, or (..., size). Those with leading axes have the same ones.
    """

    def __init__(self, kernel: Kernel, bits: int) -> None:
        self._kernel = kernel
        self._bits = bits
        self._shapes = [shape for _, shape in kernel.layout]
        self._mapped = jax.custom_batching.custom_vmap(self._run)
        self._mapped.def_vmap(self._run_mapped)

    def __call__(self, vectors: Sequence[Array]) -> Results:
        """The outputs (..., *shape), and the status (...), as the kernel gives it."""
        results: Results = self._mapped(*vectors)
        return results

    @lazy
    def _one(self) -> str:
        """Name of the code for one state."""
        if self._bits == 32:
            return self._rows
        return _registered(self._kernel.handler("xla_one"))

    @lazy
    def _rows(self) -> str:
        """Name of the code for many states."""
        form: Form = "xla_rows" if self._bits == 64 else "xla_32"
        return _registered(self._kernel.handler(form))

    def _run(self, *vectors: Array) -> Results:
        """The call, with rows for all leading axes."""
        batch = _leading(vectors)
        count = math.prod(batch)
        rows = []
        for vector in vectors:
            axes = (count,) if vector.ndim > 1 else ()
            rows.append(vector.reshape(*axes, vector.shape[-1]))
        real, integer = f"float{self._bits}", f"int{self._bits}"
        types = [jax.ShapeDtypeStruct((count, *shape), real) for shape in self._shapes]
        types.append(jax.ShapeDtypeStruct((count,), integer))
        name = self._one if count == 1 else self._rows
        *outs, status = jax.ffi.ffi_call(name, types)(*rows)
        shaped = []
        for out, shape in zip(outs, self._shapes, strict=True):
            shaped.append(out.reshape(*batch, *shape))
        return shaped, status.reshape(batch)

    def _run_mapped(
        self, size: int, are_mapped: Sequence[bool], *vectors: Array
    ) -> tuple[Results, Any]:
        """The call for vectors of which some have another axis in front."""
        inner: list[tuple[int, ...]] = []
        for vector, is_mapped in zip(vectors, are_mapped, strict=True):
            inner.append(vector.shape[is_mapped:-1])
        batch = jnp.broadcast_shapes(*inner)
        given = []
        for vector, is_mapped in zip(vectors, are_mapped, strict=True):
            is_shared = vector.ndim == 1 and not is_mapped
            given.append(vector if is_shared else _with_axes(vector, is_mapped, size, batch))
        outs, status = self(given)
        return (outs, status), ([True] * len(outs), True)


def _registered(code: LoadedCode) -> str:
    """The name under which XLA finds code, for as long as the process lives."""
    name = f"hybrid_dynamics_{len(_REGISTERED)}"
    _REGISTERED.append(code)
    jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(code.address), platform="cpu")
    return name


def _leading(vectors: Sequence[Array]) -> tuple[int, ...]:
    """The leading axes of vectors that have some."""
    return max((vector.shape[:-1] for vector in vectors), key=len)


def _with_axes(vector: Array, is_mapped: bool, size: int, batch: tuple[int, ...]) -> Array:
    """A vector with all leading axes, the mapped one first."""
    width = vector.shape[-1]
    if not is_mapped:
        vector = vector[None]
    elif vector.ndim == 2:
        vector = vector.reshape(size, *[1] * len(batch), width)
    return jnp.broadcast_to(vector, (size, *batch, width))
