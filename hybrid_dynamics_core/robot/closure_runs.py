"""The closure kernels of a model as functions."""

from __future__ import annotations

import numpy as np

from .. import programs
from ..closed_state.closure_solver import ClosureResults, ClosureRuns
from ..closed_state.continuation import Start
from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import JUMP
from .kernel_store import KernelStore

_STEP = programs.CLOSE.from_start()


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


def start_inputs(start: Start) -> dict[str, Array]:
    """A start as inputs of programs."""
    s, velocity_map = start
    return {"start": s, "start_map": velocity_map.reshape(*s.shape[:-1], -1)}
