"""The calls of a robot as pure functions of JAX.

    tau, status = robot.jax.inverse_dynamics(u, du, ddu)
    slope = jax.jacobian(lambda u: robot.jax.inverse_dynamics(u, du, ddu)[0])(u)

They can be compiled by `jax.jit`, mapped by `jax.vmap` and differentiated by `jax.grad`. The
derivatives are exact: they are those of `robot.inverse_dynamics_derivatives` and the like, of the
same programs. They are not derivatives of iterations. On a CPU, XLA calls the compiled kernels
of the library. Elsewhere the programs are traced, and XLA compiles them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ...dynamics.loads import Loads
from ...errors import InputError
from ...ground.lazy import lazy
from ...kernels.run import is_native
from ...programs import OutcomeKind
from ..closure import Closure
from ..dynamics import Dynamics
from .calls import CALL_BY_NAME, Call
from .function_calls import FunctionCalls

try:
    import jax
    import jax.numpy as jnp

    from .jax_native import NativeCall
    from .jax_traced import TracedCall
except ModuleNotFoundError as error:  # pragma: no cover
    if error.name not in ("jax", "jaxlib"):
        raise
    raise InputError(
        "robot.jax needs JAX: pip install 'hybrid_dynamics_ros[jax]', or jax"
    ) from error

Array = Any  # jax.Array
Function = Callable[..., tuple[Any, Array]]
Layout = tuple[tuple[str, tuple[int, ...]], ...]
_NoChange = jax.custom_derivatives.SymbolicZero
_NOT_FINITE = int(OutcomeKind.NOT_FINITE)


class JaxCalls(FunctionCalls):
    """The calls of a robot in JAX.

    Every call takes vectors (n,) of one state, or (..., n) of states side by side. Vectors are
    broadcast against each other. A call returns its results and then `status`, an int32 array: 0
    (CLOSED), or the number of another `OutcomeKind`. With another one the results are NaN.

    The type is that of the arguments, float32 unless `jax_enable_x64` is set. On a CPU, results of
    32 bits are rounded once. Traced calls have about five digits there. The checks allow for that.

    Dynamics also take `gravity` (3,) [m/s^2]. All calls take `start`, the reference configuration
    by default. Loops without a closed form are closed from there in one smooth move. The status is
    JUMP if u is too far away.
    """

    def __init__(
        self,
        closure: Closure,
        dynamics: Dynamics,
        loads: Loads,
        frame: str | None = None,
        *,
        traces: bool = False,
    ) -> None:
        super().__init__(closure, dynamics, loads, frame)
        self._traces = traces
        self._functions: dict[str, Function] = {}

    def _with(self, loads: Loads, frame: str | None) -> JaxCalls:
        return JaxCalls(self._closure, self._dynamics, loads, frame, traces=self._traces)

    @lazy
    def traced(self) -> JaxCalls:
        """The same calls compiled by XLA, on a CPU too; for `jax.export` and other devices."""
        return JaxCalls(self._closure, self._dynamics, self._loads, self._frame, traces=True)

    def _run(self, name: str, vectors: dict[str, Array]) -> tuple[Any, Array]:
        """Results of a call in their shapes, and status; it is compiled at its first use."""
        call = CALL_BY_NAME[name]
        if name not in self._functions:
            self._functions[name] = jax.jit(self._function(call))
        names = (*call.inputs, *self._tracer.start_names())
        arrays = [self._checked(key, vectors[key]) for key in names]
        return self._functions[name](*arrays)

    def _checked(self, name: str, values: Array) -> Array:
        """A floating vector (..., size of the input); raises InputError."""
        array = jnp.asarray(values)
        if not jnp.issubdtype(array.dtype, jnp.floating):
            array = array.astype(float)
        if name == "du" and array.ndim == 0:
            array = jnp.broadcast_to(array, (self._size(name),))
        self._check_shape(name, array.shape)
        return array

    def _function(self, call: Call) -> Callable[..., tuple[Any, Array]]:
        """The function of a call: vectors -> results in their shapes, status."""
        native = {bits: NativeCall(call, self._tracer, bits) for bits in (64, 32)}
        traced = TracedCall(call, self._tracer)

        def function(*vectors: Array) -> tuple[list[Array], Array]:
            # gravity and the start are often of 64 bits, and do not choose the type
            by_name = zip(call.inputs, vectors, strict=False)
            dtype = jnp.result_type(*[vector for name, vector in by_name if name != "gravity"])
            batch = jnp.broadcast_shapes(*[vector.shape[:-1] for vector in vectors])
            bits = 8 * dtype.itemsize
            if bits in native and self._is_native:
                form = native[bits]
                flat, status = _evaluated(call, form, _with_axes(vectors, dtype, batch))
                return _shaped(flat, batch, form.layout), status
            alike = [_alike(vector, dtype, batch) for vector in vectors]
            flat, status = _evaluated(call, traced, alike)
            return _shaped(flat, batch, traced.layout), status

        return function

    @property
    def _is_native(self) -> bool:
        """Whether XLA calls the compiled code of the library."""
        return not self._traces and jax.default_backend() == "cpu" and is_native()


def _with_axes(vectors: Sequence[Array], dtype: Any, batch: tuple[int, ...]) -> list[Array]:
    """Vectors of a type, each (size,) or with all leading axes."""
    arrays = []
    for vector in vectors:
        axes = batch if vector.ndim > 1 else ()
        arrays.append(_alike(vector, dtype, axes))
    return arrays


def _alike(vector: Array, dtype: Any, batch: tuple[int, ...]) -> Array:
    """A vector of the type, and with the leading axes, that all vectors have."""
    return jnp.broadcast_to(vector.astype(dtype), (*batch, vector.shape[-1]))


def _evaluated(
    call: Call, form: NativeCall | TracedCall, vectors: Sequence[Array]
) -> tuple[Array, Array]:
    """Flat results (..., r) and status (...) of a call, with exact derivatives.

    Args:
        call: the call.
        form: its values and derivatives.
        vectors: its inputs.
    """

    def values(*vectors: Array) -> tuple[Array, Array]:
        flat, status = form.values(vectors)
        status = jnp.where(_are_finite(vectors), status, _NOT_FINITE)
        status = jnp.where((status == 0) & ~_are_finite([flat]), _NOT_FINITE, status)
        return jnp.where((status == 0)[..., None], flat, jnp.nan), status

    function: Any = jax.custom_jvp(values)

    def tangent(vectors: Any, tangents: Any) -> Any:
        """Results with their changes, by the derivatives for the inputs that change."""
        outputs, status = function(*vectors)
        by_name = zip(call.inputs, tangents, strict=False)  # the start is no input
        moves = {name: move for name, move in by_name if not isinstance(move, _NoChange)}
        change = form.change(vectors, moves) if moves else jnp.zeros_like(outputs)
        change = change * jnp.where(status == 0, 1.0, jnp.nan)[..., None]
        no_change = np.zeros(status.shape, jax.dtypes.float0)  # what JAX takes for integers
        return (outputs, status), (change, no_change)

    function.defjvp(tangent, symbolic_zeros=True)
    result: tuple[Array, Array] = function(*vectors)
    return result


def _are_finite(vectors: Iterable[Array]) -> Array:
    """Whether all components of vectors (..., size) are finite (...)."""
    result: Array = True
    for vector in vectors:
        result = result & jnp.all(jnp.isfinite(vector), axis=-1)
    return result


def _shaped(flat: Array, batch: tuple[int, ...], layout: Layout) -> list[Array]:
    """The results in their shapes, after the leading axes."""
    results = []
    first = 0
    for _, shape in layout:
        last = first + math.prod(shape)
        results.append(flat[..., first:last].reshape(*batch, *shape))
        first = last
    return results
