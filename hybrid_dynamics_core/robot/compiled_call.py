"""One fused call: its fast way straight into compiled code, and the thorough one that says what is wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .. import programs
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import finite_vectors, real_array
from ..kernels.caller import Signature, make_caller
from ..kernels.run import Codes

if TYPE_CHECKING:
    from .robot import Robot

OF_A_STATE = (
    "u",
    "du",
    "ddu",
    "tau",
)  # inputs that belong to a state; a program's other inputs are the robot's own
Explain = Callable[..., object]  # (closed state, inputs of a state) -> raises what is wrong with it


class CompiledCall:
    """A program of a robot as one function of arrays.

    `own`: the robot's values of inputs that do not belong to a state; `optional`: inputs of a state
    that are zero where left out; `explain`: raises what is wrong with a state that closes, but has
    no answer.
    """

    def __init__(
        self,
        robot: Robot,
        key: str,
        program: programs.Program,
        own: Mapping[str, Array],
        optional: Sequence[str] = (),
        explain: Explain | None = None,
    ) -> None:
        self._robot, self._explain = robot, explain
        self._kernel = robot.kernel(key, program)
        self._inputs = program.inputs
        self._sizes = dict(zip(program.inputs, self._kernel.facts["inputs"], strict=True))
        self._given = [name for name in program.inputs if name in OF_A_STATE]
        self._optional = {name: frozen(np.zeros(self._sizes[name])) for name in optional}
        self._own = {name: own[name] for name in program.inputs if name not in OF_A_STATE}

    def caller(self) -> Callable[..., Any]:
        """The function (given inputs, out=None, *, check=True, threads=1, other inputs) -> results."""
        signature = Signature(
            inputs=self._inputs,
            given=self._given,
            values=self._own,
            shapes=[shape for _, shape in self._kernel.layout],
            optional=self._optional,
            follows="guess" if self._kernel.facts["iterates"] else None,
        )
        return make_caller(signature, self._kernel.one, self._thorough)

    def _thorough(self, values: dict[str, Any], out: Any, check: bool, threads: Any) -> Any:
        """Batches, arrays of other kinds, loops that are followed, and everything that is to be refused."""
        if not isinstance(threads, int) or threads < 1:
            raise InputError(f"threads is {threads!r}; expected 1 or more")
        inputs = self._checked_inputs(values)
        rows = len(inputs["u"]) if inputs["u"].ndim == 2 else None
        outs = self._checked_outs(out, rows)
        inputs = {
            name: a.copy() if any(_overlap(a, o) for o in outs) else a for name, a in inputs.items()
        }
        if self._kernel.facts["iterates"] and values["guess"] is self._own["guess"]:
            state = self._robot.close(inputs["u"], check=check)
            inputs |= {"branch": state.signs, "guess": state.s}
        codes = self._run(inputs, outs, threads)
        if codes.any():
            for name in self._given:
                finite_vectors(name, inputs[name], self._robot.active)
            for array in outs:
                array[codes != 0] = np.nan
            if check:
                self._refuse(inputs, codes)
        return outs[0] if len(outs) == 1 else tuple(outs)

    def _checked_inputs(self, values: dict[str, Any]) -> dict[str, Array]:
        inputs: dict[str, Array] = {}
        rows: int | None = None
        for name, value in values.items():
            if name in self._given:
                inputs[name] = (
                    value
                    if self._is_batch(value)
                    else finite_vectors(name, value, self._robot.active)
                )
                shape = inputs[name].shape
                if name == "u":
                    rows = shape[0] if len(shape) == 2 else None
                elif len(shape) == 2 and shape[0] != rows:
                    expected = inputs["u"].shape
                    raise InputError(
                        f"{name} has shape {shape}; expected {expected} as u, or ({shape[1]},)"
                        " for all"
                    )
            elif value is self._own[name]:
                inputs[name] = value
            else:
                inputs[name] = self._checked_parameter(name, value, rows)
        return inputs

    def _is_batch(self, value: object) -> bool:
        """Whether nothing has to be converted; that all is finite the kernel finds out itself."""
        if type(value) is not np.ndarray or value.dtype != np.float64:
            return False
        return value.ndim == 2 and value.shape[1] == len(self._robot.active)

    def _checked_parameter(self, name: str, value: ArrayLike, rows: int | None) -> Array:
        array = real_array(name, value)
        size = self._sizes[name]
        if array.shape != (size,) and (rows is None or array.shape != (rows, size)):
            raise InputError(
                f"{name} has shape {array.shape}; expected ({size},), or one such row for each"
                " state"
            )
        if not np.isfinite(array).all():
            raise InputError(f"{name} holds values that are not finite: {array}")
        return array

    def _checked_outs(self, out: Any, rows: int | None) -> list[Array]:
        shapes = [shape if rows is None else (rows, *shape) for _, shape in self._kernel.layout]
        if out is None:
            return [np.empty(shape) for shape in shapes]
        outs = [out] if len(shapes) == 1 else list(out) if isinstance(out, (tuple, list)) else []
        if len(outs) != len(shapes):
            names = ", ".join(name for name, _ in self._kernel.layout)
            raise InputError(f"out: expected a tuple of {len(shapes)} arrays for {names}")
        for (name, _), array, shape in zip(self._kernel.layout, outs, shapes, strict=True):
            if type(array) is not np.ndarray or array.dtype != np.float64 or array.shape != shape:
                told = f"{getattr(array, 'dtype', type(array).__name__)} of shape {np.shape(array)}"
                raise InputError(f"out for {name}: is {told}; expected float64 of shape {shape}")
            if not (array.flags.c_contiguous and array.flags.aligned and array.flags.writeable):
                raise InputError(f"out for {name}: expected a writable array in C order")
        return outs

    def _run(self, inputs: dict[str, Array], outs: list[Array], threads: int) -> Codes:
        arguments = [inputs[name] for name in self._inputs]
        if inputs["u"].ndim == 1:
            return np.array(self._kernel.fill_one(arguments, outs))
        codes = np.empty(len(inputs["u"]), dtype=np.int64)
        self._kernel.fill_rows(arguments, outs, codes, threads)
        return codes

    def _refuse(self, inputs: dict[str, Array], codes: Codes) -> None:
        """Raise for the first row without an answer, as the thorough calls of the robot do."""
        du = np.broadcast_to(inputs.get("du", 0.0), inputs["u"].shape)
        state = self._robot.close(inputs["u"], du)
        if self._explain is not None:
            self._explain(state, *(inputs[name] for name in self._given if name not in ("u", "du")))
        place = "" if codes.ndim == 0 else f" in row {int(np.flatnonzero(codes)[0])}"
        raise InputError(f"the result{place} is not finite: the input is too large to compute with")


def _overlap(a: Array, b: Array) -> bool:
    """Whether writing b could change what is still to be read of a."""
    return bool(np.may_share_memory(a, b))
