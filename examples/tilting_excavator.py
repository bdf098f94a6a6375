"""Joint states from IMUs: boom, stick and bucket of an excavator without any stroke sensor.

python examples/tilting_excavator.py [--plot FILE]

Three IMUs on boom, stick and bucket at 50 Hz and an encoder at the slewing ring show all joints of
a lift. Their noise is that of the Bosch BMI088, their offsets are 0.075 deg/s and 1 mg. Half-way
the boom hits something: for 0.2 s its accelerometer reads nonsense, which the gate leaves out.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.filtering import (
    Kind,
    MotionModel,
    Quality,
    Sensor,
    StateTrack,
    estimate_states,
    imu,
    sensor_on_joint,
)

RATE = 50.0  # [Hz]
GYRO = Quality.from_density(math.radians(0.014), RATE, bias=math.radians(0.075))
FORCE = Quality.from_density(190e-6 * 9.81, RATE, bias=1e-3 * 9.81)
MOTION = MotionModel(np.array([0.3, 0.12, 0.12, 0.13]), 0.5)  # usual accelerations
TIMES = [0.0, 1.0, 4.0, 7.0]  # [s] at the points below
POINTS = [  # slewing [rad], cylinders of boom, stick and bucket [m]
    [0.0, 0.40, 1.05, 0.85],  # dug
    [0.0, 0.40, 1.05, 0.85],  # at rest
    [0.3, 0.80, 0.95, 0.92],  # lifted
    [1.0, 0.80, 0.70, 0.60],  # swung and dumped
]
IMPACT = (3.4, 3.6)  # [s]


def carried(robot: Robot) -> list[Sensor]:
    """The sensors of the machine."""
    sensors = [sensor_on_joint(robot, "slew", Kind.ENCODER, "slew", Quality(math.radians(0.05)))]
    for link in ("boom", "stick", "bucket"):
        sensors += imu(robot, link, link, GYRO, FORCE)
    return sensors


def estimated() -> tuple[Robot, ClosedState, StateTrack]:
    """The robot, its true states, and those that the sensors show."""
    robot = load("excavator")
    rng = np.random.default_rng(2)
    time = np.arange(0.0, TIMES[-1], 1.0 / RATE)
    stop = np.zeros_like(POINTS)
    goal = JointTrajectory(TIMES, POINTS, stop, stop)(time)
    truth = robot.close(goal.u, goal.du)
    sensors = carried(robot)
    readings = {}
    for sensor in sensors:
        exact = sensor.observe(truth, goal.ddu).readings
        offset = sensor.quality.bias * rng.normal(size=sensor.channels)
        noise = sensor.quality.noise * rng.normal(size=exact.shape)
        readings[sensor.name] = (time, exact + offset + noise)
    hit = (time >= IMPACT[0]) & (time < IMPACT[1])
    shaken = readings["boom.accelerometer"][1]
    shaken[hit] += rng.normal(0.0, 30.0, shaken[hit].shape)
    return robot, truth, estimate_states(robot, sensors, readings, MOTION)


def tip_errors(robot: Robot, truth: ClosedState, track: StateTrack) -> np.ndarray:
    """Distance (N,) of the estimated teeth of the bucket from the true ones [m]."""
    true = robot.forward_kinematics(truth).position
    tip = robot.forward_kinematics(track.state).position
    return np.linalg.norm(tip - true, axis=1)


def plot(robot: Robot, truth: ClosedState, track: StateTrack, path: str) -> None:
    """Errors of the cylinders in their 95 % bands, and that of the teeth."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import LOOPS  # noqa: PLC0415

    about = "three IMUs and a slewing encoder; the boom hits something at 3.4 s"
    with written_page(path, "Joint states from IMUs", about, height=5.2) as figure:
        strokes, teeth = figure.subplots(2, 1, sharex=True, height_ratios=[2.0, 1.0])
        errors = 1e3 * (track.state.u - truth.u)
        bands = 2e3 * track.deviations()
        for k, name in enumerate(robot.active[1:], start=1):
            colour = LOOPS[k - 1]
            label = name.replace("_", " ")
            strokes.fill_between(track.time, -bands[:, k], bands[:, k], color=colour, alpha=0.12)
            strokes.plot(track.time, errors[:, k], color=colour, label=label)
        strokes.set(ylabel="stroke less truth [mm]", ylim=(-6.0, 6.0))
        distances = 1e3 * tip_errors(robot, truth, track)
        teeth.plot(track.time, distances, color=LOOPS[3], label="distance")
        teeth.axvspan(*IMPACT, color=LOOPS[3], alpha=0.15, label="impact")
        teeth.set(xlabel="t [s]", ylabel="teeth [mm]", ylim=(0.0, None))
        entitled(strokes, "errors of the cylinders, and two deviations", 3)
        entitled(teeth, "distance of the teeth of the bucket from the truth", 2)


def main() -> None:
    """Print the errors; draw if asked."""
    parser = argparse.ArgumentParser(description="Joint states from IMUs.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    robot, truth, track = estimated()
    errors = tip_errors(robot, truth, track)
    rms = 1e3 * math.sqrt(float(np.mean(errors**2)))
    print(f"teeth of the bucket: {rms:.1f} mm rms, {1e3 * errors.max():.1f} mm at most")
    for name, count in track.counts.beyond_gate.items():
        print(f"{name}: {count} of {count + track.counts.used[name]} readings left out")
    if options.plot:
        plot(robot, truth, track, options.plot)


if __name__ == "__main__":
    main()
