"""The floating base of a robot, and its motion from odometry.

The base has estimates of its own, from the stamps of its messages alone. So neither the rate of
joint states nor their order among those of the base changes them.
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
_UNIT: Final = 0.01  # from 1, of the length of a quaternion that is taken


@dataclass(frozen=True, eq=False)
class FloatingBase:
    """A free joint on the base link that nobody drives.

    Attributes:
        joint: its name.
        link: the link that it carries.
        places: its six coordinates among the active ones.
        zero: where the link stands at zero, in the base frame.
    """

    joint: str
    link: str
    places: tuple[int, ...]
    zero: Pose

    def at(self, position: FloatArray, rotation: FloatArray) -> Pose:
        """The pose that the joint has where the link is at a pose in the base frame."""
        turned = self.zero.rotation.T
        return Pose(turned @ (position - self.zero.position), turned @ rotation)

    def at_rest(self, robot: Robot) -> BaseMotion:
        """At the reference, without motion."""
        pose = robot.joint_pose(robot.close(robot.reference), self.joint)
        return BaseMotion(0, pose, np.zeros(TWIST), np.zeros(TWIST))


def floating_base(robot: Robot) -> FloatingBase | None:
    """The floating base of a robot; None where it has none."""
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
    """How the base moves at one stamp.

    Attributes:
        stamp_ns: stamp [ns].
        pose: of its joint.
        twist: linear and angular velocity in the axes of its link (6,) [m/s, rad/s].
        acceleration: rates of these six numbers (6,) [m/s^2, rad/s^2]; None while they are not
            known.
    """

    stamp_ns: int
    pose: Pose
    twist: FloatArray
    acceleration: FloatArray | None


class OdometryInput:
    """Takes odometry of the base, and remembers the newest.

    Attributes:
        base: of the robot.
        topic: where odometry comes from, for texts.
        newest: motion at the newest message; None before the first.
        max_age: how far its stamp may be from that of a joint state [s].
        link: what messages call the link of the base, where they name it.
    """

    def __init__(self, base: FloatingBase, topic: str, link: str, max_age: float) -> None:
        """Nothing was measured yet.

        Args:
            base: of the robot.
            topic: where odometry comes from.
            link: what messages call the link of the base.
            max_age: how far stamps may be from that of a joint state [s].
        """
        self.base = base
        self.topic = topic
        self.newest: BaseMotion | None = None
        self.max_age = max_age
        self.link = link
        self._estimator: MotionEstimator | None = None
        self._state: EstimatorState | None = None
        self._way = np.zeros(TWIST)  # what the twist adds up to [m, rad]

    def set_filter(self, estimator: MotionEstimator) -> None:
        """Estimate accelerations so from now on; the estimates start anew."""
        self._estimator = estimator
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self.newest = None
        self._state = None
        self._way = np.zeros(TWIST)

    def take(self, sample: OdometrySample) -> None:
        """Take a message.

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
            RejectedError: there is none so near.
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
        """What the twist adds up to by then; filters that take positions too need it (6,)."""
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
