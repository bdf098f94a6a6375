"""The first belief: the most likely state that explains the first reading of each sensor."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import StateError
from ..estimation.sensors import SensorError
from ..ground.arrays import Array
from ..robot.robot import Robot
from .belief import Belief, Layout, closed_near, moved
from .gate import GATE, chi_squared
from .second_order import second_order
from .sensors import AT_JOINTS, Kind, Sensor

SEARCHES = 6  # starts besides the reference
STEPS = 30  # of a search at each precision
SHARPER = (1e-4, 1e-3, 1e-2, 0.1, 1.0)  # shares of the precision of sensors, one after another
RATES_ALONE = (Kind.GYRO, Kind.RATE)
ENOUGH = (1.0, 0.1)  # shares of precision that a start may have, later readings do the rest
DONE = 1e-6  # relative change of the cost at which a search ends
OPEN_ANGLE = 3.0  # [rad] deviation of an angle without limits before anything is known
OPEN_LENGTH = 3.0  # [m] of a position without limits
RATES = 3.0  # correlation times of the largest acceleration that a rate may have
SHARE = 0.9  # of each range in which further searches start
INSIDE = 1e-3  # share of a range that a search keeps away from its ends


class Reading(NamedTuple):
    """One reading of a sensor.

    Attributes:
        time: its stamp [s].
        sensor: name of the sensor.
        values: (k,) in the unit of the sensor.
    """

    time: float
    sensor: str
    values: Array


@dataclass(frozen=True, eq=False)
class _Fit:
    """A point of the search: belief, information, and the cost with its parts by sensor."""

    belief: Belief
    gradient: Array
    information: Array
    cost: float
    misfits: Mapping[str, float]


def first_belief(
    layout: Layout,
    readings: Sequence[Reading],
    initial: Array | None = None,
    searches: int = SEARCHES,
) -> Belief:
    """The belief at the time of the last of the first readings.

    Args:
        layout: places of the error state.
        readings: one reading of each sensor.
        initial: active coordinates (n,) near which to search; None: from the reference on.
        searches: number of further places to search from.

    Raises:
        SensorError: no state explains the readings.
    """
    time = max(reading.time for reading in readings)
    search = _Search(layout, time, readings)
    freedoms = sum(layout.sensors[reading.sensor].channels for reading in readings)
    limit = chi_squared(GATE, freedoms)
    best: dict[float, _Fit] = {}
    for state in _starts(layout, initial, searches):
        for share, fit in search.run(state, limit).items():
            if share not in best or fit.cost < best[share].cost:
                best[share] = fit
        if best[1.0].cost <= limit:
            break
    for share in ENOUGH:
        if best[share].cost <= limit:
            return search.settled(best[share])
    raise SensorError(_contradiction(layout, best[1.0]))


def _starts(
    layout: Layout,
    initial: Array | None,
    searches: int,
) -> Iterator[ClosedState]:
    """Closed states to search from: at rest first, then with random rates."""
    robot, model = layout.robot, layout.model
    first = robot.close(robot.reference if initial is None else initial)
    yield first
    rng = np.random.default_rng(0)
    centre, size = _ranges(robot)
    fastest = model.time * model.accelerations
    for _ in range(searches):
        du = fastest * rng.uniform(-1.0, 1.0, model.n)
        u = first.u
        if initial is None:
            u = centre + size * rng.uniform(-SHARE, SHARE, model.n)
        try:
            state = robot.close(u, du, check=False)
        except StateError:
            continue
        if state.status is ClosureStatus.OK:
            yield state


def _ranges(robot: Robot) -> tuple[Array, Array]:
    """Centre (n,) and half size (n,) of the range of each active coordinate [rad, m]."""
    centres: list[float] = []
    sizes: list[float] = []
    for k, (low, high) in enumerate(robot.limits.tolist()):
        size = (high - low) / 2.0
        centre = low + size
        if not np.isfinite(size):
            is_slide = robot.joint_types[robot.active[k]] == "prismatic"
            size = OPEN_LENGTH if is_slide else OPEN_ANGLE
            centre = float(robot.reference[k])
        centres.append(centre)
        sizes.append(size)
    return np.array(centres), np.array(sizes)


class _Search:
    """Damped Gauss-Newton steps to the most likely state (Levenberg 1944)."""

    def __init__(
        self,
        layout: Layout,
        time: float,
        readings: Sequence[Reading],
    ) -> None:
        self._layout = layout
        self._time = time
        self._readings = readings
        model = layout.model
        _, sizes = _ranges(layout.robot)
        rates = RATES * model.time * model.accelerations
        parts = [sizes**2, rates**2, model.accelerations**2, layout.prior]
        self._prior = np.concatenate(parts)
        floor = np.finfo(float).tiny
        self._weights = 1.0 / np.maximum(self._prior, floor)
        self._noise: dict[str, Array] = {}
        for reading in readings:
            sensor = layout.sensors[reading.sensor]
            self._noise[sensor.name] = sensor.quality.noise**2 * np.eye(sensor.channels)

    def run(
        self,
        state: ClosedState,
        limit: float,
    ) -> dict[float, _Fit]:
        """The best fits that the steps from a state reach, by share of precision.

        Args:
            state: the state.
            limit: cost above which there is no point in more precision.
        """
        layout = self._layout
        n = layout.model.n
        bias = np.zeros(layout.size - layout.motion_size)
        covariance = np.diag(self._prior)
        begin = Belief(self._time, state, np.zeros(n), bias, covariance)
        at_rest = closed_near(layout.robot, state.u, np.zeros(n), state)
        prior = replace(begin, state=at_rest)
        fit = self._fit(begin, prior, SHARPER[0])
        fits: dict[float, _Fit] = {}
        for share in SHARPER:
            # what is far from linear is followed from blunt to sharp sensors
            if fits and fit.cost > limit:
                fits[share] = fit
                continue
            self._bend(fit.belief)
            fit = self._descended(self._fit(fit.belief, prior, share), prior, share)
            fits[share] = fit
        return fits

    def _descended(
        self,
        fit: _Fit,
        prior: Belief,
        share: float,
    ) -> _Fit:
        """The best fit that damped steps reach with so much of the readings' precision."""
        damping = 1e-4
        for _ in range(STEPS):
            trial = self._trial(fit, prior, damping, share)
            if trial.cost < fit.cost:
                gain = fit.cost - trial.cost
                fit = trial
                damping /= 10.0
                if gain < DONE * (1.0 + fit.cost):
                    break
            else:
                damping *= 10.0
                if damping > 1e8:
                    break
        return fit

    def settled(self, fit: _Fit) -> Belief:
        """The belief at a fit, with its covariance."""
        scale = np.sqrt(self._prior)
        scaled = fit.information * np.outer(scale, scale)
        covariance = np.linalg.inv(scaled) * np.outer(scale, scale)
        belief = fit.belief
        still = np.zeros(self._layout.size)
        return moved(self._layout, belief, still, (covariance + covariance.T) / 2.0)

    def _trial(
        self,
        fit: _Fit,
        prior: Belief,
        damping: float,
        share: float,
    ) -> _Fit:
        scale = np.sqrt(self._prior)
        scaled = fit.information * np.outer(scale, scale)
        damped = scaled + damping * np.diag(np.diagonal(scaled))
        change = scale * np.linalg.solve(damped, scale * fit.gradient)
        moved_belief = moved(self._layout, fit.belief, change, prior.covariance)
        moved_belief = self._within_limits(moved_belief)
        return self._fit(moved_belief, prior, share)

    def _within_limits(self, belief: Belief) -> Belief:
        """The belief with active coordinates within their limits."""
        low, high = self._layout.robot.limits.T
        margin = INSIDE * np.where(np.isfinite(high - low), high - low, 0.0)
        u = np.clip(belief.state.u, low + margin, high - margin)
        if np.array_equal(u, belief.state.u):
            return belief
        state = closed_near(self._layout.robot, u, belief.state.du, belief.state)
        return Belief(belief.time, state, belief.ddu, belief.bias, belief.covariance)

    def _fit(
        self,
        belief: Belief,
        prior: Belief,
        share: float,
    ) -> _Fit:
        layout = self._layout
        before = np.concatenate([prior.motion, prior.bias])
        now = np.concatenate([belief.motion, belief.bias])
        error = before - now
        gradient = self._weights * error
        information = np.diag(self._weights)
        # the place that the search starts from is no knowledge
        others = slice(layout.model.n, None)
        cost = float(error[others] @ (self._weights * error)[others])
        misfits: dict[str, float] = {}
        for reading in self._readings:
            sensor = layout.sensors[reading.sensor]
            change, slopes = self._misfit(belief, sensor, reading)
            weighted = share**2 * np.linalg.solve(self._noise[sensor.name], slopes)
            gradient = gradient + weighted.T @ change
            information = information + slopes.T @ weighted
            at_noise = np.linalg.solve(self._noise[sensor.name], change)
            misfits[sensor.name] = share**2 * float(change @ at_noise)
            cost += misfits[sensor.name]
        gradient[: layout.model.n] -= (self._weights * error)[: layout.model.n]
        return _Fit(belief, gradient, information, cost, misfits)

    def _bend(self, belief: Belief) -> None:
        """Add to the noise of accelerometers what rates do to them that no other sensor shows."""
        layout = self._layout
        n = layout.model.n
        along_rates = slice(n, 2 * n)
        information = np.diag(self._weights[along_rates])
        for reading in self._readings:
            sensor = layout.sensors[reading.sensor]
            if sensor.kind in RATES_ALONE:
                slopes = sensor.observe(belief.state, belief.ddu).slopes[:, along_rates]
                information = information + slopes.T @ slopes / sensor.quality.noise**2
        rates = np.linalg.inv(information)
        for reading in self._readings:
            sensor = layout.sensors[reading.sensor]
            bent = second_order(sensor, belief, rates)
            noise = sensor.quality.noise**2 * np.eye(sensor.channels)
            if bent is not None:
                noise += bent.covariance + np.outer(bent.shift, bent.shift)
            self._noise[sensor.name] = noise

    def _misfit(
        self,
        belief: Belief,
        sensor: Sensor,
        reading: Reading,
    ) -> tuple[Array, Array]:
        """Reading less the expected one (k,), and slopes (k, size) of the latter."""
        layout = self._layout
        back = layout.model.transition(reading.time - belief.time)
        u, du, ddu = (back @ belief.motion).reshape(3, -1)
        state = closed_near(layout.robot, u, du, belief.state)
        readings, along_motion = sensor.observe(state, ddu)
        expected = readings + layout.bias_of(sensor, belief.bias)
        slopes = layout.slopes(sensor, along_motion @ back)
        return sensor.difference(reading.values, expected), slopes


def _contradiction(
    layout: Layout,
    best: _Fit,
) -> str:
    """Says that no state explains the first readings, and which sensor is farthest off."""
    text = "no state within the limits explains the first reading of every sensor"
    name = max(best.misfits, key=lambda key: best.misfits[key])
    sensor = layout.sensors[name]
    unit = unit_of(sensor)
    return (
        f"{text} ({name} is farthest off; expected {unit}); check units, directions and mounting"
        " poses"
    )


def unit_of(sensor: Sensor) -> str:
    """The unit of a sensor's readings."""
    units = {Kind.GYRO: "rad/s", Kind.ACCELEROMETER: "m/s^2", Kind.STROKE: "m"}
    if sensor.kind in AT_JOINTS and sensor.kind is Kind.RATE:
        joint_type = sensor.robot.joint_types[sensor.place]
        return "rad/s" if joint_type == "revolute" else "m/s"
    return units.get(sensor.kind, "rad")
