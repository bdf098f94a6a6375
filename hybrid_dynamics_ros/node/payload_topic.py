"""A latched topic of the payloads in effect, with a message for each frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from geometry_msgs.msg import Inertia, InertiaStamped, Vector3
from rclpy.node import Node

from hybrid_dynamics_core import Robot

from ..stream.conditions import NO_PAYLOAD, PayloadBody
from ..stream.frames import FrameNames
from . import qos

TOPIC: Final = "~/payloads"


class PayloadTopic:
    """Publishes all payloads after each change; late subscribers get the newest of each frame."""

    def __init__(self, node: Node, robot: Robot, names: FrameNames) -> None:
        self._node, self._names = node, names
        # The depth is that of one change, so that late subscribers get exactly the last one.
        profile = qos.transient_local(len(robot.frames))
        self._publisher = node.create_publisher(InertiaStamped, TOPIC, profile)
        self._frames = {robot.end_effector}

    def publish(self, payloads: Mapping[str, PayloadBody]) -> None:
        """Publish the payloads in effect."""
        self._frames |= set(payloads)
        stamp = self._node.get_clock().now().to_msg()
        for frame in sorted(self._frames):
            message = InertiaStamped(inertia=_inertia(payloads.get(frame, NO_PAYLOAD)))
            message.header.stamp, message.header.frame_id = stamp, self._names.of(frame)
            self._publisher.publish(message)

    def destroy(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)


def _inertia(body: PayloadBody) -> Inertia:
    x, y, z = body.com
    xx, xy, xz, yy, yz, zz = body.inertia
    com = Vector3(x=x, y=y, z=z)
    return Inertia(m=body.mass, com=com, ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)
