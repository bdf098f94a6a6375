"""Random sets of sensors, and exact motions that they see."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.description.geometry import Transform, rotation_from_rpy
from hybrid_dynamics_core.filtering import (
    Kind,
    MotionModel,
    Quality,
    Sensor,
    sensor_on_frame,
    sensor_on_joint,
)

ON_FRAMES = (Kind.GYRO, Kind.ACCELEROMETER, Kind.INCLINOMETER)


def pose(rng: np.random.Generator) -> Transform:
    """A random pose of a sensor on its link."""
    return Transform(rotation_from_rpy(*rng.uniform(-2.0, 2.0, 3)), rng.uniform(-0.3, 0.3, 3))


def on_joint(robot: Robot, joint: str, noise: float, name: str = "") -> Sensor:
    """An encoder or stroke sensor."""
    kind = Kind.ENCODER if robot.joint_types[joint] == "revolute" else Kind.STROKE
    return sensor_on_joint(robot, name or joint, kind, joint, Quality(noise))


def mix(robot: Robot, seed: int, noise: float) -> list[Sensor]:
    """One to six sensors of any kinds at random places."""
    rng = np.random.default_rng(seed)
    links = [link for link in robot.description.links if link != robot.base_frame]
    sensors: list[Sensor] = []
    for k in range(int(rng.integers(1, 7))):
        name = f"sensor_{k}"
        if rng.integers(2):
            kind = ON_FRAMES[int(rng.integers(3))]
            link = str(rng.choice(links))
            sensor = sensor_on_frame(robot, name, kind, link, Quality(noise), pose(rng))
        elif rng.integers(3):
            sensor = on_joint(robot, str(rng.choice(robot.coordinates)), noise, name)
        else:
            joint = str(rng.choice(robot.coordinates))
            sensor = sensor_on_joint(robot, name, Kind.RATE, joint, Quality(noise))
        sensors.append(sensor)
    return sensors


def motion(
    robot: Robot, model: MotionModel, start: np.ndarray, times: np.ndarray, seed: int
) -> tuple[ClosedState, np.ndarray]:
    """States and accelerations of a motion whose accelerations decay as the model has it."""
    rng = np.random.default_rng(seed)
    first = np.concatenate([start, *rng.uniform(-0.3, 0.3, (2, len(start)))])
    rows = np.array([model.transition(float(t)) @ first for t in times]).reshape(len(times), 3, -1)
    state = robot.close_path(rows[:, 0], rows[:, 1], near=robot.close(start))
    return state, rows[:, 2]
