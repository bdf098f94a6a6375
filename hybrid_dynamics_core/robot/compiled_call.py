"""One compiled call: a fast path into compiled code, and a fallback for all other arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import finite_vectors, real_array
from ..ground.lazy import lazy
from ..kernels.caller import Signature, make_caller
from ..kernels.run import Codes, Kernel
from ..kernels.status import any_failed
from .call_kernels import CallKernels
from .closure import Closure
from .closure_runs import start_inputs
from .warm_start import WarmStart

# inputs that vary with the state; all others are constants of the robot
STATE_INPUTS = ("u", "du", "ddu", "tau")
# (closed state, inputs of a state) -> raises the error of the state
Explain = Callable[..., object]


class CompiledCall:
    """A program of a robot as a function of arrays.

    Args:
        kernels: the compiled program.
        closure: closes loops that have to be followed, and explains states that do not close.
        constants: values of all inputs that do not vary with the state.
        optional: inputs of a state that are zero by default.
        explain: raises the error of a state that closes, but has no result.
        under_any_gravity: makes the same call for gravity along any axis; None: this one is.
    """

    def __init__(
        self,
        kernels: CallKernels,
        closure: Closure,
        constants: Mapping[str, Array],
        optional: Sequence[str] = (),
        explain: Explain | None = None,
        under_any_gravity: Callable[[], CompiledCall] | None = None,
    ) -> None:
        program = kernels.program
        self._kernels = kernels
        self._closure = closure
        self._active = closure.model.active
        self._explain = explain
        self._under_any_gravity = under_any_gravity
        self._names = program.inputs
        sizes = [program.size(closure.model.program_model, name) for name in program.inputs]
        self._sizes = dict(zip(program.inputs, sizes, strict=True))
        self._of_state = [name for name in program.inputs if name in STATE_INPUTS]
        self._optional: dict[str, Array] = {}
        for name in optional:
            self._optional[name] = frozen(np.zeros(self._sizes[name]))
        self._constants: dict[str, Array] = {}
        for name in program.inputs:
            if name not in STATE_INPUTS:
                self._constants[name] = constants[name]

    def caller(self) -> Callable[..., Any]:
        """The function: inputs of a state, out, check, threads, start, other inputs -> results."""
        n_s, n = len(self._closure.model.coordinates), len(self._active)
        reference = np.empty(n_s), np.empty(n_s * n)
        if self._closure.is_followed:
            reference = self._closure.reference_start.flat
        signature = Signature(
            inputs=self._names,
            given=self._of_state,
            values=self._constants,
            shapes=[shape for _, shape in self._layout],
            optional=self._optional,
            is_followed=self._closure.is_followed,
            reference=reference,
            start_type=WarmStart,
            fixed=() if self._under_any_gravity is None else ("gravity",),
        )
        call = make_caller(signature, self._kernels.loaders(), self.call_thoroughly)
        kernel, names = self._kernels.at_guess, self._names
        values = dict(self._constants)
        if self._closure.is_followed:
            kernel, names = self._kernels.from_start, self._kernels.names_from_start
            values["start"], values["start_map"] = reference
        return kernel.caller([values.get(name) for name in names], call)

    @lazy
    def _layout(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Names and shapes of the results."""
        if self._closure.is_followed:
            return self._kernels.from_start.layout
        return self._kernels.at_guess.layout

    def call_thoroughly(
        self,
        values: dict[str, Any],
        out: Any,
        check: bool,
        threads: Any,
        start: WarmStart | None,
    ) -> Any:
        """The fallback: batches, other arrays, loops that are followed, and errors."""
        if self._has_other_gravity(values):
            return self._general.call_thoroughly(values, out, check, threads, start)
        if not isinstance(threads, int) or threads < 1:
            raise InputError(f"threads is {threads!r}; expected 1 or more")
        inputs = self._checked_inputs(values)
        outs = self._checked_outs(out, _rows(inputs["u"]))
        if out is not None:
            inputs = _apart(inputs, outs)
        # the very object of the constants: the caller gave no guess
        is_reference = values["guess"] is self._constants["guess"]
        if start is not None:
            is_default = is_reference and values["branch"] is self._constants["branch"]
            codes = self._run_along(start, inputs, outs, threads, is_default)
        elif is_reference and self._closure.iterates:
            codes = self._run_from_reference(inputs, outs, threads, check)
        else:
            codes = self._run(inputs, outs, threads)
        if any_failed(codes):
            self._mark_failures(inputs, outs, codes, check)
        if len(outs) == 1:
            return outs[0]
        return tuple(outs)

    def _has_other_gravity(self, values: Mapping[str, Any]) -> bool:
        """Whether the caller gave a gravity with components that the code does not have."""
        if self._under_any_gravity is None:
            return False
        gravity, default = values["gravity"], self._constants["gravity"]
        if gravity is default:
            return False
        array = real_array("gravity", gravity)
        return array.shape[-1:] != default.shape or bool(array[..., default == 0.0].any())

    @lazy
    def _general(self) -> CompiledCall:
        """The same call for gravity along any axis."""
        assert self._under_any_gravity is not None  # noqa: S101  asked before
        return self._under_any_gravity()

    def _run_along(
        self,
        start: object,
        inputs: dict[str, Array],
        outs: list[Array],
        threads: int,
        is_default: bool,
    ) -> Codes:
        """One state, or rows that follow each other, from a start, which moves along."""
        if not isinstance(start, WarmStart):
            kind = type(start).__name__
            raise InputError(f"start is a {kind}; expected a WarmStart, of robot.kernels.start()")
        if not is_default:
            raise InputError("give start, or guess and branch: the start has both of its own")
        sizes = len(start.s), len(start.signs)
        if sizes != (len(self._closure.start), len(self._closure.signs)):
            raise InputError("start belongs to another robot")
        u = inputs["u"]
        if u.ndim == 2 and len(u) and not self._closure.charts.change_in_loops:
            place = start.s, start.start_map
            along = inputs | {"branch": start.signs}
            last = self._kernels.run_motion(self._closure.quick, along, outs, place)
            if last is not None:
                start.s, start.start_map = last
                return np.zeros(len(u), dtype=np.int64)
            for out in outs:
                out.fill(np.nan)
        near = start.state(self._closure)
        close = self._closure.close if u.ndim == 1 else self._closure.close_path
        state = close(u, near=near)
        codes = self._run(inputs | {"branch": state.signs, "guess": state.s}, outs, threads)
        if not any_failed(codes):
            start.move_to(state)
        return codes

    def _run_from_reference(
        self,
        inputs: dict[str, Array],
        outs: list[Array],
        threads: int,
        check: bool,
    ) -> Codes:
        """In one move from the reference; what is farther off is followed."""
        if not self._closure.is_followed:
            return self._run_followed(inputs, outs, threads, check)
        from_start = {**inputs, **start_inputs(self._closure.reference_start)}
        arguments = [from_start[name] for name in self._kernels.names_from_start]
        codes = _run_kernel(self._kernels.from_start, arguments, outs, threads)
        if not any_failed(codes):
            return codes
        self._check_finite(inputs)
        if codes.ndim == 0:
            return self._run_followed(inputs, outs, threads, check)
        rows = np.flatnonzero(codes)
        inputs_of_rows: dict[str, Array] = {}
        for name, array in inputs.items():
            inputs_of_rows[name] = array[rows] if array.ndim == 2 else array
        outs_of_rows = [out[rows] for out in outs]
        codes[rows] = self._run_followed(inputs_of_rows, outs_of_rows, threads, check=False)
        for out, replacement in zip(outs, outs_of_rows, strict=True):
            out[rows] = replacement
        return codes

    def _run_followed(
        self,
        inputs: dict[str, Array],
        outs: list[Array],
        threads: int,
        check: bool,
    ) -> Codes:
        """Followed from the reference in small steps."""
        state = self._closure.close(inputs["u"], check=check)
        return self._run(inputs | {"branch": state.signs, "guess": state.s}, outs, threads)

    # -- arguments

    def _checked_inputs(self, values: dict[str, Any]) -> dict[str, Array]:
        inputs: dict[str, Array] = {}
        rows: int | None = None
        for name, value in values.items():
            if name == "u":
                inputs[name] = self._state_input(name, value)
                rows = _rows(inputs[name])
            elif name in self._of_state:
                inputs[name] = self._state_input(name, value)
                _check_rows(name, inputs[name], inputs["u"])
            elif value is self._constants[name]:
                inputs[name] = value
            else:
                inputs[name] = self._checked_constant(name, value, rows)
        return inputs

    def _state_input(self, name: str, value: Any) -> Array:
        if self._is_batch(value):
            batch: Array = value
            return batch
        return finite_vectors(name, value, self._active)

    def _is_batch(self, value: object) -> bool:
        """Whether a value is a float64 batch, which the kernel itself checks for finite values."""
        if type(value) is not np.ndarray or value.dtype != np.float64:
            return False
        return value.ndim == 2 and value.shape[1] == len(self._active)

    def _checked_constant(
        self,
        name: str,
        value: ArrayLike,
        rows: int | None,
    ) -> Array:
        array = real_array(name, value)
        size = self._sizes[name]
        shapes: list[tuple[int, ...]] = [(size,)]
        if rows is not None:
            shapes.append((rows, size))
        if array.shape not in shapes:
            raise InputError(
                f"{name} has shape {array.shape}; expected ({size},), or one such row for each"
                " state"
            )
        if not np.isfinite(array).all():
            raise InputError(f"{name} holds values that are not finite: {array}")
        return array

    def _checked_outs(self, out: Any, rows: int | None) -> list[Array]:
        """The arrays for the results: new ones, or those of the caller, checked."""
        names = [name for name, _ in self._layout]
        shapes = [shape for _, shape in self._layout]
        if rows is not None:
            shapes = [(rows, *shape) for shape in shapes]
        if out is None:
            return [np.empty(shape) for shape in shapes]
        outs = _listed(out, names)
        for name, array, shape in zip(names, outs, shapes, strict=True):
            _check_out(name, array, shape)
        return outs

    # -- computation

    def _run(
        self,
        inputs: dict[str, Array],
        outs: list[Array],
        threads: int,
    ) -> Codes:
        arguments = [inputs[name] for name in self._names]
        return _run_kernel(self._kernels.at_guess, arguments, outs, threads)

    def _check_finite(self, inputs: dict[str, Array]) -> None:
        """Raise for inputs that `_is_batch` let through unchecked, even without `check`."""
        for name in self._of_state:
            finite_vectors(name, inputs[name], self._active)

    def _mark_failures(
        self,
        inputs: dict[str, Array],
        outs: list[Array],
        codes: Codes,
        check: bool,
    ) -> None:
        """Set rows without a result to NaN; with `check` raise the error of the first."""
        self._check_finite(inputs)
        for array in outs:
            array[codes != 0] = np.nan
        if check:
            self._raise_for_first(inputs, codes)

    def _raise_for_first(
        self,
        inputs: dict[str, Array],
        codes: Codes,
    ) -> None:
        """Raise for the first failed row, with the same error as the robot's own method."""
        u = inputs["u"]
        du = np.broadcast_to(inputs.get("du", 0.0), u.shape)
        # both are called for their errors; the last error is for cases that pass both
        state = self._closure.close(u, du)
        if self._explain is not None:
            others = [name for name in self._of_state if name not in ("u", "du")]
            self._explain(state, *[inputs[name] for name in others])
        place = ""
        if codes.ndim == 1:
            place = f" in row {int(np.flatnonzero(codes)[0])}"
        raise InputError(f"the result{place} is not finite: the input is too large to compute with")


def _run_kernel(
    kernel: Kernel,
    arguments: list[Array],
    outs: list[Array],
    threads: int,
) -> Codes:
    """Run a kernel on one state or rows, as its first argument is."""
    u = arguments[0]
    if u.ndim == 1:
        return np.array(kernel.fill_one(arguments, outs))
    codes = np.empty(len(u), dtype=np.int64)
    kernel.fill_rows(arguments, outs, codes, threads)
    return codes


def _rows(u: Array) -> int | None:
    """Number of states in a batch; None for a single state."""
    if u.ndim == 2:
        return len(u)
    return None


def _check_rows(name: str, array: Array, u: Array) -> None:
    """Raise if a batch has another number of rows than u."""
    if array.ndim == 2 and len(array) != _rows(u):
        raise InputError(
            f"{name} has shape {array.shape}; expected {u.shape} as u, or ({array.shape[1]},)"
            " for all"
        )


def _listed(out: Any, names: Sequence[str]) -> list[Any]:
    """The caller's arrays, one for each result; raise if their number is wrong."""
    if len(names) == 1:
        return [out]
    if not isinstance(out, (tuple, list)) or len(out) != len(names):
        expected = f"a tuple of {len(names)} arrays for {', '.join(names)}"
        raise InputError(f"out: expected {expected}")
    return list(out)


def _check_out(
    name: str,
    array: Any,
    shape: tuple[int, ...],
) -> None:
    """Raise if compiled code cannot fill an array."""
    is_float = type(array) is np.ndarray and array.dtype == np.float64
    if not is_float or array.shape != shape:
        kind = getattr(array, "dtype", type(array).__name__)
        raise InputError(
            f"out for {name}: is {kind} of shape {np.shape(array)}; expected float64 of shape"
            f" {shape}"
        )
    flags = array.flags
    if not (flags.c_contiguous and flags.aligned and flags.writeable):
        raise InputError(f"out for {name}: expected a writable array in C order")


def _apart(inputs: dict[str, Array], outs: list[Array]) -> dict[str, Array]:
    """The inputs, copied if they share memory with an output."""
    result = dict(inputs)
    for name, array in inputs.items():
        if any(np.may_share_memory(array, out) for out in outs):
            result[name] = array.copy()
    return result
