"""A node without the middleware's events."""

from __future__ import annotations

from typing import Any, Final

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

_NO_PUBLISHER_EVENTS: Final = PublisherEventCallbacks(use_default_callbacks=False)
_NO_SUBSCRIPTION_EVENTS: Final = SubscriptionEventCallbacks(use_default_callbacks=False)


class EventFreeNode(LifecycleNode):
    """A lifecycle node whose topics have no event handlers, not even rclpy's default ones.

    To take an event, Fast DDS locks the event and then the reader. Its receiving thread locks the
    reader and then the event. This may deadlock, with the GIL held, so that no signal handler and
    no other thread can run.
    """

    def create_publisher(self, *args: Any, **options: Any) -> Publisher:
        """Create it as rclpy does, without event handlers."""
        options.setdefault("event_callbacks", _NO_PUBLISHER_EVENTS)
        return super().create_publisher(*args, **options)

    def create_subscription(self, *args: Any, **options: Any) -> Subscription:
        """Create it as rclpy does, without event handlers."""
        options.setdefault("event_callbacks", _NO_SUBSCRIPTION_EVENTS)
        return super().create_subscription(*args, **options)
