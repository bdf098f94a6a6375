"""Momentum observer: external efforts from measured efforts and rates, without accelerations.

De Luca and Mattone (2003); Haddadin, De Luca and Albu-Schaeffer (2017). The generalised momentum
is p = M-bar u'. C-bar of Chu (2020) is that of Christoffel symbols, so M-bar' = C-bar + C-bar^T and

    p' = tau + C-bar^T u' - G-bar - f + tau_ext,

with efforts f of friction, springs and wrenches. The residual r follows tau_ext as a low-pass
filter of first order does, r' = 2 pi cutoff (tau_ext - r), or of second order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number, require_type
from ..ground.check_arrays import finite_vectors, real_array
from ..robot.robot import Robot

CUTOFF = 5.0  # [Hz]
MAX_GAP = 0.5  # [s]
SPACING = 0.5  # of residuals that are compared, in periods of the cutoff
FIRST = 5  # comparisons that show the noise
MEMORY = 0.03  # share of the newest comparison in the noise
LARGEST = 2.5  # deviations up to which a comparison counts


class Residuals(NamedTuple):
    """Residuals of N samples.

    Attributes:
        values: (N, n) external efforts along the active coordinates [N m, N].
        noise: (N, n, n) covariance of their noise, by how much they change within a period.
        is_ready: (N,) whether the samples since the start show the noise.
    """

    values: Array
    noise: Array
    is_ready: NDArray[np.bool_]


class MomentumObserver:
    """External efforts along the active coordinates, sample by sample or on arrays.

    Between samples the efforts are taken as linear, and the filter is solved exactly. So any
    distance of samples is stable. At first the filter averages all samples: nothing pulls to zero.
    Order 1 is the observer of the literature. Order 2 follows efforts that rise evenly without lag.

    Attributes:
        robot: the model.
        cutoff: bandwidth of the residual [Hz].
        order: 1, or 2 without lag.
        max_gap: time between samples [s] beyond which the observer starts anew.
        loads: loads that the model assumes; `robot.loads` if None.
        residual: (n,) the newest external efforts [N m, N]; zero until two samples are known.
        noise: (n, n) covariance of its noise, by how much it changes within a period.

    Raises:
        InputError: the cutoff or the gap is not above zero, or the order is not 1 or 2.
    """

    def __init__(
        self,
        robot: Robot,
        cutoff: float = CUTOFF,
        order: int = 1,
        max_gap: float = MAX_GAP,
        loads: Loads | None = None,
    ) -> None:
        require_type("robot", robot, Robot, "load(...)")
        self.cutoff = _positive("cutoff", cutoff)
        if order not in {1, 2}:
            raise InputError(f"order is {order}; expected 1 or 2")
        self.order = order
        self.max_gap = _positive("max_gap", max_gap)
        self.robot = robot
        self.loads = loads
        self.reset()

    def reset(self) -> None:
        """Start anew, without samples."""
        n = len(self.robot.active)
        self._time = -np.inf
        self._momentum = np.zeros(n)
        self._rate = np.zeros(n)
        self._restart()

    def _restart(self) -> None:
        n = len(self.robot.active)
        self.residual = np.zeros(n)
        self.noise = np.zeros((n, n))
        self._value = np.zeros(n)  # in the middle of the newest interval
        self._slope = np.zeros(n)  # [N m/s, N/s]
        self._count = 0  # intervals since the start
        self._step = 0.0  # [s] the newest interval
        self._compared = (-np.inf, np.zeros(n))  # time and residual
        self._comparisons = 0

    @property
    def is_ready(self) -> bool:
        """Whether the samples since the start show the noise."""
        return self._comparisons >= FIRST

    def step(self, time: float, state: ClosedState, tau: ArrayLike) -> Array:
        """The residual (n,) [N m, N] after one more sample.

        Args:
            time: [s], later than that of the sample before.
            state: closed state with rates.
            tau: (n,) measured efforts along the active coordinates [N m, N].

        Raises:
            InputError: the clock does not rise, or an effort is not finite.
        """
        require_type("state", state, ClosedState, "robot.close(u, du)")
        efforts = finite_vectors("tau", tau, self.robot.active, -1)
        residuals = self.run([time], ClosedState.joined([state]), efforts[None])
        return np.asarray(residuals.values[0])

    def run(self, time: ArrayLike, state: ClosedState, tau: ArrayLike) -> Residuals:
        """Residuals of N more samples; equal to `step` bit by bit.

        Args:
            time: (N,) [s], rising, later than that of the sample before.
            state: closed states with rates, a batch of N.
            tau: (N, n) measured efforts along the active coordinates [N m, N].

        Raises:
            InputError: the clock does not rise, or an effort is not finite.
        """
        stamps = real_array("time", time)
        require_type("state", state, ClosedState, "robot.close(u, du)")
        self._check(stamps)
        efforts = finite_vectors("tau", tau, self.robot.active, len(stamps))
        momentum, rate = balance(self.robot, state, efforts, self.loads)
        values = np.zeros_like(efforts)
        noise = np.zeros((*values.shape, values.shape[1]))
        is_ready = np.zeros(len(stamps), dtype=bool)
        for k, stamp in enumerate(stamps.tolist()):
            self._advance(stamp, momentum[k], rate[k])
            values[k], noise[k] = self.residual, self.noise
            is_ready[k] = self.is_ready
        return Residuals(values, noise, is_ready)

    def _advance(self, time: float, momentum: Array, rate: Array) -> None:
        """Take one sample.

        Args:
            time: [s].
            momentum: (n,) M-bar u'.
            rate: (n,) its rate without external efforts.
        """
        step = time - self._time
        if step > self.max_gap:
            self._restart()
        else:
            expected = 0.5 * step * (rate + self._rate)
            mean = (momentum - self._momentum - expected) / step
            self._filter(time, step, mean)
        self._time, self._momentum, self._rate = time, momentum, rate

    def _filter(self, time: float, step: float, mean: Array) -> None:
        """Take the mean external effort (n,) over an interval [s] up to a time [s]."""
        self._count += 1
        gain, slope_gain = self._gains(step)
        distance = 0.5 * (self._step + step)  # of the middles of two intervals
        expected = self._value + distance * self._slope
        change = mean - expected
        self._value = expected + gain * change
        self._slope = self._slope + slope_gain / distance * change
        self._step = step
        self.residual = self._value + 0.5 * step * self._slope
        before, residual = self._compared
        if not np.isfinite(before):
            self._compared = (time, self.residual)
        elif time - before >= SPACING / self.cutoff:
            self._note(self.residual - residual)
            self._compared = (time, self.residual)

    def _gains(self, step: float) -> tuple[float, float]:
        """Gains of value and slope after a step [s]: those of the filter, and first of a mean."""
        n = self._count
        decay = float(np.exp(-2.0 * np.pi * self.cutoff * step))
        if self.order == 1:
            return max(1.0 - decay, 1.0 / n), 0.0
        if n == 1:
            return 1.0, 0.0
        gain = max(1.0 - decay**2, 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)))
        return gain, max((1.0 - decay) ** 2, 6.0 / (n * (n + 1.0)))

    def _note(self, change: Array) -> None:
        """Take the difference (n,) of two residuals: of independent ones, twice the noise.

        A change that is no noise, as that of a contact, counts up to a limit.
        """
        self._comparisons += 1
        square = 0.5 * change[:, None] * change
        if self._comparisons > FIRST:
            usual = LARGEST**2 * np.diagonal(self.noise)
            ratio = np.diagonal(square) / np.maximum(usual, 1e-300)
            square = square / max(1.0, float(ratio.max()))
        share = max(1.0 / self._comparisons, MEMORY)
        self.noise = self.noise + share * (square - self.noise)

    def _check(self, time: Array) -> None:
        """Raise InputError for times (N,) that do not rise."""
        if time.ndim != 1 or not np.isfinite(time).all():
            raise InputError(f"time has shape {time.shape}; expected (N,) finite numbers")
        before = np.concatenate([[self._time], time[:-1]])
        back = np.flatnonzero(time <= before)
        if len(back):
            k = int(back[0])
            raise InputError(
                f"time: the clock goes from {before[k]:g} s to {time[k]:g} s; expected times that"
                " rise, or a reset of the observer"
            )


def balance(
    robot: Robot, state: ClosedState, tau: Array, loads: Loads | None = None
) -> tuple[Array, Array]:
    """Generalised momentum, and its rate without external efforts.

    Args:
        robot: the model.
        state: closed states with rates, a batch of N.
        tau: (N, n) efforts along the active coordinates [N m, N].
        loads: loads besides the actuators; `robot.loads` if None.

    Returns:
        p = M-bar u' (N, n), and tau + C-bar^T u' - G-bar - f (N, n).
    """
    mass, _, weight = robot.minimal_form(state, loads)
    coriolis = robot.coriolis_matrix(state, loads)
    passive = robot.passive_forces(state, loads)
    momentum = _product(mass, state.du)
    turning = _product(np.swapaxes(coriolis, -1, -2), state.du)
    return momentum, tau + turning - weight - passive


def _product(matrix: Array, vector: Array) -> Array:
    """Products (N, n) of matrices (N, n, n) and vectors (N, n), always summed in one order."""
    total = np.zeros_like(vector)
    for k in range(vector.shape[-1]):
        total = total + matrix[..., k] * vector[..., k : k + 1]
    return total


def _positive(name: str, value: float) -> float:
    """A finite number above zero; raises InputError."""
    number = real_number(name, value)
    if not 0.0 < number < np.inf:
        raise InputError(f"{name} is {number:g}; expected a finite number above zero")
    return number
