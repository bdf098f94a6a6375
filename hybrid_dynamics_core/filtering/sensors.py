"""Sensors of a machine: what each reads, and how well."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from .. import programs
from ..closed_state.state import ClosedState
from ..description.geometry import Transform
from ..description.model import Frame
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import no_such_name
from ..programs import Program
from ..robot.robot import Robot


class Kind(StrEnum):
    """What a sensor reads."""

    GYRO = "gyro"  # angular velocity [rad/s], in its axes
    ACCELEROMETER = "accelerometer"  # acceleration less gravity [m/s^2], in its axes
    INCLINOMETER = "inclinometer"  # angle of its x axis above horizontal, about its z axis [rad]
    ENCODER = "encoder"  # an angle between links [rad]
    STROKE = "stroke"  # the position of a slide or cylinder [m]
    RATE = "rate"  # the rate of a joint [rad/s, m/s]


SPATIAL = (Kind.GYRO, Kind.ACCELEROMETER)
AT_JOINTS = (Kind.ENCODER, Kind.STROKE, Kind.RATE)
AXES = 3


@dataclass(frozen=True)
class Quality:
    """Errors of a sensor.

    Attributes:
        noise: deviation of a single reading, in the unit of the sensor.
        bias: deviation of its constant error before anything is known of it; 0 for none.
        walk: growth of its constant error, in the unit of the sensor for each root of a second.
    """

    noise: float
    bias: float = 0.0
    walk: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.noise < math.inf:
            raise InputError(f"noise is {self.noise:g}; expected a finite number above zero")
        for name, value in (("bias", self.bias), ("walk", self.walk)):
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} is {value:g}; expected a finite number, 0 for none")

    @classmethod
    def from_density(
        cls,
        density: float,
        rate: float,
        bias: float = 0.0,
        walk: float = 0.0,
    ) -> Quality:
        """The quality of a part with the noise density of its data sheet.

        Args:
            density: noise density, in the unit of the sensor for each root of a hertz.
            rate: readings per second [Hz]; noise above half of it is filtered.
            bias: as in `Quality`.
            walk: as in `Quality`.
        """
        return cls(density * math.sqrt(rate / 2.0), bias, walk)


class Observation(NamedTuple):
    """What a sensor should read at a state.

    Attributes:
        readings: (k,) in its unit.
        slopes: (k, 3 n) along [u; u'; u''].
    """

    readings: Array
    slopes: Array


@dataclass(frozen=True, eq=False)
class Sensor:
    """A sensor of one machine.

    Attributes:
        name: its name.
        kind: what it reads.
        robot: the robot that carries it.
        program: computes its readings.
        quality: its errors.
        place: the frame or joint that carries it.
        channels: number of its readings.
        is_angle: whether readings repeat after a turn.
        topic: topic of its messages; empty for none.
    """

    name: str
    kind: Kind
    robot: Robot = field(repr=False)
    program: Program = field(repr=False)
    quality: Quality
    place: str
    channels: int = 1
    is_angle: bool = False
    topic: str = ""
    key: str = field(default="", repr=False)

    @property
    def has_bias(self) -> bool:
        """Whether its constant error is estimated."""
        return self.quality.bias > 0.0 or self.quality.walk > 0.0

    def observe(
        self,
        state: ClosedState,
        ddu: Array,
        du: Array | None = None,
    ) -> Observation:
        """What it should read at a closed state.

        Args:
            state: the state.
            ddu: active accelerations (n,) [rad/s^2, m/s^2].
            du: active rates (n,) [rad/s, m/s]; those of the state if None.
        """
        kernel = self.robot.kernel(self.key, self.program)
        gravity = self.robot.loads.gravity
        rates = state.du if du is None else du
        inputs = {"u": state.u, "du": rates, "ddu": ddu, "branch": state.signs}
        inputs |= {"guess": state.s, "gravity": gravity}
        values, _ = kernel(*[inputs[name] for name in self.program.inputs])
        return Observation(values["readings"], values["slopes"])

    def curvature(
        self,
        state: ClosedState,
        ddu: Array,
    ) -> Array:
        """Second derivatives (k, n, n) of its readings along the active rates.

        Accelerations are quadratic in the rates, so differences of slopes are exact.
        """
        n = state.n
        along_rates = slice(n, 2 * n)
        still = np.zeros(n)
        first = self.observe(state, ddu, still).slopes[:, along_rates]
        slopes = [self.observe(state, ddu, unit).slopes[:, along_rates] for unit in np.eye(n)]
        return np.stack(slopes, axis=2) - first[:, :, None]

    def difference(
        self,
        values: Array,
        expected: Array,
    ) -> Array:
        """Readings less those that were expected (k,)."""
        change = values - expected
        if self.is_angle:
            return np.asarray(change - math.tau * np.rint(change / math.tau))
        return change

    def on_topic(self, topic: str) -> Sensor:
        """The same sensor with a topic."""
        return replace(self, topic=topic)


def sensor_on_frame(
    robot: Robot,
    name: str,
    kind: Kind,
    frame: str,
    quality: Quality,
    pose: Transform | None = None,
) -> Sensor:
    """A gyro, accelerometer or inclinometer.

    Args:
        robot: the robot.
        name: name of the sensor.
        kind: its kind.
        frame: frame or link that carries it.
        quality: its errors.
        pose: of the sensor in that frame; None for the frame itself.

    Raises:
        InputError: there is no such frame, it is on the base, or the kind belongs to a joint.
    """
    if kind in AT_JOINTS:
        raise InputError(f"{name}: the kind {kind} belongs to a joint; give its joint")
    mount = mount_on(robot, frame, pose or Transform())
    if mount.link == robot.base_frame:
        raise InputError(f"{name}: '{frame}' is on the base, which does not move")
    makers = {
        Kind.GYRO: programs.sensing.angular_rate,
        Kind.ACCELEROMETER: programs.sensing.specific_force,
        Kind.INCLINOMETER: programs.sensing.inclination,
    }
    channels = AXES if kind in SPATIAL else 1
    numbers = [*mount.rotation.ravel().tolist(), *mount.translation.tolist()]
    key = f"{kind} {mount.link} {numbers}"
    is_angle = kind is Kind.INCLINOMETER
    program = makers[kind](mount)
    return Sensor(name, kind, robot, program, quality, frame, channels, is_angle, key=key)


def sensor_on_joint(
    robot: Robot,
    name: str,
    kind: Kind,
    joint: str,
    quality: Quality,
) -> Sensor:
    """An encoder, a stroke sensor or a sensor of a joint's rate.

    Args:
        robot: the robot.
        name: name of the sensor.
        kind: its kind.
        joint: the coordinate, active or passive.
        quality: its errors.

    Raises:
        InputError: there is no such joint, or the kind does not suit it.
    """
    if joint not in robot.coordinates:
        raise InputError(f"{name}: {no_such_name('joint', joint, robot.coordinates)}")
    joint_type = robot.joint_types[joint]
    suits = {Kind.ENCODER: ("revolute",), Kind.STROKE: ("prismatic",)}
    if joint_type not in suits.get(kind, (joint_type,)):
        raise InputError(f"{name}: a sensor of kind {kind} does not suit a {joint_type} joint")
    if kind not in AT_JOINTS:
        raise InputError(f"{name}: the kind {kind} belongs to a frame; give its frame")
    index = robot.coordinates.index(joint)
    key = f"{kind} {joint}"
    if kind is Kind.RATE:
        return Sensor(name, kind, robot, programs.sensing.rate(index), quality, joint, key=key)
    key = f"position {joint}"
    program = programs.sensing.position(index)
    is_angle = kind is Kind.ENCODER
    return Sensor(name, kind, robot, program, quality, joint, 1, is_angle, key=key)


def imu(
    robot: Robot,
    name: str,
    frame: str,
    gyro: Quality,
    accelerometer: Quality,
    pose: Transform | None = None,
) -> tuple[Sensor, Sensor]:
    """The two sensors of an inertial measurement unit: NAME.gyro and NAME.accelerometer.

    Args:
        robot: the robot.
        name: name of the unit.
        frame: frame or link that carries it.
        gyro: errors of its gyro [rad/s].
        accelerometer: errors of its accelerometer [m/s^2].
        pose: of the unit in that frame; None for the frame itself.

    Raises:
        InputError: there is no such frame, or it is on the base.
    """
    turning = sensor_on_frame(robot, f"{name}.gyro", Kind.GYRO, frame, gyro, pose)
    moving = sensor_on_frame(
        robot, f"{name}.accelerometer", Kind.ACCELEROMETER, frame, accelerometer, pose
    )
    return turning, moving


def mount_on(
    robot: Robot,
    name: str,
    pose: Transform,
) -> Frame:
    """The frame of a sensor at a pose on a frame or link.

    Raises:
        InputError: there is no such frame.
    """
    description = robot.description
    names = (*description.frames, *description.links)
    if name not in names:
        raise InputError(no_such_name("frame", name, names))
    carrier = description.frames.get(name, Frame(name))
    rotation = np.asarray(carrier.rotation)
    place = carrier.translation + rotation @ pose.translation
    return Frame(carrier.link, frozen(rotation @ pose.rotation), frozen(place))
