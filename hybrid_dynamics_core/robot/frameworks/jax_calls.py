"""The calls of a robot as pure functions of JAX.

    tau, status = robot.jax.inverse_dynamics(u, du, ddu)
    slope = jax.jacobian(lambda u: robot.jax.inverse_dynamics(u, du, ddu)[0])(u)

They can be compiled by `jax.jit`, mapped by `jax.vmap` and differentiated by `jax.grad`. The
derivatives are exact: they are those of `robot.inverse_dynamics_derivatives` and the like, of the
same programs. They are not derivatives of iterations. On a CPU, in 64 bits, XLA calls the compiled
kernels of the library. Elsewhere the programs are traced, and XLA compiles them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...dynamics.loads import Loads
from ...errors import InputError
from ...ground.lazy import lazy
from ...kernels.run import is_native
from ...programs import OutcomeKind
from ..closure import Closure
from ..dynamics import Dynamics
from .calls import CALLS, STEP, Call, CallTracer

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
CALL_BY_NAME = {call.name: call for call in (*CALLS, STEP)}
_NoChange = jax.custom_derivatives.SymbolicZero
_NOT_FINITE = int(OutcomeKind.NOT_FINITE)


class JaxStart(NamedTuple):
    """A closed configuration that calls start from; a pytree.

    Attributes:
        s: all coordinates (n_s,) [rad, m].
        start_map: R there, row by row (n_s * n,).
    """

    s: Array
    start_map: Array


class JaxCalls:
    """The calls of a robot in JAX.

    Every call takes vectors (n,) of one state, or (..., n) of states side by side. Vectors are
    broadcast against each other. A call returns its results and then `status`, an int32 array: 0
    (CLOSED), or the number of another `OutcomeKind`. With another one the results are NaN.

    The type is that of the arguments, float32 unless `jax_enable_x64` is set. In 32 bits results
    have about five digits, and the checks allow for that.

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
        self._closure = closure
        self._dynamics = dynamics
        self._loads = loads
        self._frame = frame
        self._traces = traces
        self._functions: dict[str, Function] = {}

    def at(self, frame: str) -> JaxCalls:
        """The same calls for another frame or link in place of the end effector.

        Raises:
            InputError: there is no such frame.
        """
        self._closure.model.frame(frame)
        return JaxCalls(self._closure, self._dynamics, self._loads, frame, traces=self._traces)

    def under(self, loads: Loads) -> JaxCalls:
        """The same calls under other loads."""
        return JaxCalls(self._closure, self._dynamics, loads, self._frame, traces=self._traces)

    @lazy
    def traced(self) -> JaxCalls:
        """The same calls compiled by XLA, on a CPU too; for `jax.export` and other devices."""
        return JaxCalls(self._closure, self._dynamics, self._loads, self._frame, traces=True)

    def close(
        self, u: Array, du: Array = 0.0, start: JaxStart | None = None
    ) -> tuple[Array, Array, Array]:
        """All coordinates s and rates s', (..., n_s) each, and the status."""
        (s, ds), status = self._call("close", start, u=u, du=du)
        return s, ds, status

    def forward_kinematics(
        self, u: Array, start: JaxStart | None = None
    ) -> tuple[Array, Array, Array]:
        """Position (..., 3) and rotation (..., 3, 3) of the end effector, and the status."""
        (position, rotation), status = self._call("forward_kinematics", start, u=u)
        return position, rotation, status

    def jacobian(self, u: Array, start: JaxStart | None = None) -> tuple[Array, Array]:
        """Jacobian (..., 6, n) of the end effector, linear before angular, and the status."""
        (jacobian,), status = self._call("jacobian", start, u=u)
        return jacobian, status

    def inverse_dynamics(
        self,
        u: Array,
        du: Array,
        ddu: Array,
        gravity: Array | None = None,
        start: JaxStart | None = None,
    ) -> tuple[Array, Array]:
        """Efforts tau (..., n) and the status, by the minimal form; Chu (2020), Eq. 17."""
        (tau,), status = self._call(
            "inverse_dynamics", start, u=u, du=du, ddu=ddu, gravity=self._gravity(gravity)
        )
        return tau, status

    def forward_dynamics(
        self,
        u: Array,
        du: Array,
        tau: Array,
        gravity: Array | None = None,
        start: JaxStart | None = None,
    ) -> tuple[Array, Array]:
        """Accelerations u'' (..., n) and the status, by the minimal form; Chu (2020), Eq. 17."""
        (ddu,), status = self._call(
            "forward_dynamics", start, u=u, du=du, tau=tau, gravity=self._gravity(gravity)
        )
        return ddu, status

    def minimal_form(
        self,
        u: Array,
        du: Array,
        gravity: Array | None = None,
        start: JaxStart | None = None,
    ) -> tuple[Array, Array, Array, Array]:
        """M-bar (..., n, n), C-bar u', G-bar (..., n), status; minimal form, Chu (2020), Eq. 17."""
        (mass, drift, weight), status = self._call(
            "minimal_form", start, u=u, du=du, gravity=self._gravity(gravity)
        )
        return mass, drift, weight, status

    def step(self, u: Array, start: JaxStart | None = None) -> tuple[JaxStart, Array]:
        """The closed configuration at u, for the next call along a motion, and the status."""
        if not self._closure.is_followed:  # closed forms need no R at the start
            s, _, status = self.close(u, start=start)
            return JaxStart(s, self.start.start_map), status
        (s, start_map), status = self._call("step", start, u=u)
        return JaxStart(s, start_map), status

    @property
    def start(self) -> JaxStart:
        """The reference configuration."""
        if self._closure.is_followed:
            reference = self._closure.reference_start
            return JaxStart(reference.s, reference.velocity_map.reshape(-1))
        n_s, n = len(self._closure.model.coordinates), len(self._closure.model.active)
        return JaxStart(self._closure.start, np.zeros(n_s * n))  # closed forms need no R

    def _gravity(self, gravity: Array | None) -> Array:
        """Gravity (..., 3) [m/s^2]; that of the loads if None."""
        return self._loads.gravity if gravity is None else gravity

    @lazy
    def _tracer(self) -> CallTracer:
        """Traces the calls under these loads."""
        return CallTracer(
            self._closure, self._dynamics, self._loads, self._frame, self._closure.signs
        )

    def _call(self, name: str, start: JaxStart | None, **vectors: Array) -> tuple[Any, Array]:
        """Results of a call in their shapes, and status; it is compiled at its first use.

        Args:
            name: name of the call.
            start: where loops start; the reference if None.
            vectors: its inputs by name.
        """
        call = CALL_BY_NAME[name]
        given = start or self.start
        by_name = {**vectors, "start": given.s, "start_map": given.start_map, "guess": given.s}
        names = (*call.inputs, *self._tracer.start_names())
        if name not in self._functions:
            self._functions[name] = jax.jit(self._function(call))
        arrays = [self._checked(key, by_name[key]) for key in names]
        return self._functions[name](*arrays)

    def _checked(self, name: str, values: Array) -> Array:
        """A floating vector (..., size of the input); raises InputError."""
        array = jnp.asarray(values)
        if not jnp.issubdtype(array.dtype, jnp.floating):
            array = array.astype(float)
        size = self._closure.model.program_model.size(name)
        if name == "du" and array.ndim == 0:
            return jnp.broadcast_to(array, (size,))
        if array.ndim == 0 or array.shape[-1] != size:
            raise InputError(f"{name} has shape {array.shape}; expected (..., {size})")
        return array

    def _function(self, call: Call) -> Callable[..., tuple[Any, Array]]:
        """The function of a call: vectors -> results in their shapes, status."""
        native = NativeCall(call, self._tracer)
        traced = TracedCall(call, self._tracer)

        def function(*vectors: Array) -> tuple[list[Array], Array]:
            # gravity and the start are often of 64 bits, and do not choose the type
            by_name = zip(call.inputs, vectors, strict=False)
            dtype = jnp.result_type(*[vector for name, vector in by_name if name != "gravity"])
            batch = jnp.broadcast_shapes(*[vector.shape[:-1] for vector in vectors])
            if dtype == jnp.float64 and self._is_native:
                flat, status = _evaluated(call, native, _spread(vectors, dtype, batch))
                return _shaped(flat, batch, native.layout), status
            alike = [_alike(vector, dtype, batch) for vector in vectors]
            flat, status = _evaluated(call, traced, alike)
            return _shaped(flat, batch, traced.layout), status

        return function

    @property
    def _is_native(self) -> bool:
        """Whether XLA calls the compiled code of the library."""
        return not self._traces and jax.default_backend() == "cpu" and is_native()


def _spread(vectors: Sequence[Array], dtype: Any, batch: tuple[int, ...]) -> list[Array]:
    """Vectors of a type, each (size,) or with all leading axes."""
    spread = []
    for vector in vectors:
        axes = batch if vector.ndim > 1 else ()
        spread.append(_alike(vector, dtype, axes))
    return spread


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
