"""Recursion of filter steps over rows of samples, in compiled code or in Python.

Both run the same formulas, and give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.kernels import native
from hybrid_dynamics_core.kernels.run import default_backend

from .compile_steps import compiled
from .scalars import Scalars
from .steps import Steps

FloatArray = NDArray[np.float64]

# Arguments are float64 arrays in C order: intervals (N,) [s], samples (N, channels, n), constants,
# memory (changed in place), derivatives (D, n) before the first row. Outputs: derivatives (N, D, n)
# after each row, and the last number of the memory (N,). The result is 0, or
# `kernels.status.NOT_TAKEN` for other arrays.
Advance = Callable[
    [FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray], int
]


@cache
def advance_of(steps: Steps) -> Advance:
    """The function that runs a filter over rows."""
    if default_backend() == native.NAME:
        return compiled(steps)
    return partial(run_in_python, steps)


def run_in_python(steps: Steps, *arrays: FloatArray) -> int:
    """Run an `Advance` in Python; arguments after `steps` are its arrays."""
    intervals, samples, constants, memory, before, fitted, quality = arrays
    numbers, shared, joints = constants.tolist(), memory.tolist(), list(before)
    last: tuple[list[float], float] | None = None
    after: Scalars = ()
    gains: Scalars = ()
    with np.errstate(all="ignore"):
        for row, dt in enumerate(intervals.tolist()):
            if last != (shared, dt):  # gains are reused once the memory is steady
                last = shared, dt
                after, gains = steps.update(numbers, shared, dt)
            shared, joints = list(after), list(steps.correct(joints, dt, gains, samples[row]))
            for order, values in enumerate(joints):
                fitted[row, order] = values
            quality[row] = shared[-1]
    memory[:] = shared
    return 0
