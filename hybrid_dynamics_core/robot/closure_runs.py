"""The closure kernels of a model as functions."""

from __future__ import annotations

import numpy as np

from .. import programs
from ..closed_state.closure_solver import ClosureResults, ClosureRuns
from ..closed_state.continuation import Start
from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..kernels.run import Codes, Kernel
from ..kernels.status import GOOD, JUMP, any_failed
from .kernel_store import KernelStore
from .state_builder import StateBuilder

_STEP = programs.CLOSE.from_start()
# all coordinates, and R row by row
Place = tuple[Array, Array]


def closure_runs(kernels: KernelStore, key: str, model: programs.Model) -> ClosureRuns:
    """The closure kernels of a model.

    Args:
        kernels: store of the kernels.
        key: key of this model among those of the robot.
        model: tree and closure plan.
    """

    def at(u: Array, du: Array, signs: Array, guess: Array) -> ClosureResults:
        inputs = {"u": u, "du": du, "branch": signs, "guess": guess}
        return kernels.run(key, programs.CLOSE, inputs, model)

    def step(u: Array, du: Array, signs: Array, start: Start) -> ClosureResults:
        inputs = {"u": u, "du": du, "branch": signs, **start_inputs(start)}
        return kernels.run(f"step of {key}", _STEP, inputs, model)

    def path(u: Array, signs: Array, start: Start) -> tuple[Start, Codes]:
        kernel = kernels.kernel(f"path of {key}", programs.STEP, model)
        n_s, n = start.velocity_map.shape
        s = np.empty((len(u), n_s))
        start_map = np.empty((len(u), n_s * n))
        codes = np.full(len(u), JUMP, dtype=np.int64)
        inputs = {"u": u, "branch": signs, **start_inputs(start)}
        kernel.fill_path([inputs[name] for name in programs.STEP.inputs], [s, start_map], codes)
        return Start(s, start_map.reshape(-1, n_s, n)), codes

    return ClosureRuns(at, step, path)


class QuickClosure:
    """Closure of one state, or along a motion, where compiled code alone is enough.

    Args:
        kernels: store of the kernels.
        states: builder of the closed states.
        signs: branch signs of the robot's own modes.
        start: the reference, where one move starts, or a guess (n_s,) for closed forms.
    """

    def __init__(
        self, kernels: KernelStore, states: StateBuilder, signs: Array, start: Start | Array
    ) -> None:
        self._kernels = kernels
        self._states = states
        self._n = len(kernels.model.active)
        self._loops = kernels.model.loops
        self._signs = signs
        self._reference: tuple[Array, ...]
        if isinstance(start, Start):
            self._reference = start.flat
        else:
            self._reference = (start,)

    def close(self, u: Array, du: object, near: ClosedState | None) -> ClosedState | None:
        """The closed state at u (n,) and du (n,) or None; None if other code has to decide."""
        if du is None:
            du = np.zeros(self._n)
        if near is None:
            kernel, signs, start = self._from_reference, self._signs, self._reference
        elif self._is_start(near):
            kernel, signs, start = self._step, near.signs, Start(near.s, near.R).flat
        else:
            return None
        outs = kernel.new_outs()
        # the code takes only finite arrays of the right type and shape
        if kernel.one(u, du, signs, *start, *outs) != GOOD:
            return None
        values = dict(zip(kernel.names, outs, strict=True))
        state = self._states.build_one(signs, values)
        if near is None:
            return state
        return self._states.on_modes_of(near, state)

    def _is_start(self, near: object) -> bool:
        """Whether a state is a closed one of this robot."""
        if type(near) is not ClosedState or near.u.ndim != 1 or near.status:
            return False
        return near.loops == self._loops

    def path(self, u: Array, signs: Array, start: Place) -> Place | None:
        """Close rows that each start from the previous one.

        Args:
            u: active coordinates (N, n) along the motion [rad, m], one row or more.
            signs: branch signs (blocks,).
            start: closed configuration before the first row.

        Returns:
            All coordinates (N, n_s), and R of the last row; None if a row needs other code.
        """
        s, start_map = start
        outs = [np.empty((len(u), len(s))), np.empty((len(u), len(start_map)))]
        codes = np.full(len(u), JUMP, dtype=np.int64)
        self._path.fill_path([u, signs, s, start_map], outs, codes)
        if any_failed(codes):
            return None
        return outs[0], outs[1][-1].copy()

    def from_one_start(self, u: Array, signs: Array, start: Place) -> tuple[Array, Array] | None:
        """Close rows in one move from the same start.

        Args:
            u: active coordinates (N, n) [rad, m].
            signs: branch signs (blocks,).
            start: closed configuration near all of them.

        Returns:
            All coordinates (1 + N, n_s) of the start and of the rows, and the changes to the next
            row that R predicts at each (1 + N, n_s). None if a row is too far.
        """
        s, start_map = start
        count, n = u.shape
        moves = np.empty((count + 1, n))
        np.subtract(u[0], s[:n], out=moves[0])
        np.subtract(u[1:], u[:-1], out=moves[1:-1])
        moves[-1] = 0.0
        places, forecasts = np.empty((2, count + 1, len(s)))
        places[0] = s
        forecasts[0] = start_map.reshape(len(s), n) @ moves[0]
        codes = np.empty(count, dtype=np.int64)
        inputs = [u, signs, s, start_map, moves[1:]]
        self._place.fill_rows(inputs, [places[1:], forecasts[1:]], codes)
        if any_failed(codes):
            return None
        return places, forecasts

    @lazy
    def _place(self) -> Kernel:
        return self._kernels.kernel("place of close", programs.PLACE)

    @lazy
    def _path(self) -> Kernel:
        return self._kernels.kernel("path of close", programs.STEP)

    @lazy
    def _from_reference(self) -> Kernel:
        if len(self._reference) > 1:
            return self._step
        return self._kernels.kernel("close", programs.CLOSE)

    @lazy
    def _step(self) -> Kernel:
        return self._kernels.kernel("step of close", _STEP)


def start_inputs(start: Start) -> dict[str, Array]:
    """A start as inputs of programs."""
    s, start_map = start.flat
    return {"start": s, "start_map": start_map}
