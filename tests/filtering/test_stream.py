"""The filter of a stream: consistency, late and repeated readings, outliers, a new start."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.estimation import SensorError
from hybrid_dynamics_core.filtering import (
    Kind,
    MotionModel,
    ObservabilityError,
    Quality,
    StateFilter,
    estimate_states,
    imu,
    observability,
    sensor_on_frame,
    sensor_on_joint,
)
from hybrid_dynamics_core.filtering.gate import chi_squared
from tests.filtering.mixes import on_joint

MODEL = MotionModel(np.array([0.3, 0.2, 0.2, 0.2]), 0.5)
STEP = 0.02
GYRO = Quality(0.003, bias=0.002)
FORCE = Quality(0.03, bias=0.02)


@cache
def excavator():
    return load("excavator")


@cache
def carried():
    robot = excavator()
    sensors = [on_joint(robot, "slew", 1e-3)]
    for link in ("boom", "stick", "bucket"):
        sensors += imu(robot, link, link, GYRO, FORCE)
    return sensors


def drawn(seed: int, steps: int):
    """A motion drawn from the model, and readings drawn from the noise of the sensors."""
    robot, rng = excavator(), np.random.default_rng(seed)
    forward, noise = MODEL.transition(STEP), MODEL.noise(STEP)
    root = np.linalg.cholesky(noise + 1e-18 * np.eye(len(noise)))
    x = np.concatenate([robot.reference, np.zeros(4), MODEL.accelerations * rng.normal(size=4)])
    constant = {s.name: s.quality.bias * rng.normal(size=s.channels) for s in carried()}
    truth, readings = [], []
    for k in range(steps):
        if k:
            x = forward @ x + root @ rng.normal(size=len(x))
        state = robot.close(x[:4], x[4:8])
        truth.append(x)
        for sensor in carried():
            exact = sensor.observe(state, x[8:]).readings
            error = constant[sensor.name] + sensor.quality.noise * rng.normal(size=len(exact))
            readings.append((STEP * k, sensor.name, exact + error))
    return np.array(truth), readings


def test_errors_have_the_covariance_of_the_filter():
    """NEES of positions, rates and accelerations, of motions drawn from the model itself."""
    squares = []
    for seed in range(4):
        truth, readings = drawn(seed, 15)
        watched = StateFilter(excavator(), carried(), MODEL, latest=0.0)
        for reading in readings:
            watched.add(*reading)
        estimate = watched.estimate
        error = np.concatenate([estimate.state.u, estimate.state.du, estimate.ddu]) - truth[-1]
        squares.append(error @ np.linalg.solve(estimate.covariance, error))
    total = sum(squares)
    assert chi_squared(0.005, 12 * 4) < total < chi_squared(0.995, 12 * 4)


def test_late_readings_change_nothing():
    """Any order within the time that readings may be late gives the same bits."""
    _, readings = drawn(1, 18)
    plain = StateFilter(excavator(), carried(), MODEL, latest=0.2)
    for reading in readings:
        plain.add(*reading)
    rng = np.random.default_rng(0)
    arrivals = [time + 0.09 * rng.uniform() for time, _, _ in readings]
    mixed = StateFilter(excavator(), carried(), MODEL, latest=0.2)
    for k in np.argsort(arrivals):
        mixed.add(*readings[k])
    for one, other in zip(plain.estimate, mixed.estimate, strict=True):
        assert np.array_equal(getattr(one, "s", one), getattr(other, "s", other))
    assert plain.counts.used == mixed.counts.used


def test_repeated_late_and_wrong_readings_are_counted():
    _, readings = drawn(2, 30)
    watched = StateFilter(excavator(), carried(), MODEL, latest=0.1)
    for reading in readings:
        watched.add(*reading)
    before = watched.estimate
    watched.add(*readings[-1])
    assert watched.counts.duplicate["bucket.accelerometer"] == 1
    watched.add(0.0, "boom.gyro", [0.0, 0.0, 0.0])
    assert watched.counts.late["boom.gyro"] == 1
    shown = watched.add(before.time + 1e-3, "slew", 0.5)
    assert [each.is_used for each in shown] == [False]
    assert watched.counts.beyond_gate["slew"] == 1
    assert np.allclose(watched.estimate.state.u, before.state.u, atol=1e-3)
    for bad in (np.nan, [0.0, 1.0]):
        with pytest.raises(InputError, match=r"slew: values are .* expected 1 finite"):
            watched.add(1.0, "slew", bad)
    with pytest.raises(InputError, match=r"no sensor 'slev'.*did you mean 'slew'"):
        watched.add(1.0, "slev", 0.0)


def test_each_reading_is_counted_once():
    """Those before the first reading of the last sensor too, which give no state."""
    _, readings = drawn(3, 30)
    first = readings[0][0]
    given = [reading for reading in readings if reading[1] != "slew" or reading[0] > first + 0.05]
    watched = StateFilter(excavator(), carried(), MODEL, latest=0.1)
    for reading in given:
        watched.add(*reading)
    counts = watched.counts
    kinds = (counts.used, counts.beyond_gate, counts.duplicate, counts.late, counts.early)
    assert counts.early.total() > 0
    assert sum(kind.total() for kind in kinds) == len(given)


def test_the_filter_starts_anew_after_a_jump():
    """All sensors agree on another pose: the filter follows them."""
    robot = excavator()
    sensors = [on_joint(robot, name, 1e-3) for name in robot.active]
    watched = StateFilter(robot, sensors, MODEL, latest=0.0)
    there = robot.reference + np.array([1.0, 0.2, 0.2, 0.2])
    for k in range(60):
        u = robot.reference if k < 20 else there
        for name, value in zip(robot.active, u, strict=True):
            watched.add(0.01 * k, name, value)
    assert watched.counts.starts == 2
    assert np.allclose(watched.estimate.state.u, there, atol=1e-3)


def test_what_a_set_determines():
    robot = excavator()
    boom, stick, bucket = carried()[1:3], carried()[3:5], carried()[5:7]
    gyros = [sensor for sensor in carried() if sensor.kind is Kind.GYRO]
    cases = {
        ("slew",): [*boom, *stick, *bucket],
        ("slew", "bucket_cylinder"): [*boom, *stick],
        # while slewing, the vertical shows in the axes of the boom
        ("slew", "stick_cylinder", "bucket_cylinder"): gyros[:1],
        robot.active: imu(robot, "house", "house", GYRO, FORCE),
    }
    for undetermined, sensors in cases.items():
        with pytest.raises(ObservabilityError) as caught:
            StateFilter(robot, sensors, MODEL)
        assert caught.value.undetermined == undetermined
        assert ", ".join(undetermined) in str(caught.value)
    shown = observability(robot, carried(), MODEL)
    assert shown.rank == shown.size == 8


def test_an_inclinometer_and_encoders_of_passive_joints_suffice():
    robot = excavator()
    sensors = [on_joint(robot, "slew", 1e-3), on_joint(robot, "stick_pitch", 1e-3)]
    sensors.append(sensor_on_joint(robot, "bars", Kind.ENCODER, "coupler_pitch", Quality(1e-3)))
    tilt = sensor_on_frame(robot, "tilt", Kind.INCLINOMETER, "boom", Quality(1e-3))
    sensors.append(tilt)
    truth = robot.close(robot.reference + np.array([0.3, 0.1, -0.1, 0.1]))
    boom = truth.s[robot.coordinates.index("boom_pitch")]
    assert tilt.observe(truth, np.zeros(4)).readings == pytest.approx(boom)
    watched = StateFilter(robot, sensors, MODEL, latest=0.0)
    for k in range(20):
        for sensor in sensors:
            watched.add(0.01 * k, sensor.name, sensor.observe(truth, np.zeros(4)).readings)
    assert np.allclose(watched.estimate.state.s, truth.s, atol=1e-3)


def test_first_readings_that_contradict_each_other_are_refused():
    robot = excavator()
    sensors = [on_joint(robot, name, 1e-3) for name in (*robot.active, "boom_pitch")]
    watched = StateFilter(robot, sensors, MODEL, latest=0.0)
    state = robot.close(robot.reference)
    for sensor in sensors[:-1]:
        watched.add(0.0, sensor.name, sensor.observe(state, np.zeros(4)).readings)
    with pytest.raises(SensorError, match=r"boom_.* is farthest off; expected"):
        watched.add(0.0, "boom_pitch", 0.9)


def test_the_gate_is_a_quantile_of_chi_squared():
    """Against tables: 0.95 and 0.999 quantiles."""
    assert chi_squared(0.95, 1) == pytest.approx(3.841459, abs=1e-6)
    assert chi_squared(0.95, 3) == pytest.approx(7.814728, abs=1e-6)
    assert chi_squared(0.999, 6) == pytest.approx(22.457744, abs=1e-6)
    assert chi_squared(0.025, 400) == pytest.approx(346.4817, abs=1e-3)


@pytest.mark.parametrize("shape", [(0,), (0, 1), (2, 0), (2, 1, 1), (2, 2), ()])
def test_readings_of_any_shape_give_states_or_a_clear_error(shape):
    sensors = [on_joint(excavator(), name, 1e-3) for name in excavator().active]
    count = shape[0] if shape else 1
    readings = {sensor.name: (np.arange(float(count)), np.zeros(shape)) for sensor in sensors}
    with pytest.raises(InputError):
        estimate_states(excavator(), sensors, readings, MODEL)
