"""The output topics: a class for each, with layout and encoding of its messages.

A class encodes the message of one sample for the live node, and the messages of rows for a bag.
Encoding as bytes (`cdr`) costs a fifth of a message object. This module does not depend on ROS.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from hybrid_dynamics_core import CylinderState, Robot
from hybrid_dynamics_core.algebra.rotations import quaternion
from hybrid_dynamics_core.dynamics.reactions import PinReaction

from ..messages.cdr import MessageTemplate
from ..messages.link_transforms import LinkTransforms
from ..parameters import TF_RATE, NodeSettings, Parameter
from .estimates.topics import Contact, Payload, ToolWrench
from .floating.topics import BaseWrench, JointPoses
from .frames import FrameNames, frame_names
from .joint_topics import JointStates, MeasuredEfforts, RequiredEfforts
from .output_topic import Message, OutputTopic, Rows
from .results import MotionResult
from .stroke_margins import StrokeMargins


class ClosedStates(OutputTopic):
    """Residual, assembly modes, distances to singularities, and margins to limits."""

    name, kind = "closed_state", "hybrid_dynamics_msgs/msg/ClosedState"

    def __init__(self, robot: Robot) -> None:
        self._robot, self._strokes = robot, StrokeMargins(robot)
        self._templates: dict[str, MessageTemplate] = {}  # by the loop nearest to its singularity
        self._branch: Mapping[str, str] = {}

    def message(self, result: MotionResult) -> Message:
        """The message; rows must share the loop nearest to its singularity."""
        nearest, loop = result.nearest
        template = self._template(result.branch, loop)
        lower, upper = self._strokes.margins(result.position)
        return template, (result.residual, result.distances, nearest, lower, upper)

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows by the loop nearest to its singularity."""
        if result.distances.shape[-1] < 2:
            return super().groups(result)
        nearest = np.argmin(result.distances, axis=-1)
        return [np.flatnonzero(nearest == k) for k in dict.fromkeys(nearest.tolist())]

    def _template(self, branch: Mapping[str, str], loop: str) -> MessageTemplate:
        if self._branch is not branch and self._branch != branch:
            self._branch = branch
            self._templates.clear()
        if loop not in self._templates:
            self._templates[loop] = self._layout(loop)
        return self._templates[loop]

    def _layout(self, nearest_loop: str) -> MessageTemplate:
        robot, ends = self._robot, self._strokes.joints
        modes = [self._branch.get(loop, "") for loop in robot.loops]
        template = (
            MessageTemplate().header().slot("residual", "<f8").strings(robot.loops).strings(modes)
        )
        template.sequence("singularity", len(robot.loops))
        template.slot("nearest", "<f8").string(nearest_loop)
        return template.strings(ends).sequence("lower", len(ends)).sequence("upper", len(ends))


class EndEffectorPose(OutputTopic):
    """Pose of the end effector in the base frame."""

    name, kind = "end_effector_pose", "geometry_msgs/msg/PoseStamped"

    def __init__(self, names: FrameNames) -> None:
        template = MessageTemplate().header(names.base)
        self._template = template.slot("position", "<f8", 3).slot("quaternion", "<f8", 4)

    def message(self, result: MotionResult) -> Message:
        """Position, and quaternion x y z w."""
        return self._template, (result.pose.position, quaternion(result.pose.rotation))


class EndEffectorTwist(OutputTopic):
    """Velocity of the end effector's origin and angular velocity, in base axes.

    There is no message until rates are known.
    """

    name, kind = "end_effector_twist", "geometry_msgs/msg/TwistStamped"

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        self._robot = robot
        self._template = MessageTemplate().header(names.base).slot("twist", "<f8", 6)

    def message(self, result: MotionResult) -> Message | None:
        """Linear and angular velocity."""
        if result.velocity is None:
            return None
        state = result.state
        twist = self._robot.jacobian(state) @ state.du[..., None]
        return self._template, (twist,)


class LoopReactions(OutputTopic):
    """Force and moment in every pin; no message until accelerations are known."""

    name, kind = "loop_reactions", "hybrid_dynamics_msgs/msg/LoopReactions"

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        self._robot, self._base = robot, names.base
        self._template: MessageTemplate | None = None

    def message(self, result: MotionResult) -> Message | None:
        """Place, and force and moment, of each pin."""
        acceleration = result.active.acceleration
        if acceleration is None or result.velocity is None:
            return None
        pins = self._robot.reactions(result.state, acceleration, result.loads).pins
        if self._template is None:
            self._template = self._layout(pins)
        empty = np.zeros((*acceleration.shape[:-1], 0))
        places, wrenches = [empty], [empty]
        for pin in pins.values():
            places.append(pin.place)
            wrenches += [pin.force, pin.moment]
        return self._template, (np.concatenate(places, -1), np.concatenate(wrenches, -1))

    def _layout(self, pins: Mapping[str, PinReaction]) -> MessageTemplate:
        count = len(pins)
        template = MessageTemplate().header(self._base).strings(list(pins))
        for end in (0, 1):
            template.strings([pin.links[end] for pin in pins.values()])
        template.length(count).slot("places", "<f8", 3 * count)
        return template.length(count).slot("wrenches", "<f8", 6 * count)


class CylinderStates(OutputTopic):
    """Pressures and flows of the cylinders.

    There is no message until accelerations are known, or if the robot file gives no areas.
    """

    name, kind = "cylinder_states", "hybrid_dynamics_msgs/msg/CylinderStates"

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._kinds = dict.fromkeys(CylinderState.__dataclass_fields__, "<f8")
        del self._kinds["overloaded"]
        self._kinds["overloaded"] = "u1"  # the last field of the message
        self._template = MessageTemplate().header().strings(list(robot.cylinders))
        for name, kind in self._kinds.items():
            self._template.sequence(name, len(robot.cylinders), kind)

    def message(self, result: MotionResult) -> Message | None:
        """Each number of all cylinders."""
        if result.efforts is None or not self._robot.cylinders:
            return None
        cylinders = list(self._robot.hydraulics(result.state, result.efforts).values())
        shape = (*result.efforts.shape[:-1], len(cylinders))
        columns = []
        for name, kind in self._kinds.items():
            column = np.empty(shape, dtype=kind)
            for k, cylinder in enumerate(cylinders):
                column[..., k] = getattr(cylinder, name)
            columns.append(column)
        return self._template, columns


class Transforms(OutputTopic):
    """Transforms of all links, for use without robot_state_publisher."""

    name, kind = "/tf", "tf2_msgs/msg/TFMessage"

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        self._transforms = LinkTransforms(robot)
        template = MessageTemplate().length(len(robot.coordinates))
        for k, name in enumerate(robot.coordinates):
            joint = robot.description.joints[name]
            template.header(names.of(joint.parent)).string(names.of(joint.child))
            template.slot(f"translation {k}", "<f8", 3).slot(f"quaternion {k}", "<f8", 4)
        self._template = template

    @property
    def rate(self) -> Parameter[float]:
        """The parameter of the rate; negative (the default) disables the topic."""
        return TF_RATE

    def message(self, result: MotionResult) -> Message:
        """Translation and quaternion x y z w of each joint's child, in the order of joints."""
        return self._template, self._transforms.values(result.position)


TOPICS: Final = (
    JointStates,
    RequiredEfforts,
    MeasuredEfforts,
    BaseWrench,
    JointPoses,
    ClosedStates,
    EndEffectorPose,
    EndEffectorTwist,
    LoopReactions,
    CylinderStates,
    ToolWrench,
    Contact,
    Payload,
)


def topics_of(robot: Robot, settings: NodeSettings) -> list[OutputTopic]:
    """All topics of a robot, with transforms if their rate is not negative."""
    names = frame_names(robot, settings)
    topics: list[OutputTopic] = [
        JointStates(robot),
        RequiredEfforts(robot),
        MeasuredEfforts(robot),
        BaseWrench(robot, names),
        JointPoses(robot),
        ClosedStates(robot),
        EndEffectorPose(names),
        EndEffectorTwist(robot, names),
        LoopReactions(robot, names),
        CylinderStates(robot),
        ToolWrench(robot, names),
        Contact(robot, names),
        Payload(robot, names),
    ]
    if settings[TF_RATE] >= 0.0:
        topics.append(Transforms(robot, names))
    return topics
