"""Accuracy of joint states from IMUs: simulated cycles of the shipped excavator."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.closed_state.state import ClosedState
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.description.geometry import Transform, rotation_from_rpy
from hybrid_dynamics_core.filtering import (
    Kind,
    MotionModel,
    Quality,
    Sensor,
    StateFilter,
    imu,
    sensor_on_joint,
)
from hybrid_dynamics_core.filtering.gate import chi_squared
from hybrid_dynamics_core.ground.arrays import Array

RATE = 100.0  # [Hz] of IMUs
STANDARD_GRAVITY = 9.80665  # [m/s^2]
# Bosch BMI088, data sheet BST-BMI088-DS001: noise densities and temperature coefficients
GYRO_DENSITY = math.radians(0.014)  # [rad/s/sqrt(Hz)]
ACCELERATION_DENSITY = 190e-6 * STANDARD_GRAVITY  # [m/s^2/sqrt(Hz)], of its noisiest axis
GYRO_DRIFT = math.radians(0.015)  # [rad/s/K]
ACCELERATION_DRIFT = 0.2e-3 * STANDARD_GRAVITY  # [m/s^2/K]
WARMER = 5.0  # [K] deviation of the temperature since the offsets were zeroed
SLEW_NOISE = math.radians(0.05)  # [rad] of the encoder of the slewing ring
# stops of a cycle: dig, lift, swing, dump, back; slewing [rad] and cylinders [m]
TIMES = (0.0, 2.0, 5.0, 8.0, 10.0, 13.0, 16.0, 18.0)
PATH = (
    (0.0, 0.35, 0.75, 0.45),
    (0.0, 0.35, 0.75, 0.45),
    (0.0, 0.30, 1.10, 0.80),
    (0.3, 0.70, 1.05, 0.92),
    (1.2, 0.85, 0.80, 0.90),
    (1.5, 0.80, 0.60, 0.40),
    (0.2, 0.45, 0.70, 0.35),
    (0.0, 0.35, 0.75, 0.45),
)
TRAVEL = 0.05  # [rad, m] by which stops differ from cycle to cycle
ACCELERATIONS = (0.4, 0.12, 0.12, 0.13)  # [rad/s^2, m/s^2] deviations that the filter expects
CORRELATION = 0.5  # [s]
EVERY = 0.5  # [s] between the samples that are compared
SETTLED = 1.0  # [s] at rest before them
CONFIDENCE = 0.95
MOUNTS = {  # of the IMUs on their links
    "house": ((0.0, 0.0, 1.8), 0.0),
    "boom": ((2.5, 0.7, 0.2), 0.3),
    "stick": ((1.2, 0.3, 0.2), -0.05),
    "bucket": ((0.2, 0.5, 0.0), 0.5),
}


@dataclass(frozen=True)
class Outcome:
    """Errors of one cycle at S instants.

    Attributes:
        tip: (S,) distance of the estimated bucket tip from the true one [m].
        angles: (S, n) errors of the active coordinates [rad, m].
        nees: (S,) squared errors of the active coordinates in their covariance.
        rejected: share of readings beyond their gate.
    """

    tip: Array
    angles: Array
    nees: Array
    rejected: float


def sensors(robot: Robot) -> list[Sensor]:
    """Four IMUs and the encoder of the slewing ring."""
    gyro = Quality.from_density(GYRO_DENSITY, RATE, bias=WARMER * GYRO_DRIFT)
    accelerometer = Quality.from_density(
        ACCELERATION_DENSITY, RATE, bias=WARMER * ACCELERATION_DRIFT
    )
    carried: list[Sensor] = []
    for link, (place, turn) in MOUNTS.items():
        pose = Transform(rotation_from_rpy(0.0, 0.0, turn), np.array(place))
        carried += imu(robot, link, link, gyro, accelerometer, pose)
    encoder = Quality(SLEW_NOISE)
    carried.append(sensor_on_joint(robot, "slew", Kind.ENCODER, "slew", encoder))
    return carried


@dataclass(frozen=True)
class Cycle:
    """A motion and what the sensors read: N samples."""

    time: Array
    state: ClosedState
    readings: Mapping[str, Array]


def cycle(robot: Robot, carried: Sequence[Sensor], rng: np.random.Generator) -> Cycle:
    """A cycle with noise and constant errors."""
    shift = TRAVEL * rng.uniform(-1.0, 1.0, (len(TIMES), len(robot.active)))
    shift[1] = shift[0]  # at rest at first
    stops = np.zeros_like(shift)
    path = JointTrajectory(list(TIMES), PATH + shift, stops, stops)
    time = np.arange(0.0, TIMES[-1], 1.0 / RATE)
    goal = path(time)
    state = robot.close(goal.u, goal.du)
    readings: dict[str, Array] = {}
    for sensor in carried:
        exact = sensor.observe(state, goal.ddu).readings
        quality = sensor.quality
        constant = quality.bias * rng.normal(size=sensor.channels)
        noise = quality.noise * rng.normal(size=exact.shape)
        readings[sensor.name] = exact + constant + noise
    return Cycle(time, state, readings)


def estimated(robot: Robot, seed: int) -> Outcome:
    """The errors of one cycle."""
    rng = np.random.default_rng(seed)
    carried = sensors(robot)
    motion = cycle(robot, carried, rng)
    model = MotionModel(np.array(ACCELERATIONS), CORRELATION)
    watched = StateFilter(robot, carried, model)
    tips: list[float] = []
    errors: list[Array] = []
    nees: list[float] = []
    every = round(EVERY * RATE)
    n = model.n
    for k, time in enumerate(motion.time.tolist()):
        for name, values in motion.readings.items():
            watched.add(time, name, values[k])
        if time < SETTLED or k % every:
            continue
        estimate = watched.estimate
        error = estimate.state.u - motion.state.u[k]
        true = robot.forward_kinematics(motion.state.rows(k)).position
        tip = robot.forward_kinematics(estimate.state).position
        tips.append(float(np.linalg.norm(tip - true)))
        errors.append(error)
        nees.append(float(error @ np.linalg.solve(estimate.covariance[:n, :n], error)))
    counts = watched.counts
    beyond = counts.beyond_gate.total()
    rejected = beyond / (beyond + counts.used.total())
    return Outcome(np.array(tips), np.array(errors), np.array(nees), rejected)


def outcomes(cycles: int, seed: int) -> list[Outcome]:
    """Errors of cycles with other seeds."""
    robot = load("excavator")
    return [estimated(robot, seed + k) for k in range(cycles)]


def states_table(results: Sequence[Outcome]) -> list[str]:
    """The table of the docs."""
    tips = np.concatenate([result.tip for result in results])
    by_time = np.stack([result.nees for result in results])
    n = results[0].angles.shape[1]
    cycles = len(results)
    low = chi_squared((1.0 - CONFIDENCE) / 2.0, n * cycles) / cycles
    high = chi_squared((1.0 + CONFIDENCE) / 2.0, n * cycles) / cycles
    means = by_time.mean(axis=0)
    inside = np.mean((means >= low) & (means <= high))
    rejected = np.mean([result.rejected for result in results])
    return [
        "| figure | value |",
        "|---|---|",
        f"| cycles | {cycles} |",
        f"| bucket tip, rms | {1e3 * np.sqrt(np.mean(tips**2)):.1f} mm |",
        f"| bucket tip, 95 % | {1e3 * np.quantile(tips, CONFIDENCE):.1f} mm |",
        f"| NEES, mean of all ({n} freedoms) | {means.mean():.2f} |",
        f"| its 95 % band at one instant | {low:.2f} to {high:.2f} |",
        f"| instants within the band | {100.0 * inside:.0f} % |",
        f"| readings beyond their gate | {100.0 * rejected:.3f} % |",
    ]
