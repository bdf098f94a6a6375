"""Output topics of a node: publishers, and their messages for each result."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import import_module
from typing import Any, Final, NamedTuple

from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher

from ..parameters import (
    OUTPUT_DEPTH,
    OUTPUT_QOS,
    TF_RATE,
    NodeSettings,
    Parameter,
    ParameterError,
)
from ..stream.output_topic import OutputTopic
from ..stream.rate_limit import RateLimit
from ..stream.results import MotionResult
from . import qos

Send = Callable[[Any], None]
Fill = Callable[[MotionResult], bytes | None]

_CHECK_PERIOD: Final = 0.02  # [s] for which subscription counts are cached


class TopicPublisher(NamedTuple):
    """An output topic: publisher, encoder, rate, rate limit, and whether its messages are slow."""

    publisher: Publisher
    fill: Fill
    rate: Parameter[float]
    pace: RateLimit
    is_slow: bool = False


class SlowWork(NamedTuple):
    """A message that is made in another thread."""

    publisher: Publisher
    fill: Fill
    result: MotionResult

    def send(self) -> None:
        """Make the message and send it."""
        message = self.fill(self.result)
        if message is not None:
            with self.publisher.handle:  # not destroyed meanwhile
                self.publisher.handle.publish_raw(message)


class Publishers:
    """The output topics for each input."""

    def __init__(self, node: LifecycleNode) -> None:
        self._node = node
        self.outputs: list[TopicPublisher] = []
        self._checked = -_CHECK_PERIOD
        self._sent: list[tuple[TopicPublisher, float, bool]] = []
        self._slow = ThreadPoolExecutor(1, "estimates")
        self._pending: Future[None] | None = None

    def open(self, topics: Sequence[OutputTopic], settings: NodeSettings) -> None:
        """Create the topics on the node.

        Raises:
            ParameterError: the message type of a topic is not installed.
        """
        profile = qos.profile(settings[OUTPUT_QOS], settings[OUTPUT_DEPTH])
        for topic in topics:
            name = topic.name if topic.name.startswith("/") else f"~/{topic.name}"
            publisher = self._node.create_publisher(
                message_class(topic.kind), name, profile, qos_overriding_options=qos.OVERRIDES
            )
            parts = (publisher, topic.fill, topic.rate, RateLimit(), topic.is_slow)
            self.outputs.append(TopicPublisher(*parts))

    def destroy(self) -> None:
        """Destroy the publishers."""
        self._slow.shutdown(cancel_futures=True)
        for output in self.outputs:
            self._node.destroy_publisher(output.publisher)

    def messages(self, result: MotionResult, settings: NodeSettings) -> list[tuple[Send, Any]]:
        """All messages for a result, each with its send function.

        They are made before the first is sent, so that all are sent or none.
        """
        now = time.perf_counter()
        if now > self._checked + _CHECK_PERIOD:
            self._checked = now
            self._check(settings)
        messages: list[tuple[Send, Any]] = []
        for output, rate, has_listener in self._sent:
            if (rate == 0.0 or output.pace.due(result.stamp_ns, rate)) and has_listener:
                if output.is_slow:
                    messages.append((self._submit, SlowWork(output.publisher, output.fill, result)))
                    continue
                message = output.fill(result)
                if message is not None:
                    # Sends bytes directly; only this thread destroys the publisher.
                    messages.append((output.publisher.handle.publish_raw, message))
        return messages

    def _submit(self, work: SlowWork) -> None:
        """Make a slow message in another thread; it is left out while the last one is made."""
        if self._pending is None or self._pending.done():
            self._pending = self._slow.submit(work.send)

    def _check(self, settings: NodeSettings) -> None:
        """Update rates and subscription counts of the topics."""
        self._sent = []
        for output in self.outputs:
            rate = settings[output.rate]
            has_listener = output.publisher.get_subscription_count() > 0
            # A topic at full rate without subscriptions is skipped.
            if rate > 0.0 or (rate == 0.0 and has_listener):
                self._sent.append((output, rate, has_listener))


def message_class(kind: str) -> type:
    """The class of a message type, such as "sensor_msgs/msg/JointState".

    Raises:
        ParameterError: tf2_msgs is not installed; PyPI does not have it.
    """
    package, _, name = kind.split("/")
    try:
        module = import_module(f"{package}.msg")
    except ImportError as error:
        if package != "tf2_msgs":
            raise
        text = (
            f"parameter {TF_RATE.name}: tf2_msgs is not installed; use robot_state_publisher, or"
            " set it to -1"
        )
        raise ParameterError(text) from error
    message: type = getattr(module, name)
    return message
