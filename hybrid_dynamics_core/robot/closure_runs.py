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
from ..kernels.status import GOOD, JUMP
from .kernel_store import KernelStore
from .state_builder import StateBuilder

_STEP = programs.CLOSE.from_start()
# rows of a motion at a time: their R stay in the cache
PATH_ROWS = 128


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
            self._reference = (start.s, start.velocity_map.reshape(-1))
        else:
            self._reference = (start,)

    def close(self, u: Array, du: object, near: ClosedState | None) -> ClosedState | None:
        """The closed state at u (n,) and du (n,) or None; None if other code has to decide."""
        if du is None:
            du = np.zeros(self._n)
        if near is None:
            kernel, signs, start = self._from_reference, self._signs, self._reference
        elif self._is_start(near):
            kernel, signs, start = self._step, near.signs, (near.s, near.R.reshape(-1))
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

    def path(
        self, u: Array, signs: Array, start: Array, start_map: Array
    ) -> tuple[Array, Array] | None:
        """Close rows (N, n) that each start from the previous one.

        Args:
            u: active coordinates (N, n) along the motion [rad, m], one row or more.
            signs: branch signs (blocks,).
            start: closed configuration (n_s,) before the first row [rad, m].
            start_map: R there, row by row (n_s * n,).

        Returns:
            All coordinates (N, n_s), and R of the last row; None if a row needs other code.
        """
        s = np.empty((len(u), len(start)))
        longest = min(len(u), PATH_ROWS)
        maps = np.empty((longest, len(start_map)))
        codes = np.zeros(longest, dtype=np.int64)
        for first in range(0, len(u), PATH_ROWS):
            part = u[first : first + PATH_ROWS]
            count = len(part)
            outs = [s[first : first + count], maps[:count]]
            self._path.fill_path([part, signs, start, start_map], outs, codes[:count])
            if codes[:count].any():
                return None
            start, start_map = s[first + count - 1], maps[count - 1].copy()
        return s, start_map

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
    s, velocity_map = start
    return {"start": s, "start_map": velocity_map.reshape(*s.shape[:-1], -1)}
