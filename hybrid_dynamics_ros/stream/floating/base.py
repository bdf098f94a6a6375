"""Ball and free joints that are measured by poses: a floating base by odometry, and others.

Each has its own estimates, from the stamps of its messages only. So they depend neither on the rate
of joint states, nor on the order of both kinds of messages.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from hybrid_dynamics_core import Pose, Robot
from hybrid_dynamics_core.algebra.rotations import rotation_matrix

from ...messages.joint_samples import LARGEST, FloatArray, RejectedError, RejectionCode
from ...messages.odometry import OdometrySample
from ..filter.rate_estimator import EstimatorState, MotionEstimator

_UNIT: Final = 0.01  # largest deviation of a quaternion's norm from 1


@dataclass(frozen=True, eq=False)
class PosedJoint:
    """A ball or free joint whose pose and twist are measured.

    Attributes:
        joint: its name.
        link: the link that it carries.
        places: indices of its three or six coordinates among the active ones.
        zero: pose of the link at zero, in the frame of the measured poses.
    """

    joint: str
    link: str
    places: tuple[int, ...]
    zero: Pose

    @property
    def size(self) -> int:
        """Numbers of its twist: six, or the three of the angular velocity of a ball joint."""
        return len(self.places)

    def at(self, position: FloatArray, rotation: FloatArray) -> Pose:
        """The joint's pose for a measured pose."""
        turned = self.zero.rotation.T
        return Pose(turned @ (position - self.zero.position), turned @ rotation)

    def at_rest(self, robot: Robot) -> PosedMotion:
        """The motion at rest at the reference."""
        pose = robot.joint_pose(robot.close(robot.reference), self.joint)
        return PosedMotion(0, pose, np.zeros(self.size), np.zeros(self.size))


def floating_base(robot: Robot) -> PosedJoint | None:
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
            return PosedJoint(joint.name, link, places, zero)
    return None


def posed_joint(robot: Robot, name: str) -> PosedJoint | None:
    """A ball or free joint of active coordinates by its name, or None."""
    for joint in robot.description.freely_turning:
        if joint.name == name and set(joint.joints) <= set(robot.active):
            link = robot.description.joints[joint.joints[-1]].child
            places = tuple(map(robot.active.index, joint.joints))
            return PosedJoint(name, link, places, Pose(np.zeros(3), np.eye(3)))
    return None


class PosedMotion(NamedTuple):
    """Motion of a ball or free joint at one stamp.

    Attributes:
        stamp_ns: stamp [ns].
        pose: its pose.
        twist: linear and angular velocity in the axes of its link (6,) [m/s, rad/s]; (3,) angular
            velocity of a ball joint.
        acceleration: time derivatives of these numbers [m/s^2, rad/s^2]; None if unknown.
    """

    stamp_ns: int
    pose: Pose
    twist: FloatArray
    acceleration: FloatArray | None


class PoseInput:
    """Receives poses and twists of a joint, and stores the newest.

    Attributes:
        joint: the joint.
        topic: topic of the messages, for texts.
        newest: motion at the newest message; None before the first.
        max_age: largest difference to the stamp of a joint state [s].
        link: name of its link in messages; any if empty.
    """

    def __init__(self, joint: PosedJoint, topic: str, link: str, max_age: float) -> None:
        """Start without measurements.

        Args:
            joint: the joint.
            topic: topic of the messages.
            link: name of its link in messages; any if empty.
            max_age: largest difference to the stamp of a joint state [s].
        """
        self.joint = joint
        self.topic = topic
        self.newest: PosedMotion | None = None
        self.max_age = max_age
        self.link = link
        self._estimator: MotionEstimator | None = None
        self._state: EstimatorState | None = None
        self._way = np.zeros(joint.size)  # integral of the twist [m, rad]

    def set_filter(self, estimator: MotionEstimator) -> None:
        """Set the estimator of accelerations; the estimates restart."""
        self._estimator = estimator
        self.clear()

    def clear(self) -> None:
        """Discard all messages."""
        self.newest = None
        self._state = None
        self._way = np.zeros(self.joint.size)

    def take(self, sample: OdometrySample) -> None:
        """Store a message.

        Raises:
            RejectedError: the stamp is negative, the message is of another link, a number is not
                finite, or the orientation is no unit quaternion.
        """
        self._check(sample)
        twist = sample.twist[-self.joint.size :]
        way = self._way_to(sample.stamp_ns, twist)
        acceleration = None
        state = self._state
        if self._estimator is not None:
            state, rates = self._estimator.step(state, sample.stamp_ns, way, twist)
            acceleration = rates.acceleration
        pose = self.joint.at(sample.position, rotation_matrix(sample.orientation))
        self._state, self._way = state, way
        self.newest = PosedMotion(sample.stamp_ns, pose, twist, acceleration)

    def at(self, stamp_ns: int) -> PosedMotion:
        """The motion of the joint for a joint state at a stamp [ns].

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
                f"{self.joint.joint}: no pose on {self.topic} within {self.max_age:g} s: {age}",
            )
        return newest

    def _way_to(self, stamp_ns: int, twist: FloatArray) -> FloatArray:
        """Integral of the twist up to a sample, as position for filters that use positions."""
        if self.newest is None:
            return self._way
        elapsed = (stamp_ns - self.newest.stamp_ns) * 1e-9
        return self._way + 0.5 * elapsed * (self.newest.twist + twist)

    def _check(self, sample: OdometrySample) -> None:
        if sample.stamp_ns < 0:
            text = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
            raise RejectedError(RejectionCode.BAD_STAMP, text)
        if self.link and sample.link not in ("", self.link):
            raise RejectedError(
                RejectionCode.MISSING_JOINT,
                f"odometry of '{sample.link}' (child_frame_id), expected that of '{self.link}', the"
                " floating base",
            )
        values = np.concatenate([sample.position, sample.orientation, sample.twist])
        if not (np.abs(values) <= LARGEST).all():
            text = f"a pose has numbers that are not finite, or beyond {LARGEST:g}"
            raise RejectedError(RejectionCode.NOT_FINITE, text)
        length = float(np.linalg.norm(sample.orientation))
        if abs(length - 1.0) > _UNIT:
            raise RejectedError(
                RejectionCode.NOT_FINITE,
                f"orientation is no unit quaternion: its length is {length:.3g}",
            )


class JointPoseInput:
    """Receives poses of several ball and free joints in one message.

    Attributes:
        topic: topic of the messages.
        inputs: the input of each joint, by its name.
    """

    def __init__(self, joints: Sequence[PosedJoint], topic: str, max_age: float) -> None:
        """Start without measurements; arguments are those of `PoseInput`."""
        self.topic = topic
        self.inputs = {joint.joint: PoseInput(joint, topic, "", max_age) for joint in joints}

    def take(self, samples: Mapping[str, OdometrySample]) -> None:
        """Store a message; joints that are not measured by poses are ignored.

        Raises:
            RejectedError: none of the joints is in it, or as in `PoseInput.take`.
        """
        named = self.inputs.keys() & samples.keys()
        if not named:
            text = f"{', '.join(self.inputs)} not named; named are {', '.join(samples)}"
            raise RejectedError(RejectionCode.MISSING_JOINT, text)
        for name in self.inputs:
            if name in named:
                self.inputs[name].take(samples[name])


@dataclass(frozen=True, eq=False)
class PoseInputs:
    """The inputs of poses of a robot.

    Attributes:
        odometry: odometry of a floating base; None if it stays at its reference.
        joints: poses of other ball and free joints; None if none are measured.
    """

    odometry: PoseInput | None = None
    joints: JointPoseInput | None = None

    @property
    def every(self) -> tuple[PoseInput, ...]:
        """The input of each joint."""
        inputs = []
        if self.odometry is not None:
            inputs.append(self.odometry)
        if self.joints is not None:
            inputs += self.joints.inputs.values()
        return tuple(inputs)

    @property
    def posed(self) -> tuple[PosedJoint, ...]:
        """The joints."""
        return tuple(source.joint for source in self.every)

    def resting(self, robot: Robot) -> dict[str, float]:
        """Reference of the joints' coordinates, which samples need not name [rad or m]."""
        places = [place for joint in self.posed for place in joint.places]
        return {robot.active[place]: float(robot.reference[place]) for place in places}
