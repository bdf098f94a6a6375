"""The payloads in effect on a latched topic, a message for each frame that has or had one."""

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
    """Sends all payloads after each change; who comes later gets the newest of every frame."""

    def __init__(self, node: Node, robot: Robot, names: FrameNames) -> None:
        self._node, self._names = node, names
        # No change has more messages than this: the last ones are all there is to know.
        profile = qos.transient_local(len(robot.frames))
        self._publisher = node.create_publisher(InertiaStamped, TOPIC, profile)
        self._frames = {robot.end_effector}

    def publish(self, payloads: Mapping[str, PayloadBody]) -> None:
        """These are in effect from now on."""
        self._frames |= set(payloads)
        stamp = self._node.get_clock().now().to_msg()
        for frame in sorted(self._frames):
            message = InertiaStamped(inertia=_inertia(payloads.get(frame, NO_PAYLOAD)))
            message.header.stamp, message.header.frame_id = stamp, self._names.of(frame)
            self._publisher.publish(message)

    def destroy(self) -> None:
        """Take the topic away."""
        self._node.destroy_publisher(self._publisher)


def _inertia(body: PayloadBody) -> Inertia:
    x, y, z = body.com
    xx, xy, xz, yy, yz, zz = body.inertia
    com = Vector3(x=x, y=y, z=z)
    return Inertia(m=body.mass, com=com, ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)
