"""Topics of the force and of the load at the tool. This module does not depend on ROS."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.estimation import ToolForce

from ...messages.cdr import MessageTemplate
from ..frames import FrameNames
from ..output_topic import Message, OutputTopic, Rows
from ..results import MotionResult
from .payload import Reading

QUALITIES: Final = {"poor": 1, "fair": 2, "good": 3}


class ToolTopic(OutputTopic):
    """A topic of the force at the tool; no message before the observer has had enough samples."""

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows with a force, by the drives that are measured."""
        if result.residue is None:
            return []
        return result.residue.groups()

    def force(self, result: MotionResult) -> ToolForce | None:
        """The force of a result; that of one sample has one row."""
        residue = result.residue
        if residue is None:
            return None
        state = result.state
        if state.u.ndim == 1:
            state = ClosedState.joined([state])
        return residue.force(state)


class ToolWrench(ToolTopic):
    """Force and moment of the surroundings on the end effector, in its axes.

    They are NaN along axes that the measured drives do not sense.
    """

    name, kind = "tool_wrench", "geometry_msgs/msg/WrenchStamped"

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        frame = names.of(robot.end_effector)
        self._template = MessageTemplate().header(frame).slot("wrench", "<f8", 6)

    def message(self, result: MotionResult) -> Message | None:
        """Force, then moment about the origin of the frame."""
        force = self.force(result)
        if force is None:
            return None
        wrench = force.wrench
        if result.position.ndim == 1:
            wrench = wrench[0]
        return self._template, (wrench,)


class Contact(ToolTopic):
    """Whether the efforts at the tool are beyond what noise and errors explain."""

    name, kind = "contact", "hybrid_dynamics_msgs/msg/ToolContact"

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        template = MessageTemplate().header(names.of(robot.end_effector)).slot("contact", "u1")
        template.slot("level", "<f8").slot("threshold", "<f8").slot("covariance", "<f8", 36)
        self._template = template

    def message(self, result: MotionResult) -> Message | None:
        """Contact, its level and threshold, and the covariance of the wrench."""
        force = self.force(result)
        if force is None:
            return None
        contact = force.contact.astype(np.uint8)
        threshold = np.full_like(force.level, force.threshold)
        values: list[Any] = [contact, force.level, threshold, force.covariance]
        if result.position.ndim == 1:
            values = [value[0] for value in values]
        return self._template, values


class Payload(OutputTopic):
    """The load at the end effector, weighed over the newest motion; none without forces."""

    name, kind = "payload", "hybrid_dynamics_msgs/msg/PayloadEstimate"
    is_slow: ClassVar[bool] = True

    def __init__(self, robot: Robot, names: FrameNames) -> None:
        self._frame = names.of(robot.end_effector)

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Each row by itself: texts differ."""
        if result.windows is None:
            return []
        return [np.array([row]) for row in range(len(result.position))]

    def message(self, result: MotionResult) -> Message | None:
        """The reading of one sample, or of one row."""
        if result.windows is None:
            return None
        reading = result.windows.window(0).reading()
        values: list[Any] = list(_values(reading))
        if result.position.ndim == 2:
            values = [value[None] for value in values]
        return self._layout(reading.problem), values

    def _layout(self, problem: str) -> MessageTemplate:
        """The layout of a message with a text."""
        template = MessageTemplate().header(self._frame).slot("mass", "<f8")
        template.slot("interval", "<f8", 2).slot("com", "<f8", 3).slot("covariance", "<f8", 16)
        template.slot("quality", "u1").slot("zeroed", "u1").slot("duration", "<f8")
        return template.string(problem)


def _values(reading: Reading) -> Sequence[Any]:
    """Values of the slots of a payload message, in order."""
    mass, interval, com = np.nan, (np.nan, np.nan), np.full(3, np.nan)
    covariance = np.full((4, 4), np.nan)
    quality = 0
    estimate = reading.estimate
    if estimate is not None:
        mass, interval, com = estimate.mass, estimate.interval, estimate.com
        covariance = estimate.covariance
        quality = QUALITIES[estimate.quality]
    return (
        np.asarray(mass, dtype=np.float64),
        np.array(interval),
        np.asarray(com, dtype=np.float64),
        np.asarray(covariance, dtype=np.float64),
        np.uint8(quality),
        np.uint8(reading.zeroed),
        np.asarray(reading.duration, dtype=np.float64),
    )
