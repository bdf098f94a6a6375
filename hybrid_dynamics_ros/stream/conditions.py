"""Conditions of a robot that may change: gravity, payloads and assembly modes.

They are plain data, and are sent to worker processes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Payload, Robot

from ..messages.joint_samples import Calibration
from ..parameters import (
    FILTER_TYPE,
    GRAVITY,
    KALMAN,
    KALMAN_BANDWIDTH,
    MEASURED,
    MEASURED_POSES,
    ODOMETRY,
    PARTIAL_AGE,
    PAYLOAD_COM,
    PAYLOAD_FRAME,
    PAYLOAD_INERTIA,
    PAYLOAD_MASS,
    VELOCITY_NOISE,
    NodeSettings,
    Parameter,
    ParameterError,
    sensor_rows,
)
from .estimates.payload import PayloadInput
from .filter.routes import Kalman
from .floating.base import (
    JointPoseInput,
    PoseInput,
    PoseInputs,
    floating_base,
    posed_joint,
)
from .frames import frame_names

Floats = tuple[float, ...]


@dataclass(frozen=True)
class PayloadBody:
    """A payload in frame axes.

    Attributes:
        mass: mass [kg].
        com: centre of mass (3,) [m].
        inertia: inertia about the centre of mass: xx, xy, xz, yy, yz, zz [kg m^2].
    """

    mass: float
    com: Floats
    inertia: Floats


_PAYLOAD: Final[tuple[Parameter[Any], ...]] = (
    PAYLOAD_FRAME,
    PAYLOAD_MASS,
    PAYLOAD_COM,
    PAYLOAD_INERTIA,
)
NO_PAYLOAD: Final = PayloadBody(0.0, (0.0,) * 3, (0.0,) * 6)


@dataclass(frozen=True)
class Conditions:
    """The present conditions.

    Attributes:
        gravity: (3,) [m/s^2]; None for that of the robot file.
        payloads: payloads by frame.
        mode: a state whose assembly modes are kept; None for those of the robot file.
    """

    gravity: Floats | None = None
    payloads: Mapping[str, PayloadBody] = field(default_factory=dict)
    mode: ClosedState | None = None

    def with_payload(self, frame: str, body: PayloadBody) -> Conditions:
        """These conditions with a payload at a frame. A payload without mass removes it."""
        payloads = dict(self.payloads)
        payloads.pop(frame, None)
        if body.mass > 0.0:
            payloads[frame] = body
        return replace(self, payloads=payloads)

    def with_settings(
        self, settings: NodeSettings, before: NodeSettings | None, end_effector: str
    ) -> Conditions:
        """These conditions with gravity and payload of the parameters.

        Values set by calls are kept if the parameters did not change.

        Args:
            settings: the parameters.
            before: the previous parameters, or None.
            end_effector: default frame of the payload.
        """
        changed = replace(self, gravity=settings[GRAVITY])
        if before is not None:
            if all(settings[row] == before[row] for row in _PAYLOAD):
                return changed
            changed = changed.with_payload(before[PAYLOAD_FRAME] or end_effector, NO_PAYLOAD)
        body = PayloadBody(settings[PAYLOAD_MASS], settings[PAYLOAD_COM], settings[PAYLOAD_INERTIA])
        return changed.with_payload(settings[PAYLOAD_FRAME] or end_effector, body)


@dataclass(frozen=True)
class NewPayload:
    """A change by a call: another payload at a frame."""

    frame: str
    body: PayloadBody

    def applied(self, conditions: Conditions) -> Conditions:
        """The conditions after the change."""
        return conditions.with_payload(self.frame, self.body)

    @property
    def text(self) -> str:
        """Description for the log."""
        if self.body.mass > 0.0:
            return f"{self.body.mass:g} kg at {self.frame}"
        return f"nothing at {self.frame}"


@dataclass(frozen=True)
class NewMode:
    """A change by a call: the assembly modes of a closed state."""

    mode: ClosedState

    def applied(self, conditions: Conditions) -> Conditions:
        """The conditions after the change."""
        return replace(conditions, mode=self.mode)

    @property
    def text(self) -> str:
        """Description for the log."""
        return ", ".join(f"{loop} {name}" for loop, name in self.mode.branch.items())


@dataclass(frozen=True)
class NewZero:
    """A change by a call: the newest motion is one of the empty tool, or that one is forgotten."""

    is_cleared: bool

    def applied(self, conditions: Conditions) -> Conditions:
        """The conditions after the change, the same."""
        return conditions

    def zero(self, scale: PayloadInput) -> None:
        """Apply the change to the input of weighing."""
        if self.is_cleared:
            scale.clear()
        else:
            scale.zero()

    @property
    def text(self) -> str:
        """Description for the log."""
        return "forgotten" if self.is_cleared else "the newest motion is one of the empty tool"


ConditionChange = NewPayload | NewMode | NewZero


def loads_of(robot: Robot, conditions: Conditions) -> Loads:
    """The loads on the robot under the conditions.

    Raises:
        InputError: a frame is unknown, or an inertia is impossible.
    """
    loads = robot.loads
    if conditions.gravity is not None:
        loads = loads.with_gravity(conditions.gravity)
    for frame, body in conditions.payloads.items():
        xx, xy, xz, yy, yz, zz = body.inertia
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        loads = loads.with_payload(Payload(body.mass, body.com, inertia), frame)
    return loads


def kalman_of(settings: NodeSettings) -> Kalman | None:
    """Settings of the Kalman filter; None for polynomial filters."""
    if settings[FILTER_TYPE] != KALMAN:
        return None
    return Kalman(settings[KALMAN_BANDWIDTH], settings[VELOCITY_NOISE])


def calibration_of(settings: NodeSettings, joints: tuple[str, ...]) -> Calibration | None:
    """Calibration of the sensors; None if they read the coordinates themselves."""
    rows = [_sensor(settings, joint) for joint in joints]
    offset, sign, scale = np.array(rows, dtype=np.float64).T
    factor = sign * scale
    if not offset.any() and (factor == 1.0).all():
        return None
    return Calibration(offset, factor)


def _sensor(settings: NodeSettings, joint: str) -> list[float]:
    """Offset, sign and scale."""
    return [settings[parameter] for parameter in sensor_rows(joint)]


def poses_of(robot: Robot, settings: NodeSettings) -> PoseInputs:
    """The inputs of poses that the parameters enable.

    Raises:
        ParameterError: a parameter does not fit the robot.
    """
    return PoseInputs(odometry_of(robot, settings), joint_poses_of(robot, settings))


def odometry_of(robot: Robot, settings: NodeSettings) -> PoseInput | None:
    """The input of odometry, if the parameters enable it; otherwise None.

    Raises:
        ParameterError: the base is not floating, or the measured joints are not the active ones.
    """
    topic = settings[ODOMETRY]
    if not topic:
        return None
    base = floating_base(robot)
    if base is None:
        raise ParameterError(
            f"parameter {ODOMETRY.name} is '{topic}': robot {robot.name} has no floating base, a"
            f" free joint on '{robot.base_frame}' that nobody drives; leave it empty"
        )
    if settings[MEASURED] not in (None, robot.active):
        raise ParameterError(
            f"parameter {ODOMETRY.name} is '{topic}': with odometry the active joints are measured,"
            f" {', '.join(robot.description.motors)}; leave {MEASURED.name} empty"
        )
    link = frame_names(robot, settings).of(base.link)
    return PoseInput(base, topic, link, settings[PARTIAL_AGE])


def joint_poses_of(robot: Robot, settings: NodeSettings) -> JointPoseInput | None:
    """The input of poses of ball and free joints, if the parameters name some; otherwise None.

    Raises:
        ParameterError: there is no such joint, it follows from others, or odometry has it already.
    """
    names = settings[MEASURED_POSES]
    if not names:
        return None
    if settings[MEASURED] not in (None, robot.active):
        text = f"with poses the active joints are measured; leave {MEASURED.name} empty"
        raise ParameterError(f"parameter {MEASURED_POSES.name}: {text}")
    base = floating_base(robot) if settings[ODOMETRY] else None
    joints = []
    for name in names:
        joint = posed_joint(robot, name)
        problem = ""
        if joint is None:
            balls = [one.name for one in robot.description.freely_turning]
            active = ", ".join(one for one in balls if posed_joint(robot, one) is not None)
            problem = f"no ball or free joint that is active; there are: {active or 'none'}"
        elif names.count(name) > 1:
            problem = "named twice"
        elif base is not None and base.joint == name:
            problem = f"measured by {ODOMETRY.name} already"
        if joint is None or problem:
            raise ParameterError(f"parameter {MEASURED_POSES.name}: '{name}' is {problem}")
        joints.append(joint)
    return JointPoseInput(joints, "~/active_joint_poses", settings[PARTIAL_AGE])
