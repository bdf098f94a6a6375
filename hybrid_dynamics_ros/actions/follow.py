"""The action ~/follow_joint_trajectory: a proxy for a trajectory controller.

It takes trajectories of any independent joints, such as the serial joints that MoveIt plans for.
The controller gets them in active joints, with efforts. Feedback is converted back to the joints of
the goal. Results and cancel requests are forwarded.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any, Final

from rclpy.node import Node

from ..parameters import FOLLOW_ACTION, ParameterError
from .follow_goal import Controller, FollowedGoal
from .goals import GoalServer
from .stepwise import Run

NAME: Final = "~/follow_joint_trajectory"


def follow_type() -> Any:
    """The type of the action.

    Raises:
        ParameterError: control_msgs is not installed; PyPI does not have it.
    """
    try:
        return import_module("control_msgs.action").FollowJointTrajectory
    except ImportError as error:
        text = (
            f"parameter {FOLLOW_ACTION.name}: control_msgs is not installed; install it with ROS,"
            " or leave the parameter empty"
        )
        raise ParameterError(text) from error


class FollowAction:
    """The proxy on a node."""

    def __init__(self, node: Node, controller: str, joints: Sequence[str], run: Run) -> None:
        """Offer the action.

        Args:
            node: the node.
            controller: name of the controller's action.
            joints: all joints that a goal may name.
            run: has a call answered by a worker process.

        Raises:
            ParameterError: control_msgs is not installed.
        """
        kind = follow_type()
        self._controller = Controller(node, kind, controller)
        self._goals: dict[bytes, FollowedGoal] = {}
        self._server = GoalServer(node, kind, NAME, self._begin, self._cancel)
        self._joints, self._run = frozenset(joints), run

    def destroy(self) -> None:
        """Destroy the action server."""
        self._server.destroy()  # type: ignore[no-untyped-call]
        self._controller.destroy()

    def _begin(self, handle: Any) -> None:
        key = bytes(handle.goal_id.uuid)
        followed = FollowedGoal(self._server, self._controller, handle, self._run)
        self._goals[key] = followed
        followed.ended = lambda: self._goals.pop(key, None)
        followed.begin(self._joints)

    def _cancel(self, handle: Any) -> None:
        followed = self._goals.get(bytes(handle.goal_id.uuid))
        if followed is not None:
            followed.cancel()
