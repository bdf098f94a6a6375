"""The recorder: a node of this process that writes every message as it came."""

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
QUEUE: Final = 10_000  # messages: a stalled terminal must not lose any
_CLASSES: Final = {INPUT: JointState, STATES: JointState, EFFORTS: JointState, POSE: PoseStamped}


class Recorder:
    """Subscribes to the results, later to the input too, and writes the bytes to a bag.

    Attributes:
        counts: messages so far, by topic.
        latest: CDR bytes of the newest message, by topic.
        last_arrival: when it came [s], of the monotonic clock.
    """

    def __init__(self, node: Node, bag: BagWriter) -> None:
        """Subscribe to the results.

        Args:
            node: of this process.
            bag: where the messages go.
        """
        self._node = node
        self._bag = bag
        self.counts = dict.fromkeys(_CLASSES, 0)
        self.latest: dict[str, bytes] = {}
        self.last_arrival = time.monotonic()
        for topic in OUTPUTS:
            self._subscribe(topic)
        # After the subscriptions: see connected().
        self._client = node.create_client(InverseDynamics, f"{NODE}/inverse_dynamics")
        self._answers: list[Any] = []
        self._last_request = -RETRY_PERIOD

    def listen_to_input(self) -> None:
        """Record what the node gets as well, from now on."""
        self._subscribe(INPUT)

    def connected(self) -> bool:
        """Whether the node is there and sends to all subscriptions. Poll it while spinning.

        Matching is not symmetric: that this side knows the node's publishers does not say that they
        know its subscriptions. So the node is asked something. Its answer arrives only after it
        has the reader of the answers, which was announced after the subscriptions, and
        announcements arrive in order. An answer is lost where the node does not have that reader
        yet. So the question is repeated.
        """
        is_due = time.monotonic() >= self._last_request + RETRY_PERIOD
        if is_due and self._can_ask():
            self._last_request = time.monotonic()
            self._answers.append(self._client.call_async(_first_request()))
        return any(answer.done() for answer in self._answers)

    def _can_ask(self) -> bool:
        """Whether this side knows all of the node's publishers, and its service."""
        has_publishers = all(self._node.count_publishers(topic) for topic in OUTPUTS)
        return has_publishers and self._client.service_is_ready()

    def _subscribe(self, topic: str) -> None:
        """Record a topic: the input with the time of sending, results with that of arrival.

        Both times are the middleware's, of one clock. When this process comes to read a message
        says nothing: one that was sent later may be read first.
        """
        stamp = "source_timestamp" if topic == INPUT else "received_timestamp"

        def write(data: bytes, info: dict[str, Any]) -> None:
            self._bag.write_message(topic, int(info[stamp]), data)
            self.counts[topic] += 1
            self.latest[topic] = data
            self.last_arrival = time.monotonic()

        qos = QoSProfile(depth=QUEUE, reliability=QoSReliabilityPolicy.RELIABLE)
        callback: Any = write  # rclpy takes two arguments too, and its types do not tell
        self._node.create_subscription(_CLASSES[topic], topic, callback, qos, raw=True)


def _first_request() -> InverseDynamics.Request:
    """The efforts at the start of the trajectory.

    It also makes the node compile its model before time matters.
    """
    trajectory = paper_trajectory(1)
    request = InverseDynamics.Request()
    motion = request.motion
    motion.name = list(JOINTS)
    motion.position = trajectory.position[0].tolist()
    motion.velocity = trajectory.velocity[0].tolist()
    motion.acceleration = [0.0] * len(motion.name)
    return request
