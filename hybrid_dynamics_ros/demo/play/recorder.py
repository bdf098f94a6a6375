"""The recorder: it writes every received message to a bag."""

from __future__ import annotations

import time
from typing import Any, Final

from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.srv import InverseDynamics
from rclpy.node import Node
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import JointState

from ...bags.storage.bag_writer import BagWriter
from ..topics import EFFORTS, INPUT, NODE, OUTPUTS, POSE, STATES
from ..trajectory import JOINTS, paper_trajectory

RETRY_PERIOD: Final = 2.0  # [s]
QUEUE: Final = 10_000  # [messages] so that a stalled terminal loses none
_CLASSES: Final = {INPUT: JointState, STATES: JointState, EFFORTS: JointState, POSE: PoseStamped}


class Recorder:
    """Subscribes to the results, later also to the input, and writes messages to a bag.

    Attributes:
        counts: number of messages so far, by topic.
        latest: CDR bytes of the newest message, by topic.
        last_arrival: arrival of the newest message, monotonic clock [s].
    """

    def __init__(self, node: Node, bag: BagWriter) -> None:
        """Subscribe to the results.

        Args:
            node: node of this process.
            bag: the bag to write.
        """
        self._node = node
        self._bag = bag
        self.counts = dict.fromkeys(_CLASSES, 0)
        self.latest: dict[str, bytes] = {}
        self.last_arrival = time.monotonic()
        for topic in OUTPUTS:
            self._subscribe(topic)
        # Created after the subscriptions, see connected().
        self._client = node.create_client(InverseDynamics, f"{NODE}/inverse_dynamics")
        self._answers: list[Any] = []
        self._last_request = -RETRY_PERIOD

    def listen_to_input(self) -> None:
        """Start recording the input too."""
        self._subscribe(INPUT)

    def connected(self) -> bool:
        """Whether the node's publishers know all subscriptions; to be polled while spinning.

        Matching is not symmetric: this side may know the node's publishers before they know its
        subscriptions. So a service of the node is called. The client was announced after the
        subscriptions, and announcements arrive in order. So a response shows that the node knows
        them. A response is lost if the node does not know the client yet, so the call is repeated.
        """
        is_due = time.monotonic() >= self._last_request + RETRY_PERIOD
        if is_due and self._can_ask():
            self._last_request = time.monotonic()
            self._answers.append(self._client.call_async(_first_request()))
        return any(answer.done() for answer in self._answers)

    def _can_ask(self) -> bool:
        """Whether all publishers of the node, and its service, are discovered."""
        has_publishers = all(self._node.count_publishers(topic) for topic in OUTPUTS)
        return has_publishers and self._client.service_is_ready()

    def _subscribe(self, topic: str) -> None:
        """Record a topic, with times of sending for the input, and times of arrival for results.

        Both are times of the middleware, on one clock. The time of reading is not used, since
        messages may be read out of order.
        """
        stamp = "source_timestamp" if topic == INPUT else "received_timestamp"

        def write(data: bytes, info: dict[str, Any]) -> None:
            self._bag.write_message(topic, int(info[stamp]), data)
            self.counts[topic] += 1
            self.latest[topic] = data
            self.last_arrival = time.monotonic()

        qos = QoSProfile(depth=QUEUE, reliability=QoSReliabilityPolicy.RELIABLE)
        callback: Any = write  # rclpy allows two arguments, but its types do not
        self._node.create_subscription(_CLASSES[topic], topic, callback, qos, raw=True)


def _first_request() -> InverseDynamics.Request:
    """The efforts at the start of the trajectory.

    The call also lets the node compile its model before the run.
    """
    trajectory = paper_trajectory(1)
    request = InverseDynamics.Request()
    motion = request.motion
    motion.name = list(JOINTS)
    motion.position = trajectory.position[0].tolist()
    motion.velocity = trajectory.velocity[0].tolist()
    motion.acceleration = [0.0] * len(motion.name)
    return request
