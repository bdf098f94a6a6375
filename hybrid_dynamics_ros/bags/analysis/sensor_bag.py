"""Readings of sensors from bags: sensor_msgs/Imu, and joint states."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from hybrid_dynamics_core.filtering import Sensor

from ...messages.imu import IMU, sample_of_imu
from ...messages.interfaces import JOINT_STATE, deserialize
from ...messages.joint_samples import RejectedError, RejectionCode
from ...messages.sensor_topics import (
    SENSOR_STATES,
    SensorReading,
    SensorTopics,
    inertial_readings,
    joint_readings,
)
from ..decode import sample_of_state
from ..errors import BagError
from ..input_topic import input_topic
from ..recorded_poses import resolved
from ..storage.bag_reader import BagReader
from .sensor_table import SensorData

SECOND: Final = 1e-9  # [s] of a nanosecond


def read_sensor_bag(path: Path, sensors: Sequence[Sensor], topic: str | None = None) -> SensorData:
    """Read the messages of sensors; times are [s] since the first stamp.

    Args:
        path: the bag.
        sensors: the sensors, with their topics.
        topic: topic of the joint states of sensors that name none; None: ~/sensor_states, or the
            input of the node, or the only topic of joint states.

    Raises:
        BagError: the bag has no message of any sensor.
    """
    readings: list[SensorReading] = []
    with BagReader(path) as source:
        by_topic = _by_topic(source, SensorTopics(sensors), topic)
        for name, messages in source.read(frozenset(by_topic)):
            for row in range(len(messages)):
                kind, carried = by_topic[name]
                try:
                    readings += _readings(kind, carried, messages.message(row))
                except RejectedError as error:
                    source.losses.add(f"{name}: {error}")
                except Exception as error:  # noqa: BLE001 - whatever rosbags meets in damaged bytes
                    source.losses.add(f"{name}: {str(error) or type(error).__name__}")
        losses = source.losses.describe()
    if not readings:
        raise BagError(f"{path}: no reading of a sensor; expected topics {', '.join(by_topic)}")
    return _data(readings, sensors, losses)


def _by_topic(
    source: BagReader, topics: SensorTopics, wanted: str | None
) -> dict[str, tuple[str, list[Sensor]]]:
    """Type and sensors of each topic that the bag has to have; raises BagError."""
    expected: dict[str, tuple[str, list[Sensor]]] = {}
    for name, carried in topics.inertial.items():
        expected[resolved(name)] = (IMU, carried)
    for name, carried in topics.joints.items():
        place = resolved(name)
        if name == SENSOR_STATES and (wanted is not None or place not in source.topics):
            place = input_topic(source, wanted)
        expected.setdefault(place, (JOINT_STATE, []))[1].extend(carried)
    for name, (kind, carried) in expected.items():
        listed = source.topics.get(name)
        if listed is None or listed.kind != kind:
            names = ", ".join(sensor.name for sensor in carried)
            others = [entry.name for entry in source.topics.values() if entry.kind == kind]
            has = ", ".join(others) or "none"
            raise BagError(
                f"{source.path}: there is no {kind} on {name} for {names}; topics of this type:"
                f" {has}. Name the topic in the file of sensors"
            )
    return expected


def _readings(kind: str, carried: Sequence[Sensor], data: bytes) -> list[SensorReading]:
    message = deserialize(data, kind)
    if kind == IMU:
        return inertial_readings(carried, sample_of_imu(message))
    sample = sample_of_state(message)
    if sample.stamp_ns < 0:
        text = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
        raise RejectedError(RejectionCode.BAD_STAMP, text)
    return joint_readings(carried, sample)


def _data(
    readings: Sequence[SensorReading], sensors: Sequence[Sensor], losses: Sequence[str]
) -> SensorData:
    """The readings by sensor."""
    first = min(reading.stamp_ns for reading in readings)
    by_sensor = {}
    for sensor in sensors:
        of_sensor = [reading for reading in readings if reading.sensor == sensor.name]
        if of_sensor:
            stamps = np.array([reading.stamp_ns - first for reading in of_sensor])
            values = np.stack([reading.values for reading in of_sensor])
            by_sensor[sensor.name] = (stamps * SECOND, values)
    return SensorData(by_sensor, (), tuple(losses))
