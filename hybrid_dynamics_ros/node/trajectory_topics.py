"""Conversion of trajectories from a topic to a topic, with a status for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hybrid_dynamics_msgs.msg import TrajectoryStatus
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from rclpy.lifecycle import LifecycleNode
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory

from ..actions.stepwise import Run
from ..messages.joint_samples import Rejection, RejectionCode
from ..services.answers import OK, refused
from ..services.table import BY_NAME

_INACTIVE = Rejection(RejectionCode.NOT_READY, "the node is not active: trajectories are left out")
_SERVICE = BY_NAME["convert_trajectory"]


class TrajectoryTopics:
    """Subscribes to trajectories, and publishes results and status of each."""

    def __init__(self, node: LifecycleNode, run: Run, is_active: Callable[[], bool]) -> None:
        """Create the topics.

        Args:
            node: the node.
            run: submits a call to the worker processes.
            is_active: whether the node is active.
        """
        self._run, self._is_active = run, is_active
        self._converted = node.create_publisher(JointTrajectory, "~/active_joint_trajectory", 10)
        self._status = node.create_publisher(TrajectoryStatus, "~/joint_trajectory_status", 10)
        node.create_subscription(JointTrajectory, "~/joint_trajectory", self._on_trajectory, 10)

    def _on_trajectory(self, message: JointTrajectory) -> None:
        header = message.header

        def publish(response: Any) -> None:
            if response.error_code == OK:
                self._converted.publish(response.trajectory)
            self._status.publish(_status(header, response))

        if self._is_active():
            self._run(_SERVICE, ConvertTrajectory.Request(joints=message), publish)
        else:
            publish(refused(ConvertTrajectory.Response(), _INACTIVE))


def _status(header: Header, response: Any) -> TrajectoryStatus:
    return TrajectoryStatus(
        header=header,
        error_code=response.error_code,
        error_text=response.error_text,
        first_bad=response.first_bad,
        first_bad_time=response.first_bad_time,
        nearest_singularity=response.nearest_singularity,
    )
