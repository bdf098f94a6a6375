"""What goes out for each input: a class for each topic, which lays out its messages and fills them.

The same class fills the message of one sample for the live node, and the messages of many rows for
a bag. Messages are filled in as bytes (`cdr`), which costs a fifth of a message object; the names
of all are written once. Knows no ROS.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import CylinderState, Robot
from hybrid_dynamics_core.algebra.rotations import quaternion
from hybrid_dynamics_core.dynamics.reactions import PinReaction

from ..messages.cdr import MessageTemplate
from ..messages.interfaces import JOINT_STATE
from ..messages.joint_samples import FloatArray
from ..messages.joint_state_layout import joint_state_template
from ..messages.link_transforms import LinkTransforms
from ..parameters import TF_RATE, TOPIC_RATES, NodeSettings, Parameter
from .frames import FrameNames, frame_names
from .results import MotionResult
from .stroke_margins import StrokeMargins

Rows = NDArray[np.intp]
Values = Sequence[NDArray[Any] | float]  # of the slots of a template, in their order
Message = tuple[MessageTemplate, Values]

_MOST_TEMPLATES: Final = 64  # of joint states that are remembered
_NO_EXTRAS: Final = np.zeros((3, 0))


class OutputTopic:
    """One topic of a robot.

    Attributes:
        name: below ``~/``, or the whole name where it begins with a slash.
        kind: its type.
    """

    name: ClassVar[str]
    kind: ClassVar[str]

    @property
    def rate(self) -> Parameter[float]:
        """Parameter with the largest rate of its messages."""
        return TOPIC_RATES[self.name]

    def message(self, result: MotionResult) -> Message | None:
        """Layout and values of the message of one sample, or of one message a row.

        None where the result has no message on this topic.
        """
        raise NotImplementedError

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows of a result whose messages have the same layout."""
        return [np.arange(len(result.position))]

    def fill(self, result: MotionResult) -> bytes | None:
        """The message of one sample."""
        message = self.message(result)
        if message is None:
            return None
        template, values = message
        return template.fill(result.stamp_ns, values)


class JointStates(OutputTopic):
    """All joints: position, velocity, and the effort of the drives, zero where nothing drives."""

    name, kind = "joint_states", JOINT_STATE

    def __init__(self, robot: Robot) -> None:
        self._driven = len(robot.description.motors)
        self._drives_are_active = set(robot.drives) == set(robot.description.motors)
        self._drive_places = [robot.coordinates.index(name) for name in robot.drives]
        self._names = robot.coordinates
        self._templates: dict[Any, MessageTemplate] = {}  # by extra joints, and what is known

    def message(self, result: MotionResult) -> Message:
        """Velocities and efforts as far as they are known."""
        velocity, efforts = result.velocity, self._efforts(result)
        parts = [result.position, velocity, efforts]
        names, extras = _extras_of(result)
        if names:
            for k, part in enumerate(parts):
                parts[k] = None if part is None else np.concatenate([part, extras[..., k, :]], -1)
        template = self._template(names, velocity is not None, efforts is not None)
        return template, [part for part in parts if part is not None]

    def _template(self, names: tuple[str, ...], velocity: bool, effort: bool) -> MessageTemplate:
        """The layout of messages with extra joints, and with velocities and efforts."""
        template = self._templates.get((names, velocity, effort))
        if template is None:
            if len(self._templates) >= _MOST_TEMPLATES:
                self._templates.clear()
            every = (*self._names, *names)
            template = joint_state_template(every, velocity=velocity, effort=effort)
            self._templates[names, velocity, effort] = template
        return template

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows with the same extra joints, whose drives can give the efforts or cannot."""
        groups: list[Rows] = []
        for rows in _by_extras(result):
            groups += [rows[part] for part in self._by_efforts(result.rows(rows))]
        return groups

    def _by_efforts(self, result: MotionResult) -> Sequence[Rows]:
        """Rows whose drives can give the efforts, and those whose drives cannot."""
        every = super().groups(result)
        if self._drives_are_active or result.efforts is None or result.drive_forces is not None:
            return every
        singles = [result.rows(row[None]) for row in every[0]]
        can_give = np.array([single.drive_forces is not None for single in singles])
        return [np.flatnonzero(can_give), np.flatnonzero(~can_give)]

    def _efforts(self, result: MotionResult) -> FloatArray | None:
        """Along all coordinates; None where they are not known."""
        if self._drives_are_active:
            tau = result.efforts
            if tau is None:
                return None
            efforts = np.zeros(result.position.shape)
            efforts[..., : self._driven] = tau[..., : self._driven]
            return efforts
        forces = result.drive_forces
        if forces is None:
            return None
        efforts = np.zeros(result.position.shape)
        for place, force in zip(self._drive_places, forces.values(), strict=True):
            efforts[..., place] = force
        return efforts


def _extras_of(result: MotionResult) -> tuple[tuple[str, ...], FloatArray]:
    """Names (k,) and values (3, k) of the extra joints, of rows (N, 3, k)."""
    extras = result.extras
    if not extras:
        return (), _NO_EXTRAS
    if not isinstance(extras, list):
        return extras.names, extras.values
    if extras[0] is None:
        return (), _NO_EXTRAS
    return extras[0].names, np.array([extra.values for extra in extras])


def _by_extras(result: MotionResult) -> Sequence[Rows]:
    """Rows with the same extra joints."""
    every = np.arange(len(result.position))
    if result.extras is None:
        return [every]
    names = [() if extra is None else extra.names for extra in result.extras]
    kinds = list(dict.fromkeys(names))
    numbers = np.array([kinds.index(one) for one in names])
    return [np.flatnonzero(numbers == k) for k in range(len(kinds))]


class RequiredEfforts(OutputTopic):
    """Torques and forces of the driven joints; nothing before accelerations are known."""

    name, kind = "required_efforts", JOINT_STATE

    def __init__(self, robot: Robot) -> None:
        motors = robot.description.motors
        self._driven = len(motors)  # idle coordinates come after them
        self._template = joint_state_template(motors, velocity=True, effort=True)

    def message(self, result: MotionResult) -> Message | None:
        """Position, velocity and effort."""
        u, du, _ = result.active
        if result.efforts is None or du is None:
            return None
        values = [part[..., : self._driven] for part in (u, du, result.efforts)]
        return self._template, values


class MeasuredEfforts(OutputTopic):
    """Forces of the cylinders from measured pressures, beside the required ones; NaN elsewhere.

    Nothing where no pressures came in.
    """

    name, kind = "measured_efforts", JOINT_STATE

    def __init__(self, robot: Robot) -> None:
        drives = robot.drives
        self._places = [robot.coordinates.index(name) for name in drives]
        self._templates = [
            joint_state_template(drives, velocity=has_velocity, effort=True)
            for has_velocity in (False, True)
        ]

    def message(self, result: MotionResult) -> Message | None:
        """Position, velocity where it is known, and effort."""
        forces = result.measured_forces
        if forces is None:
            return None
        values = [result.position[..., self._places]]
        if result.velocity is not None:
            values.append(result.velocity[..., self._places])
        return self._templates[len(values) - 1], [*values, forces]

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows with pressures."""
        forces = result.measured_forces
        if forces is None:
            return []
        return [np.flatnonzero(~np.isnan(forces).all(axis=1))]


class ClosedStates(OutputTopic):
    """Residual, assembly modes, distances to singularities and to the ends of strokes."""

    name, kind = "closed_state", "hybrid_dynamics_msgs/msg/ClosedState"

    def __init__(self, robot: Robot) -> None:
        self._robot, self._strokes = robot, StrokeMargins(robot)
        self._templates: dict[
            str, MessageTemplate
        ] = {}  # by the loop that is nearest to its singularity
        self._branch: Mapping[str, str] = {}

    def message(self, result: MotionResult) -> Message:
        """Rows have to share the loop that is nearest to its singularity."""
        nearest, loop = result.nearest
        template = self._template(result.branch, loop)
        lower, upper = self._strokes.margins(result.position)
        return template, (result.residual, result.distances, nearest, lower, upper)

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows by the loop that is nearest to its singularity."""
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

    Nothing before rates are known.
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
    """Force and moment in every pin; nothing before accelerations are known."""

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

    Nothing before accelerations are known, or where the robot file gives no areas.
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
    """Every link in the one before it, where robot_state_publisher does not send that."""

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
        """Below zero, as it is without a choice, the topic is not there."""
        return TF_RATE

    def message(self, result: MotionResult) -> Message:
        """Translation and quaternion x y z w of each joint's child, in the order of joints."""
        return self._template, self._transforms.values(result.position)


TOPICS: Final = (
    JointStates,
    RequiredEfforts,
    MeasuredEfforts,
    ClosedStates,
    EndEffectorPose,
    EndEffectorTwist,
    LoopReactions,
    CylinderStates,
)


def topics_of(robot: Robot, settings: NodeSettings) -> list[OutputTopic]:
    """All topics for a robot; transforms among them where their rate is not below zero."""
    names = frame_names(robot, settings)
    topics: list[OutputTopic] = [
        JointStates(robot),
        RequiredEfforts(robot),
        MeasuredEfforts(robot),
        ClosedStates(robot),
        EndEffectorPose(names),
        EndEffectorTwist(robot, names),
        LoopReactions(robot, names),
        CylinderStates(robot),
    ]
    if settings[TF_RATE] >= 0.0:
        topics.append(Transforms(robot, names))
    return topics
