"""Sensors of a machine from a YAML file: kinds, places, errors, and how the machine may move."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..description.document import Document
from ..description.entries import Entry, section_entries, section_entry
from ..description.files import read_text
from ..description.located_yaml import read_yaml
from ..description.values import ValueReader
from ..errors import DescriptionError, InputError
from ..ground.suggestions import no_such_name, suggestion
from ..robot.robot import Robot
from .motion_model import MotionModel
from .sensors import AT_JOINTS, Kind, Quality, Sensor, imu, sensor_on_frame, sensor_on_joint

IMU = "imu"
KINDS = (IMU, *Kind)
CORRELATION = 0.5  # [s] of accelerations
ANGULAR = 1.0  # [rad/s^2] deviation of an angular acceleration
LINEAR = 0.5  # [m/s^2] deviation of the acceleration of a slide or cylinder
TOP = ("parameters", "sensors", "motion")
MOTION = ("correlation_time", "accelerations")
ERRORS = ("noise", "density", "bias", "walk")
PLACED = ("kind", "frame", "origin", "rate", "topic")


@dataclass(frozen=True, eq=False)
class SensorSet:
    """Sensors of a machine, and how it may move.

    Attributes:
        sensors: the sensors; an IMU has two.
        motion: the model of the motion between readings.
    """

    sensors: tuple[Sensor, ...]
    motion: MotionModel


def read_sensors(
    path: str | Path,
    robot: Robot,
) -> SensorSet:
    """The sensors of a YAML file.

    Args:
        path: the file.
        robot: the robot that carries them.

    Raises:
        DescriptionError: an entry is unknown, missing or wrong; it names file and line.
    """
    place = Path(path)
    return sensors_from(read_yaml(read_text(place), place), robot)


def sensors_from_text(
    text: str,
    robot: Robot,
) -> SensorSet:
    """The sensors of a YAML text; raises as `read_sensors` does."""
    return sensors_from(read_yaml(text), robot)


def sensors_from(
    document: Document,
    robot: Robot,
) -> SensorSet:
    """The sensors of a document; raises as `read_sensors` does."""
    _require_mappings(document)
    _require_allowed(document, document.data, (), TOP)
    values = ValueReader(document)
    sensors: list[Sensor] = []
    for entry in section_entries(values, "sensors").values():
        try:
            sensors += _sensors_of(entry, robot)
        except InputError as error:
            raise document.error(entry.path, str(error)) from error
    if not sensors:
        raise document.error(("sensors",), "there is no sensor; expected NAME: {kind: ...}")
    return SensorSet(tuple(sensors), _motion(section_entry(values, "motion"), robot))


def default_motion(robot: Robot) -> MotionModel:
    """How a machine may move of which nothing is said."""
    deviations: list[float] = []
    for name in robot.active:
        is_turn = robot.joint_types[name] == "revolute"
        deviations.append(ANGULAR if is_turn else LINEAR)
    return MotionModel(np.array(deviations), CORRELATION)


def _motion(
    entry: Entry,
    robot: Robot,
) -> MotionModel:
    document = entry.values.document
    _require_allowed(document, entry.data, entry.path, MOTION)
    usual = default_motion(robot)
    given = entry.sub("accelerations")
    _require_allowed(document, given.data, given.path, robot.active)
    deviations: list[float] = []
    for name, deviation in zip(robot.active, usual.accelerations.tolist(), strict=True):
        deviations.append(given.number(name, deviation))
    try:
        return MotionModel(np.array(deviations), entry.number("correlation_time", usual.time))
    except InputError as error:
        raise document.error(entry.path, str(error)) from error


def _sensors_of(
    entry: Entry,
    robot: Robot,
) -> tuple[Sensor, ...]:
    """The sensors of one entry."""
    document = entry.values.document
    name = str(entry.path[-1])
    kind = _required(entry, "kind", f"one of {', '.join(KINDS)}")
    if kind not in KINDS:
        raise entry.error("kind", no_such_name("kind", str(kind), KINDS))
    topic = str(entry.get("topic", ""))
    if kind in AT_JOINTS:
        keys = ("kind", "joint", "rate", "topic", *ERRORS)
        _require_allowed(document, entry.data, entry.path, keys)
        joint = str(_required(entry, "joint", "the name of a joint"))
        sensor = sensor_on_joint(robot, name, Kind(kind), joint, _quality(entry, entry))
        return (sensor.on_topic(topic),)
    frame = str(_required(entry, "frame", "the name of a frame or link"))
    pose = entry.pose("origin")
    if kind == IMU:
        parts = (str(Kind.GYRO), str(Kind.ACCELEROMETER))
        _require_allowed(document, entry.data, entry.path, (*PLACED, *parts))
        qualities: dict[str, Quality] = {}
        for part in parts:
            _required(entry, part, "{noise: ...} or {density: ...}")
            inner = entry.sub(part)
            _require_allowed(document, inner.data, inner.path, (*ERRORS, "rate"))
            qualities[part] = _quality(inner, entry)
        gyro, accelerometer = qualities.values()
        turning, moving = imu(robot, name, frame, gyro, accelerometer, pose)
        return turning.on_topic(topic), moving.on_topic(topic)
    _require_allowed(document, entry.data, entry.path, (*PLACED, *ERRORS))
    quality = _quality(entry, entry)
    sensor = sensor_on_frame(robot, name, Kind(kind), frame, quality, pose)
    return (sensor.on_topic(topic),)


def _quality(
    entry: Entry,
    outer: Entry,
) -> Quality:
    """The errors of a sensor; the rate of readings may stand in the entry around."""
    bias, walk = entry.number("bias"), entry.number("walk")
    has_noise, has_density = "noise" in entry, "density" in entry
    if has_noise == has_density:
        problem = "expected either noise (of a reading), or density (of a data sheet) and rate"
        raise entry.values.document.error(entry.path, problem)
    if has_noise:
        return Quality(entry.number("noise"), bias, walk)
    with_rate = entry if "rate" in entry else outer
    _required(with_rate, "rate", "the readings per second [Hz] that a density needs")
    rate = with_rate.number("rate")
    if rate <= 0.0:
        raise with_rate.error("rate", f"is {rate:g}; expected readings per second")
    return Quality.from_density(entry.number("density"), rate, bias, walk)


def _required(
    entry: Entry,
    key: str,
    expected: str,
) -> Any:
    if key not in entry:
        problem = f"no '{key}'; expected {expected}"
        raise entry.values.document.error(entry.path, problem)
    return entry[key]


def _require_allowed(
    document: Document,
    data: Any,
    path: tuple[str | int, ...],
    keys: Iterable[str],
) -> None:
    """Raise DescriptionError for an unknown key."""
    allowed = tuple(keys)
    for key in data:
        if key not in allowed:
            problem = f"unknown key{suggestion(key, allowed)}; expected {', '.join(allowed)}"
            raise document.error((*path, key), problem)


def _require_mappings(document: Document) -> None:
    """Raise DescriptionError where a mapping is expected and is not."""
    data = document.data
    if not isinstance(data, dict):
        raise DescriptionError("expected a mapping with the key sensors", file=document.file)
    for section in TOP:
        _require_mapping(document, (section,), data.get(section) or {})
    for name, entry in document.entries("sensors").items():
        path = ("sensors", name)
        _require_mapping(document, path, entry)
        for part in (str(Kind.GYRO), str(Kind.ACCELEROMETER)):
            _require_mapping(document, (*path, part), entry.get(part, {}))
    accelerations = document.entries("motion").get("accelerations", {})
    _require_mapping(document, ("motion", "accelerations"), accelerations)


def _require_mapping(
    document: Document,
    path: tuple[str, ...],
    entry: Any,
) -> None:
    if not isinstance(entry, dict):
        raise document.error(path, f"is {entry!r}; expected a mapping")
