"""Why a topic has publishers or subscriptions that hear nothing of each other.

The middleware has events for it. The node handles none: see `event_free`.
"""

from __future__ import annotations

from typing import Any

from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo


def deaf_publishers(node: LifecycleNode, subscription: Subscription) -> list[str]:
    """Publishers of a topic whose messages do not reach the node, each with the reason."""
    topic = subscription.topic_name
    if node.count_publishers(topic) <= subscription.get_publisher_count():
        return []
    reasons = []
    for endpoint in node.get_publishers_info_by_topic(topic):
        verdict = _verdict(endpoint.qos_profile, subscription.qos_profile)
        reasons += _reason(topic, subscription.msg_type, endpoint, verdict)
    return reasons


def deaf_subscriptions(node: LifecycleNode, publisher: Publisher) -> list[str]:
    """Subscriptions of a topic that the node's messages do not reach, each with the reason."""
    topic = publisher.topic_name
    if node.count_subscribers(topic) <= publisher.get_subscription_count():
        return []
    reasons = []
    for endpoint in node.get_subscriptions_info_by_topic(topic):
        verdict = _verdict(publisher.qos_profile, endpoint.qos_profile)
        reasons += _reason(topic, publisher.msg_type, endpoint, verdict)
    return reasons


def _verdict(publisher: QoSProfile, subscription: QoSProfile) -> tuple[QoSCompatibility, str]:
    """Whether two profiles go together in what this node's topics set."""
    verdict: tuple[QoSCompatibility, str] = qos_check_compatible(
        _plain(publisher), _plain(subscription)
    )
    return verdict


def _plain(profile: QoSProfile) -> QoSProfile:
    # What is not set reads as 0 here and as infinite there.
    return QoSProfile(depth=1, reliability=profile.reliability, durability=profile.durability)


def _reason(
    topic: str,
    kind: Any,  # a class of messages
    endpoint: TopicEndpointInfo,
    verdict: tuple[QoSCompatibility, str],
) -> list[str]:
    """Why an endpoint and the node do not hear each other, one text or none."""
    compatibility, text = verdict
    place = f"{topic} of {endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"
    expected = f"{kind.__module__.partition('.')[0]}/msg/{kind.__name__}"
    if endpoint.topic_type != expected:
        return [f"{place}: type {endpoint.topic_type}, expected {expected}"]
    if compatibility == QoSCompatibility.ERROR:  # each has an object of its own
        return [f"{place}: {text.removeprefix('ERROR: ').rstrip('; ')}"]
    return []
