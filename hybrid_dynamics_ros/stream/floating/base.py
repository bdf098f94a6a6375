"""The floating base of a robot, and its motion from odometry.

The base has its own estimates, from the stamps of its messages only. So they depend neither on the
rate of joint states, nor on the order of both kinds of messages.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from hybrid_dynamics_core import Pose, Robot
from hybrid_dynamics_core.algebra.rotations import rotation_matrix

from ...messages.joint_samples import LARGEST, FloatArray, RejectedError, RejectionCode
from ...messages.odometry import OdometrySample
from ..filter.rate_estimator import EstimatorState, MotionEstimator

TWIST: Final = 6  # numbers of a twist
_UNIT: Final = 0.01  # largest deviation of a quaternion's norm from 1


@dataclass(frozen=True, eq=False)
class FloatingBase:
    """A free joint on the base link without a drive.

    Attributes:
        joint: its name.
        link: the link that it carries.
        places: indices of its six coordinates among the active ones.
        zero: pose of the link at zero, in the base frame.
    """

    joint: str
    link: str
    places: tuple[int, ...]
    zero: Pose

    def at(self, position: FloatArray, rotation: FloatArray) -> Pose:
        """The joint's pose for a pose of the link in the base frame."""
        turned = self.zero.rotation.T
        return Pose(turned @ (position - self.zero.position), turned @ rotation)

    def at_rest(self, robot: Robot) -> BaseMotion:
        """The motion at rest at the reference."""
        pose = robot.joint_pose(robot.close(robot.reference), self.joint)
        return BaseMotion(0, pose, np.zeros(TWIST), np.zeros(TWIST))


def floating_base(robot: Robot) -> FloatingBase | None:
    """The floating base of a robot, or None."""
    description = robot.description
    for joint in description.freely_turning:
        rows = [description.joints[name] for name in joint.joints]
        is_on_base = joint.type == "free" and rows[0].parent == robot.base_frame
        if is_on_base and set(joint.joints) <= set(robot.idle):
            state = robot.close(robot.reference)
            link = rows[-1].child
            placed = robot.forward_kinematics(state, link)
            moved = robot.joint_pose(state, joint.name)
            rotation = placed.rotation @ moved.rotation.T
            zero = Pose(placed.position - rotation @ moved.position, rotation)
            places = tuple(map(robot.active.index, joint.joints))
            return FloatingBase(joint.name, link, places, zero)
    return None


class BaseMotion(NamedTuple):
    """Motion of the base at one stamp.

    Attributes:
        stamp_ns: stamp [ns].
        pose: pose of its joint.
        twist: linear and angular velocity in the axes of its link (6,) [m/s, rad/s].
        acceleration: time derivatives of these six numbers (6,) [m/s^2, rad/s^2]; None if unknown.
    """

    stamp_ns: int
    pose: Pose
    twist: FloatArray
    acceleration: FloatArray | None


class OdometryInput:
    """Receives odometry of the base, and stores the newest.

    Attributes:
        base: the floating base of the robot.
        topic: topic of odometry, for texts.
        newest: motion at the newest message; None before the first.
        max_age: largest difference to the stamp of a joint state [s].
        link: name of the base's link in messages.
    """

    def __init__(self, base: FloatingBase, topic: str, link: str, max_age: float) -> None:
        """Start without measurements.

        Args:
            base: the floating base of the robot.
            topic: topic of odometry.
            link: name of the base's link in messages.
            max_age: largest difference to the stamp of a joint state [s].
        """
        self.base = base
        self.topic = topic
        self.newest: BaseMotion | None = None
        self.max_age = max_age
        self.link = link
        self._estimator: MotionEstimator | None = None
        self._state: EstimatorState | None = None
        self._way = np.zeros(TWIST)  # integral of the twist [m, rad]

    def set_filter(self, estimator: MotionEstimator) -> None:
        """Set the estimator of accelerations; the estimates restart."""
        self._estimator = estimator
        self.clear()

    def clear(self) -> None:
        """Discard all messages."""
        self.newest = None
        self._state = None
        self._way = np.zeros(TWIST)

    def take(self, sample: OdometrySample) -> None:
        """Store a message.

        Raises:
            RejectedError: the stamp is negative, the message is of another link, a number is not
                finite, or the orientation is no unit quaternion.
        """
        self._check(sample)
        way = self._way_to(sample)
        acceleration = None
        state = self._state
        if self._estimator is not None:
            state, rates = self._estimator.step(state, sample.stamp_ns, way, sample.twist)
            acceleration = rates.acceleration
        pose = self.base.at(sample.position, rotation_matrix(sample.orientation))
        self._state, self._way = state, way
        self.newest = BaseMotion(sample.stamp_ns, pose, sample.twist, acceleration)

    def at(self, stamp_ns: int) -> BaseMotion:
        """The motion of the base for a joint state at a stamp [ns].

        Raises:
            RejectedError: no message is near enough.
        """
        newest = self.newest
        if newest is None or abs(stamp_ns - newest.stamp_ns) * 1e-9 > self.max_age:
            age = "none has come yet"
            if newest is not None:
                age = f"the newest is {(stamp_ns - newest.stamp_ns) * 1e-9:.3g} s older"
            raise RejectedError(
                RejectionCode.MISSING_JOINT,
                f"{self.base.joint}: no odometry on {self.topic} within {self.max_age:g} s: {age}",
            )
        return newest

    def _way_to(self, sample: OdometrySample) -> FloatArray:
        """Integral of the twist up to a sample (6,), as position for filters that use positions."""
        if self.newest is None:
            return self._way
        elapsed = (sample.stamp_ns - self.newest.stamp_ns) * 1e-9
        return self._way + 0.5 * elapsed * (self.newest.twist + sample.twist)

    def _check(self, sample: OdometrySample) -> None:
        if sample.stamp_ns < 0:
            text = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
            raise RejectedError(RejectionCode.BAD_STAMP, text)
        if sample.link not in ("", self.link):
            raise RejectedError(
                RejectionCode.MISSING_JOINT,
                f"odometry of '{sample.link}' (child_frame_id), expected that of '{self.link}', the"
                " floating base",
            )
        values = np.concatenate([sample.position, sample.orientation, sample.twist])
        if not (np.abs(values) <= LARGEST).all():
            text = f"odometry has numbers that are not finite, or beyond {LARGEST:g}"
            raise RejectedError(RejectionCode.NOT_FINITE, text)
        length = float(np.linalg.norm(sample.orientation))
        if abs(length - 1.0) > _UNIT:
            raise RejectedError(
                RejectionCode.NOT_FINITE,
                f"orientation is no unit quaternion: its length is {length:.3g}",
            )
