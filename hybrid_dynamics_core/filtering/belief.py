"""What is known of a machine at one time: closed state, accelerations, constant errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot
from .motion_model import ORDERS, MotionModel
from .sensors import Sensor

HALVINGS = 20  # of a step that leaves the reach of a loop
LEAST_BIAS = 1e-6  # of the noise: deviation of a constant error that is zero at first


@dataclass(frozen=True, eq=False)
class Belief:
    """Mean and covariance at one time.

    The error state is [u; u'; u''; constant errors of the sensors].

    Attributes:
        time: [s].
        state: closed state of the means of u and u'.
        ddu: (n,) mean of u'' [rad/s^2, m/s^2].
        bias: (m,) mean of the constant errors.
        covariance: (3 n + m, 3 n + m).
    """

    time: float
    state: ClosedState
    ddu: Array
    bias: Array
    covariance: Array

    @property
    def motion(self) -> Array:
        """Mean (3 n,) of [u; u'; u'']."""
        return np.concatenate([self.state.u, self.state.du, self.ddu])

    @property
    def rates_covariance(self) -> Array:
        """Covariance (n, n) of u'."""
        n = len(self.ddu)
        return self.covariance[n : 2 * n, n : 2 * n]

    def deviations(self) -> Array:
        """Deviation (3, n) of each active coordinate, its rate and its acceleration."""
        count = ORDERS * len(self.ddu)
        variances = np.diagonal(self.covariance)[:count]
        return np.sqrt(variances).reshape(ORDERS, -1)


class Layout:
    """Where the constant errors of each sensor are in the error state.

    Attributes:
        robot: the robot.
        sensors: the sensors by name.
        model: how the machine may move.
        size: length of the error state.
        prior: (m,) variances of the constant errors before anything is known.
        walk: (m,) growth of these variances [1/s].
    """

    def __init__(
        self,
        robot: Robot,
        sensors: Sequence[Sensor],
        model: MotionModel,
    ) -> None:
        """The places of the errors of sensors.

        Raises:
            InputError: two sensors have one name, there is none, one is of another robot object, or
                a ball or free joint is active.
        """
        self.robot = robot
        self.model = model
        self.sensors: dict[str, Sensor] = {}
        self._places: dict[str, slice] = {}
        self.motion_size = ORDERS * model.n
        self.size = self.motion_size
        prior: list[float] = []
        walk: list[float] = []
        if not sensors:
            raise InputError("sensors: there is none")
        if any(middle < model.n for middle in robot.middle_turns):
            raise InputError(
                "states of ball and free joints that are active are not estimated: their angles"
                " are singular at a quarter turn; use hinges, or a fixed base"
            )
        for sensor in sensors:
            if sensor.name in self.sensors:
                raise InputError(f"sensors: the name '{sensor.name}' is given twice")
            if sensor.robot is not robot:
                raise InputError(f"{sensor.name}: the sensor is of another robot object")
            self.sensors[sensor.name] = sensor
            if sensor.has_bias:
                end = self.size + sensor.channels
                self._places[sensor.name] = slice(self.size, end)
                self.size = end
                least = LEAST_BIAS * sensor.quality.noise
                variance = max(sensor.quality.bias, least) ** 2
                prior += [variance] * sensor.channels
                walk += [sensor.quality.walk**2] * sensor.channels
        self.prior = np.array(prior)
        self.walk = np.array(walk)

    def bias_of(
        self,
        sensor: Sensor,
        bias: Array,
    ) -> Array | float:
        """The constant errors (k,) of a sensor among all of them (m,)."""
        place = self._places.get(sensor.name)
        if place is None:
            return 0.0
        return bias[place.start - self.motion_size : place.stop - self.motion_size]

    def slopes(
        self,
        sensor: Sensor,
        along_motion: Array,
    ) -> Array:
        """Slopes (k, size) of the readings of a sensor along the error state."""
        slopes = np.zeros((sensor.channels, self.size))
        slopes[:, : self.motion_size] = along_motion
        place = self._places.get(sensor.name)
        if place is not None:
            slopes[:, place] = np.eye(sensor.channels)
        return slopes

    def bias_by_name(self, bias: Array) -> dict[str, Array]:
        """The constant errors (k,) by name of the sensor."""
        return {name: np.asarray(self.bias_of(self.sensors[name], bias)) for name in self._places}


def predicted(
    layout: Layout,
    belief: Belief,
    time: float,
) -> Belief:
    """The belief at a later time [s]."""
    step = time - belief.time
    if step == 0.0:
        return belief
    model = layout.model
    transition = model.transition(step)
    size = layout.motion_size
    covariance = belief.covariance.copy()
    covariance[:size] = transition @ covariance[:size]
    covariance[:, :size] = covariance[:, :size] @ transition.T
    covariance[:size, :size] += model.noise(step)
    of_bias = np.arange(size, layout.size)
    covariance[of_bias, of_bias] += layout.walk * step
    u, du, ddu = (transition @ belief.motion).reshape(ORDERS, -1)
    state = closed_near(layout.robot, u, du, belief.state)
    return Belief(time, state, ddu, belief.bias, covariance)


def moved(
    layout: Layout,
    belief: Belief,
    change: Array,
    covariance: Array,
) -> Belief:
    """The belief after a change (size,) of its mean."""
    size = layout.motion_size
    u, du, ddu = (belief.motion + change[:size]).reshape(ORDERS, -1)
    state = closed_near(layout.robot, u, du, belief.state)
    bias = belief.bias + change[size:]
    return replace(belief, state=state, ddu=ddu, bias=bias, covariance=covariance)


def closed_near(
    robot: Robot,
    u: Array,
    du: Array,
    near: ClosedState,
) -> ClosedState:
    """The closed state at u (n,), or as far towards it as the loops close."""
    share = 1.0
    for _ in range(HALVINGS):
        towards = near.u + share * (u - near.u)
        state = robot.close(towards, du, check=False, near=near)
        if state.status is ClosureStatus.OK:
            return state
        share /= 2.0
    state = robot.close(near.u, du, check=False, near=near)
    return state if math.isfinite(float(state.s.sum())) else near
