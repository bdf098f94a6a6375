"""An input topic: its subscription, its pending messages, and the count of lost ones."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from typing import Any, Final

from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from ..stream.input_queue import InputQueue
from ..stream.sequence_gaps import SequenceGaps
from . import qos

# [s] for which the list of publishers is cached, since a query is expensive
_CHECK_PERIOD: Final = 0.1


class InputTopic:
    """A subscription for messages as bytes.

    Attributes:
        name: resolved name of the topic.
        subscription: the subscription, after `open`.
        queue: pending messages.
        gaps: counts lost messages. The middleware's own event is not used, since it may deadlock,
            see `event_free`.
    """

    def __init__(self, node: LifecycleNode, kind: type, name: str, profile: QoSProfile) -> None:
        """Store the arguments; QoS overrides may change the profile."""
        self._node, self._kind, self._profile = node, kind, profile
        self._given_name, self.name = name, node.resolve_topic_name(name)
        self.gaps = SequenceGaps(self._publishers)
        self._present: frozenset[Hashable] = frozenset()
        self._checked = -_CHECK_PERIOD

    def open(
        self, on_message: Callable[[InputTopic], None], answer: Callable[[bytes], bool]
    ) -> None:
        """Subscribe.

        Args:
            on_message: called after a message was put into the queue.
            answer: processes a message; returns False if it is unusable.
        """

        def take(*taken: Any) -> None:
            # The events executor gives message and information as one argument, others as two.
            message, information = taken[0] if len(taken) == 1 else taken
            self._put(message, information)
            on_message(self)

        self.subscription = self._node.create_subscription(
            self._kind,
            self._given_name,
            take,
            self._profile,
            qos_overriding_options=qos.OVERRIDES,
            raw=True,
        )
        # By its signature `take` would get the message alone.
        kinds = Subscription.CallbackType
        self.subscription._callback_type = kinds.WithMessageInfo  # noqa: SLF001
        self.queue = InputQueue(answer, self.subscription.qos_profile.depth)

    def take_all(self) -> None:
        """Move all messages of the subscription to the queue."""
        handle = self.subscription.handle
        with handle:
            while (taken := handle.take_message(self._kind, True)) is not None:
                self._put(*taken)

    def destroy(self) -> None:
        """Destroy the subscription."""
        self._node.destroy_subscription(self.subscription)

    def _put(self, message: bytes, information: dict[str, Any]) -> None:
        number = information["publication_sequence_number"]
        if number is not None:
            self.gaps.note(number)
        self.queue.put(message)

    def _publishers(self) -> frozenset[Hashable]:
        now = time.monotonic()
        if now > self._checked + _CHECK_PERIOD:
            self._checked = now
            endpoints = self._node.get_publishers_info_by_topic(self.name)
            self._present = frozenset(bytes(endpoint.endpoint_gid) for endpoint in endpoints)
        return self._present
