"""The slope of a motion near a closed state, for integrators in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ...closed_state.state import ClosedState
from ...ground.arrays import Array
from ...kernels.run import Kernel
from ...kernels.status import GOOD, MASS_SINGULAR

# (u, u', tau) -> raises the error of a singular mass matrix
Explain = Callable[[Array, Array, Array], None]


class MotionNear:
    """A function (u, u', tau) -> (u'', power [W]) of vectors (n,), near a state.

    Args:
        kernel: compiled program of `programs.motion`.
        names: names of its inputs, in order.
        constants: values of all inputs but those of a state.
        state: closed state to follow from.
        explain: raises the error of a state without accelerations.
    """

    def __init__(
        self,
        kernel: Kernel,
        names: Sequence[str],
        constants: Mapping[str, Array],
        state: ClosedState,
        explain: Explain,
    ) -> None:
        self._kernel = kernel
        self._names = names
        self._constants = {**constants, "branch": state.signs}
        self._state = state
        self._explain = explain

    def __call__(self, u: Array, du: Array, tau: Array) -> tuple[Array, float]:
        """u'' and the power; NaN if the loops do not close.

        Raises:
            MassSingularityError: the mass matrix is singular.
        """
        state = self._state
        guess = state.s + state.R @ (u - state.u)
        inputs = {**self._constants, "u": u, "du": du, "tau": tau, "guess": guess}
        ddu, power = outs = self._kernel.new_outs()
        code = self._kernel.fill_one([inputs[name] for name in self._names], outs)
        if code == GOOD:
            return ddu, float(power)
        if code == MASS_SINGULAR:
            self._explain(u, du, tau)
        return np.full_like(u, np.nan), np.nan
