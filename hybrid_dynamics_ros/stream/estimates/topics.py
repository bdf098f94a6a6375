"""Topics of the force at the tool. This module does not depend on ROS."""

from __future__ import annotations

from collections.abc import Sequence

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.estimation import ToolForce

from ...messages.cdr import MessageTemplate
from ..frames import FrameNames
from ..output_topic import Message, OutputTopic, Rows
from ..results import MotionResult


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
