"""Steps of DOP853 in compiled code, along a motion under constant efforts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...closed_state.state import ClosedState
from ...ground.arrays import Array
from ...kernels.ir.steps import DEGREES, LAST, STAGES, Control, Tableau
from ...kernels.run import Kernel

# inputs of the program that each stage sets
OF_STAGE = ("u", "du", "guess")
EFFORTS = "tau"


class Steps(NamedTuple):
    """K steps of an integrator, each from one closed configuration to the next.

    The state is y = (u, u', work) with m = 2 n + 1 numbers.

    Attributes:
        times: (K + 1,), the start and the ends of the steps [s].
        y: (K + 1, m), there.
        dense: (K, 7, m), numbers of dense output.
        s: (K + 1, n_s), the closed configurations there.
        R: (K + 1, n_s, n), R there.
        following: the next step that the error allows [s].
        evaluations: number of evaluations of the motion.
    """

    times: Array
    y: Array
    dense: Array
    s: Array
    R: Array
    following: float
    evaluations: int

    @property
    def number(self) -> int:
        """K."""
        return len(self.dense)

    def at(self, steps: NDArray[np.int64], times: Array) -> Array:
        """The states (N, m) at times (N,) within steps (N,), by dense output."""
        lengths = np.diff(self.times)
        share = ((times - self.times[steps]) / lengths[steps])[:, None]
        dense = self.dense[steps]
        total = np.zeros_like(dense[:, 0])
        for degree in reversed(range(DEGREES)):
            is_even = (DEGREES - 1 - degree) % 2 == 0
            factor = share if is_even else 1.0 - share
            total = (total + dense[:, degree]) * factor
        return np.asarray(total + self.y[steps])


class StepControl(NamedTuple):
    """Lengths of steps.

    Attributes:
        first: the first step to try [s].
        longest: the longest step [s].
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step [rad, m, rad/s, m/s, J].
        largest_move: of an angle in a step, by its rate at the start [rad].
    """

    first: float
    longest: float
    rtol: float
    atol: float
    largest_move: float


class MotionSteps:
    """The integrator of a robot under loads.

    Args:
        kernel: compiled program of `programs.motion_and_configuration`.
        inputs: names of its inputs, in order.
        constants: values of all inputs but those of a state, tau and the branch.
        angles: (n_s,) 1 for angles, 0 for lengths.
    """

    def __init__(
        self,
        kernel: Kernel,
        inputs: tuple[str, ...],
        constants: Mapping[str, Array],
        angles: Array,
    ) -> None:
        self._kernel = kernel
        self._fixed = [name for name in inputs if name not in OF_STAGE]
        self._constants = dict(constants)
        self._angles = angles
        self._tableau = _tableau()

    def advance(
        self,
        start: ClosedState,
        y: Array,
        tau: Array,
        span: tuple[float, float],
        control: StepControl,
        most: int,
    ) -> Steps:
        """Integrate until the end of a span, or for a number of steps.

        Args:
            start: closed state at y.
            y: (m,) start.
            tau: constant efforts (n,) [N m, N].
            span: start and end [s].
            control: lengths of steps.
            most: largest number of steps.

        Returns:
            The steps; fewer if a state on the way has no answer.
        """
        n, all_coordinates = len(start.u), len(start.s)
        numbers = np.zeros(Control.SIZE)
        numbers[Control.TIME : Control.STEP] = span
        numbers[Control.STEP : Control.COUNT] = control
        times = np.empty(most + 1)
        rows = np.empty((most + 1, len(y)))
        s = np.empty((most + 1, all_coordinates))
        maps = np.empty((most + 1, all_coordinates * n))
        dense = np.empty((most, DEGREES, len(y)))
        times[0], rows[0], s[0], maps[0] = span[0], y, start.s, start.R.reshape(-1)
        named = {**self._constants, EFFORTS: tau, "branch": start.signs}
        fixed = [np.ascontiguousarray(named[name], np.float64) for name in self._fixed]
        outs = [times[1:], rows[1:], dense, s[1:], maps[1:]]
        state = [rows[0], s[0], maps[0]]
        self._kernel.steps(numbers, self._tableau, self._angles, *state, *fixed, *outs)
        done = int(numbers[Control.COUNT])
        return Steps(
            times[: done + 1],
            rows[: done + 1],
            dense[:done],
            s[: done + 1],
            maps[: done + 1].reshape(done + 1, all_coordinates, n),
            float(numbers[Control.STEP]),
            int(numbers[Control.EVALUATIONS]),
        )


@cache
def _tableau() -> Array:
    """The numbers of DOP853, Hairer et al. (1993), as SciPy has them."""
    from scipy.integrate import DOP853  # noqa: PLC0415  most users integrate nothing

    numbers = np.zeros(Tableau.SIZE)
    coefficients = numbers[: Tableau.FIFTH].reshape(STAGES, STAGES)
    coefficients[:LAST, :LAST] = DOP853.A
    coefficients[LAST, :LAST] = DOP853.B
    coefficients[LAST + 1 :] = DOP853.A_EXTRA
    numbers[Tableau.FIFTH : Tableau.THIRD] = DOP853.E5
    numbers[Tableau.THIRD : Tableau.DENSE] = DOP853.E3
    numbers[Tableau.DENSE :] = DOP853.D.ravel()
    return numbers
