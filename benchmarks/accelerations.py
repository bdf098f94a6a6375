"""What estimated accelerations cost the force of a cylinder: motions, rates, noises, estimators.

python -m benchmarks.accelerations [--seconds 8] [--seed 0]

The forging robot moves all of its joints: in sines, or with velocities that valves ramp up and
down. Positions are sampled, with noise or without; velocities are left out, exact, or differences
of positions. The node's estimators make rates of them. Shown is the root mean square of the error
in the force of cylinder 1 (q12) [N], after two seconds. The table is in `docs/node.md`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_ros.stream.filter.rate_estimator import MotionEstimator
from hybrid_dynamics_ros.stream.filter.routes import Kalman

FloatArray = NDArray[np.float64]

JOINT = 1  # q12, cylinder 1, of q1, q12, q22, q4
CENTRE = np.array([0.0, 0.1, 0.15, 0.0])
STROKES = np.array([1.0, 0.1, 0.1, 1.0])  # [rad or m]
PHASES = np.array([0.3, 0.0, 1.0, 2.0])
RAMP = 0.3  # [s] in which a valve opens or closes
OPEN = 0.4  # [s] for which it stays open
SPEEDS = np.array([1.0, 0.12, 0.12, 1.0])  # [rad/s or m/s] of open valves
SETTLED = 2.0  # [s]
RATES = (100.0, 1000.0)  # [Hz]
NOISE = 1e-5  # [rad or m]

ESTIMATORS = {
    "polynomial, 10 Hz": MotionEstimator(10.0, 0.5),
    "polynomial, 20 Hz": MotionEstimator(20.0, 0.5),
    "kalman, 15 Hz": MotionEstimator(10.0, 0.5, Kalman(15.0, 400.0)),
    "kalman, 20 Hz": MotionEstimator(10.0, 0.5, Kalman(20.0, 400.0)),
    "kalman, 15 Hz, `velocity_noise` 30": MotionEstimator(10.0, 0.5, Kalman(15.0, 30.0)),
}


class Motion(NamedTuple):
    """Joints over time, (N, 4) each [rad or m, and per s and s^2]."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


def sines(time: FloatArray, frequency: float, share: float) -> Motion:
    """All joints in sines of a frequency [Hz], over a share of their strokes."""
    omega = 2.0 * np.pi * frequency
    angle = omega * time[:, None] + PHASES
    stroke = share * STROKES
    return Motion(
        CENTRE + stroke * np.sin(angle),
        stroke * omega * np.cos(angle),
        -stroke * omega**2 * np.sin(angle),
    )


def ramps(time: FloatArray) -> Motion:
    """Valves open, stay open, close, and open the other way, joint after joint."""
    half = 2.0 * RAMP + OPEN
    offsets = np.array([0.0, 0.0, 0.5, 0.25])
    within = (time[:, None] + offsets) % (2.0 * half)
    forward = within < half
    within = np.where(forward, within, within - half)
    opening, closing = within < RAMP, within >= RAMP + OPEN
    acceleration = (opening.astype(float) - closing) / RAMP
    remaining = half - within
    velocity = np.minimum(np.minimum(within, remaining) / RAMP, 1.0)
    position = within - RAMP / 2.0
    position = np.where(opening, within**2 / (2.0 * RAMP), position)
    position = np.where(closing, RAMP + OPEN - remaining**2 / (2.0 * RAMP), position)
    position = np.where(forward, position, RAMP + OPEN - position)
    sign = np.where(forward, 1.0, -1.0)
    start = CENTRE - SPEEDS * (RAMP + OPEN) / 2.0
    return Motion(start + SPEEDS * position, sign * SPEEDS * velocity, sign * SPEEDS * acceleration)


MOTIONS: dict[str, Callable[[FloatArray], Motion]] = {
    "0.3 Hz": lambda time: sines(time, 0.3, 1.0),
    "valve ramps of 0.3 s": ramps,
    "1 Hz": lambda time: sines(time, 1.0, 1.0),
    "3 Hz": lambda time: sines(time, 3.0, 0.3),
}


class Sensors(NamedTuple):
    """What sensors give of a motion.

    Attributes:
        noise: deviation of positions [rad or m].
        velocity: "" for none, "exact", or "differenced".
    """

    noise: float
    velocity: str = ""

    def samples(
        self, motion: Motion, rate: float, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray | None]:
        """Positions and velocities at a rate [Hz]."""
        position = motion.position + self.noise * rng.standard_normal(motion.position.shape)
        if self.velocity == "exact":
            return position, motion.velocity
        if self.velocity == "differenced":
            first = motion.velocity[:1]
            return position, np.concatenate([first, np.diff(position, axis=0) * rate])
        return position, None


SENSORS = {
    "noise of 1e-5": Sensors(NOISE),
    "no noise": Sensors(0.0),
    "noise, exact velocities": Sensors(NOISE, "exact"),
    "noise, differenced velocities": Sensors(NOISE, "differenced"),
}


def forces(robot: Robot, motion: Motion) -> FloatArray:
    """What the cylinder must give [N], (N,)."""
    state = robot.close(motion.position, motion.velocity)
    efforts: FloatArray = robot.inverse_dynamics(state, motion.acceleration)[:, JOINT]
    return efforts


def estimated(
    estimator: MotionEstimator, time: FloatArray, position: FloatArray, velocity: FloatArray | None
) -> Motion:
    """The motion as the node sees it."""
    stamps = np.round(time * 1e9).astype(np.int64)
    given = np.zeros_like(position) if velocity is None else velocity
    measured = np.full(len(time), velocity is not None)
    rates = estimator.run(None, stamps, position, given, measured)
    return Motion(position, rates.velocity, rates.acceleration)


def rms(values: FloatArray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def errors(robot: Robot, motion: str, seconds: float, seed: int) -> list[list[str]]:
    """Lines of the table for a motion: a line for each sensor, an entry for each estimator."""
    lines = []
    for name, sensors in SENSORS.items():
        parts: dict[str, list[str]] = {estimator: [] for estimator in ESTIMATORS}
        for rate in RATES:
            time = np.arange(round(seconds * rate)) / rate
            truth = MOTIONS[motion](time)
            samples = sensors.samples(truth, rate, np.random.default_rng(seed))
            late = time > SETTLED
            wanted = forces(robot, truth)[late]
            for estimator, work in ESTIMATORS.items():
                guess = Motion(*(part[late] for part in estimated(work, time, *samples)))
                parts[estimator].append(f"{rms(forces(robot, guess) - wanted):.0f}")
        lines.append([motion, name, *(" / ".join(values) for values in parts.values())])
    return lines


def inertial(robot: Robot, motion: str, seconds: float) -> float:
    """The part of the force that accelerations cause [N], root mean square."""
    time = np.arange(round(seconds * RATES[-1])) / RATES[-1]
    truth = MOTIONS[motion](time)
    still = truth._replace(acceleration=np.zeros_like(truth.acceleration))
    return rms(forces(robot, truth) - forces(robot, still))


def table(lines: Sequence[Sequence[str]]) -> str:
    """Markdown."""
    head = ["motion", "sensors", *ESTIMATORS]
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.accelerations", description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="length of each motion")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    options = parser.parse_args()
    robot = load("forging_chu2020")
    write = sys.stdout.write
    lines = []
    for motion in MOTIONS:
        size = inertial(robot, motion, options.seconds)
        write(f"{motion}: accelerations cause {size:.0f} N\n")
        lines += errors(robot, motion, options.seconds, options.seed)
    write(f"{table(lines)}\n")


if __name__ == "__main__":
    main()
