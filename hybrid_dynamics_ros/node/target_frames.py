"""Transformation of targets from any frame of /tf to the base frame."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.action import ConvertTrajectory as ConvertTrajectoryAction
from hybrid_dynamics_msgs.srv import ConvertTrajectory, SolveIK
from rclpy.node import Node
from rclpy.time import Time

from ..messages import conversions
from ..messages.joint_samples import FloatArray, Rejection, RejectionCode
from ..parameters import TF_TARGETS, NodeSettings, ParameterError
from ..services.trajectory_steps import TrajectoryStep
from ..stream.frames import FrameNames


class TargetFrames:
    """A listener to /tf that transforms targets.

    Raises:
        ParameterError: tf2_ros is not installed.
    """

    def __init__(self, node: Node, names: FrameNames) -> None:
        try:
            tf2 = import_module("tf2_ros")
        except ImportError as error:
            text = (
                f"parameter {TF_TARGETS.name}: tf2_ros is not installed: sudo apt install"
                " ros-jazzy-tf2-ros-py, or set it to false"
            )
            raise ParameterError(text) from error
        self._base = names.base
        self._buffer = tf2.Buffer()
        self._listener = tf2.TransformListener(self._buffer, node)

    def destroy(self) -> None:
        """Stop listening."""
        self._listener.unregister()

    def to_base_frame(self, request: Any) -> Rejection | None:
        """Transform the targets of a request to the base frame, in place.

        Returns:
            The rejection if a target cannot be transformed, otherwise None.
        """
        for target, when in _targets(request):
            frame = target.header.frame_id
            if frame in ("", self._base):
                continue
            try:
                stamped = self._buffer.lookup_transform(self._base, frame, when)
            except Exception as error:  # noqa: BLE001 - tf2 has a family of them
                text = f"target is in frame '{frame}': {error}"
                return Rejection(RejectionCode.BAD_REQUEST, text)
            _move(target, stamped.transform)
            target.header.frame_id = self._base
        return None


def target_frames(node: Node, names: FrameNames, settings: NodeSettings) -> TargetFrames | None:
    """The listener, if the parameters enable it; otherwise targets must be in the base frame.

    Raises:
        ParameterError: tf2_ros is needed, but not installed.
    """
    if not settings[TF_TARGETS]:
        return None
    return TargetFrames(node, names)


def _targets(request: Any) -> Iterator[tuple[PoseStamped, Time]]:
    """Target poses of a request, each with the time of its transform; zero means the latest."""
    if isinstance(request, SolveIK.Request):
        yield request.target, Time.from_msg(request.target.header.stamp)
    if isinstance(request, TrajectoryStep.Request):
        request = request.goal
    if isinstance(request, ConvertTrajectory.Request | ConvertTrajectoryAction.Goal):
        for pose in request.path:  # its stamps are times along the path
            yield pose, Time()


def _move(target: PoseStamped, transform: Any) -> None:
    """Transform a pose in place."""
    position, quaternion = conversions.pose_arrays(target.pose)
    shift = transform.translation
    turn = transform.rotation
    translation = np.array([shift.x, shift.y, shift.z])
    rotation = np.array([turn.x, turn.y, turn.z, turn.w])
    point = target.pose.position
    moved = _turned(rotation, position) + translation
    point.x, point.y, point.z = moved.tolist()
    orientation = target.pose.orientation
    turned = _product(rotation, quaternion)
    orientation.x, orientation.y, orientation.z, orientation.w = turned.tolist()


def _turned(quaternion: FloatArray, vector: FloatArray) -> FloatArray:
    """A vector (3,) rotated by a unit quaternion x y z w."""
    axis, w = quaternion[:3], quaternion[3]
    # q v q* without products that cancel
    across = 2.0 * np.cross(axis, vector)
    return np.asarray(vector + w * across + np.cross(axis, across))


def _product(one: FloatArray, other: FloatArray) -> FloatArray:
    """The quaternion product one * other, x y z w."""
    a, w = one[:3], one[3]
    b, v = other[:3], other[3]
    vector = w * b + v * a + np.cross(a, b)
    return np.append(vector, w * v - a @ b)
