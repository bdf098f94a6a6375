"""Topics of sensors, and readings of sensors from their messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from hybrid_dynamics_core.filtering import Kind, Sensor

from .imu import ImuSample
from .joint_samples import FloatArray, JointSample

SENSOR_STATES: Final = "~/sensor_states"  # sensor_msgs/JointState with names of sensors or joints
INERTIAL: Final = (Kind.GYRO, Kind.ACCELEROMETER)


class SensorReading(NamedTuple):
    """One reading.

    Attributes:
        sensor: name of the sensor.
        stamp_ns: stamp [ns].
        values: (k,) in its unit.
    """

    sensor: str
    stamp_ns: int
    values: FloatArray


class SensorTopics:
    """The topic of each sensor.

    Attributes:
        inertial: sensors by topic of sensor_msgs/Imu.
        joints: sensors by topic of sensor_msgs/JointState.
    """

    def __init__(self, sensors: Sequence[Sensor]) -> None:
        self.inertial: dict[str, list[Sensor]] = {}
        self.joints: dict[str, list[Sensor]] = {}
        for sensor in sensors:
            if sensor.kind in INERTIAL:
                topic = sensor.topic or default_topic(sensor)
                self.inertial.setdefault(topic, []).append(sensor)
            else:
                topic = sensor.topic or SENSOR_STATES
                self.joints.setdefault(topic, []).append(sensor)


def default_topic(sensor: Sensor) -> str:
    """The topic of an inertial sensor that names none: ~/imu/NAME."""
    unit = sensor.name
    for kind in INERTIAL:
        unit = unit.removesuffix(f".{kind}")
    return f"~/imu/{unit}"


def inertial_readings(sensors: Sequence[Sensor], sample: ImuSample) -> list[SensorReading]:
    """The readings of sensors of one topic in an Imu message."""
    readings: list[SensorReading] = []
    for sensor in sensors:
        values = sample.force if sensor.kind is Kind.ACCELEROMETER else sample.rate
        if values is not None:
            readings.append(SensorReading(sensor.name, sample.stamp_ns, values))
    return readings


def joint_readings(sensors: Sequence[Sensor], sample: JointSample) -> list[SensorReading]:
    """The readings of sensors of one topic in a JointState, by name of the sensor or its joint.

    Rates are velocities, all others are positions. NaN is no reading.
    """
    readings: list[SensorReading] = []
    names = list(sample.names)
    for sensor in sensors:
        name = sensor.name
        if name not in names and sensor.kind is not Kind.INCLINOMETER:
            name = sensor.place
        values = sample.velocity if sensor.kind is Kind.RATE else sample.position
        if name not in names or values is None or len(values) != len(names):
            continue
        value = float(values[names.index(name)])
        if np.isfinite(value):
            readings.append(SensorReading(sensor.name, sample.stamp_ns, np.array([value])))
    return readings
