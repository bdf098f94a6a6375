"""One compiled call: a quick way straight into compiled code, and a thorough one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import finite_vectors, real_array
from ..kernels.caller import Signature, make_caller
from ..kernels.run import Codes, Kernel
from ..programs import Program
from .closure import Closure

# inputs that belong to a state; the other inputs of a program are constants of the robot
STATE_INPUTS = ("u", "du", "ddu", "tau")
# (closed state, inputs of a state) -> raises what is wrong with it
Explain = Callable[..., object]


class CompiledCall:
    """A program of a robot as one function of arrays.

    Args:
        kernel: the compiled program.
        program: names its inputs.
        closure: closes loops without a closed form, and explains states that do not close.
        constants: the robot's values of all inputs that do not belong to a state.
        optional: inputs of a state that are zero where they are left out.
        explain: raises what is wrong with a state that closes, but has no answer.
    """

    def __init__(
        self,
        kernel: Kernel,
        program: Program,
        closure: Closure,
        constants: Mapping[str, Array],
        optional: Sequence[str] = (),
        explain: Explain | None = None,
    ) -> None:
        self._kernel = kernel
        self._closure = closure
        self._active = closure.model.active
        self._explain = explain
        self._names = program.inputs
        sizes = kernel.facts["inputs"]
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
        """The function: inputs of a state, out, check, threads, other inputs -> results."""
        signature = Signature(
            inputs=self._names,
            given=self._of_state,
            values=self._constants,
            shapes=[shape for _, shape in self._kernel.layout],
            optional=self._optional,
            follows="guess" if self._kernel.facts["iterates"] else None,
        )
        return make_caller(signature, self._kernel.one, self._call_thoroughly)

    def _call_thoroughly(
        self,
        values: dict[str, Any],
        out: Any,
        check: bool,
        threads: Any,
    ) -> Any:
        """Batches, arrays of other kinds, loops that are followed, and all that is an error."""
        if not isinstance(threads, int) or threads < 1:
            raise InputError(f"threads is {threads!r}; expected 1 or more")
        inputs = self._checked_inputs(values)
        outs = self._checked_outs(out, _rows(inputs["u"]))
        inputs = _apart(inputs, outs)
        # the very object of the constants: the caller gave no guess
        is_reference = values["guess"] is self._constants["guess"]
        if is_reference and self._kernel.facts["iterates"]:
            state = self._closure.close(inputs["u"], check=check)
            inputs |= {"branch": state.signs, "guess": state.s}
        codes = self._run(inputs, outs, threads)
        if codes.any():
            self._mark_failures(inputs, outs, codes, check)
        if len(outs) == 1:
            return outs[0]
        return tuple(outs)

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
        """Whether a value needs no conversion. The kernel finds out itself whether it is finite."""
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
        """The arrays for the results: new ones, or those of the caller."""
        names = [name for name, _ in self._kernel.layout]
        shapes = [shape for _, shape in self._kernel.layout]
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
        if inputs["u"].ndim == 1:
            return np.array(self._kernel.fill_one(arguments, outs))
        codes = np.empty(len(inputs["u"]), dtype=np.int64)
        self._kernel.fill_rows(arguments, outs, codes, threads)
        return codes

    def _mark_failures(
        self,
        inputs: dict[str, Array],
        outs: list[Array],
        codes: Codes,
        check: bool,
    ) -> None:
        """NaN in rows without an answer; with `check` an error for the first of them."""
        # `_is_batch` let these through unchecked; this raises even without `check`
        for name in self._of_state:
            finite_vectors(name, inputs[name], self._active)
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
        # both are called for what they raise; the last error is for what passes them
        state = self._closure.close(u, du)
        if self._explain is not None:
            others = [name for name in self._of_state if name not in ("u", "du")]
            self._explain(state, *[inputs[name] for name in others])
        place = ""
        if codes.ndim == 1:
            place = f" in row {int(np.flatnonzero(codes)[0])}"
        raise InputError(f"the result{place} is not finite: the input is too large to compute with")


def _rows(u: Array) -> int | None:
    """Number of states in a batch, None for a single state."""
    if u.ndim == 2:
        return len(u)
    return None


def _check_rows(name: str, array: Array, u: Array) -> None:
    """Raise where a batch has another number of rows than u."""
    if array.ndim == 2 and len(array) != _rows(u):
        raise InputError(
            f"{name} has shape {array.shape}; expected {u.shape} as u, or ({array.shape[1]},)"
            " for all"
        )


def _listed(out: Any, names: Sequence[str]) -> list[Any]:
    """The caller's arrays, one for each result; raise where there are more or fewer."""
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
    """Raise where an array cannot be filled by compiled code."""
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
    """The inputs, copied where writing an output could change what is still to be read."""
    result = dict(inputs)
    for name, array in inputs.items():
        if any(np.may_share_memory(array, out) for out in outs):
            result[name] = array.copy()
    return result
