"""Topics of ball and free joints: wrench on a floating base, and poses of the joints."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.algebra.rotations import quaternion

from ...messages.cdr import MessageTemplate
from ...messages.joint_poses import JOINT_POSES
from ...messages.joint_samples import FloatArray
from ..frames import FrameNames
from ..output_topic import Message, OutputTopic
from ..results import MotionResult
from .base import floating_base

_WRENCH = 6  # numbers of a twist or a wrench
_POSE = 7  # numbers of a transform


class BaseWrench(OutputTopic):
    """The external wrench on a floating base, such as from contacts, for its motion.

    There is no message until accelerations are known, or without odometry.
    """

    name, kind = "base_wrench", "geometry_msgs/msg/WrenchStamped"

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        base = floating_base(robot)
        link = "" if base is None else names.of(base.link)
        self._template = MessageTemplate().header(link).slot("wrench", "<f8", 6)

    def message(self, result: MotionResult) -> Message | None:
        """Force, then moment about the origin of the link, in its axes."""
        if result.base_wrench is None:
            return None
        return self._template, (result.base_wrench,)


class JointPoses(OutputTopic):
    """Pose, twist and wrench of each ball and free joint, at any orientation.

    There is no message for robots without such joints. Twists and wrenches are left out until rates
    and accelerations are known.
    """

    name, kind = "joint_poses", JOINT_POSES

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._joints = robot.description.freely_turning
        self._templates: dict[tuple[bool, bool], MessageTemplate] = {}

    def message(self, result: MotionResult) -> Message | None:
        """Transforms, then twists, then wrenches, as far as known."""
        if not self._joints:
            return None
        parts = [self._transforms(result)]
        has_twists = result.velocity is not None
        has_wrenches = result.efforts is not None
        if has_twists:
            parts.append(self._twists(result))
        if result.efforts is not None:
            parts.append(self._wrenches(result, result.efforts))
        return self._template(has_twists, has_wrenches), parts

    def _template(self, has_twists: bool, has_wrenches: bool) -> MessageTemplate:
        parts = has_twists, has_wrenches
        if parts not in self._templates:
            count = len(self._joints)
            names = [joint.name for joint in self._joints]
            template = MessageTemplate().header(self._robot.base_frame).strings(names)
            template.length(count).slot("transforms", "<f8", _POSE * count)
            for what, has_some in zip(("twists", "wrenches"), parts, strict=True):
                some = count if has_some else 0
                template.length(some)
                if some:
                    template.slot(what, "<f8", _WRENCH * some)
            self._templates[parts] = template
        return self._templates[parts]

    def _transforms(self, result: MotionResult) -> FloatArray:
        columns = []
        for joint in self._joints:
            pose = self._robot.joint_pose(result.state, joint.name)
            columns += [pose.position, quaternion(pose.rotation)]
        return np.concatenate(columns, axis=-1)

    def _twists(self, result: MotionResult) -> FloatArray:
        columns = []
        for joint in self._joints:
            twist = self._robot.joint_twist(result.state, joint.name)
            columns.append(_six(twist))
        return np.concatenate(columns, axis=-1)

    def _wrenches(self, result: MotionResult, efforts: FloatArray) -> FloatArray:
        """Wrenches of what drives the joints; zero for joints in loops, which nothing drives."""
        robot, state = self._robot, result.state
        wrenches = robot.twist_map(state).wrenches(efforts)
        columns = []
        for joint in self._joints:
            places = [robot.coordinates.index(name) for name in joint.joints]
            if max(places) < state.n:
                columns.append(_six(wrenches[..., places]))
            else:
                columns.append(np.zeros((*wrenches.shape[:-1], _WRENCH)))
        return np.concatenate(columns, axis=-1)


def _six(numbers: FloatArray) -> FloatArray:
    """A twist or wrench (..., 6) of (..., 6), or of the angular part (..., 3)."""
    missing = _WRENCH - numbers.shape[-1]
    linear = np.zeros((*numbers.shape[:-1], missing))
    return np.concatenate([linear, numbers], axis=-1)
