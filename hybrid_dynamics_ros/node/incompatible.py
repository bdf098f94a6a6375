"""Detection of publishers and subscriptions with incompatible QoS.

The middleware has events for it, but the node handles no events, see `event_free`.
"""

from __future__ import annotations

from typing import Any

from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo


def deaf_publishers(node: LifecycleNode, subscription: Subscription) -> list[str]:
    """Publishers of a topic that are incompatible with the node, each with the reason."""
    topic = subscription.topic_name
    if node.count_publishers(topic) <= subscription.get_publisher_count():
        return []
    reasons = []
    for endpoint in node.get_publishers_info_by_topic(topic):
        verdict = _verdict(endpoint.qos_profile, subscription.qos_profile)
        reasons += _reason(topic, subscription.msg_type, endpoint, verdict)
    return reasons


def deaf_subscriptions(node: LifecycleNode, publisher: Publisher) -> list[str]:
    """Subscriptions of a topic that are incompatible with the node, each with the reason."""
    topic = publisher.topic_name
    if node.count_subscribers(topic) <= publisher.get_subscription_count():
        return []
    reasons = []
    for endpoint in node.get_subscriptions_info_by_topic(topic):
        verdict = _verdict(publisher.qos_profile, endpoint.qos_profile)
        reasons += _reason(topic, publisher.msg_type, endpoint, verdict)
    return reasons


def _verdict(publisher: QoSProfile, subscription: QoSProfile) -> tuple[QoSCompatibility, str]:
    """Whether two profiles are compatible in the policies that this node sets."""
    verdict: tuple[QoSCompatibility, str] = qos_check_compatible(
        _plain(publisher), _plain(subscription)
    )
    return verdict


def _plain(profile: QoSProfile) -> QoSProfile:
    # Unset durations are 0 in rclpy, but infinite in the middleware.
    return QoSProfile(depth=1, reliability=profile.reliability, durability=profile.durability)


def _reason(
    topic: str,
    kind: Any,  # a class of messages
    endpoint: TopicEndpointInfo,
    verdict: tuple[QoSCompatibility, str],
) -> list[str]:
    """Text on the incompatibility of an endpoint and the node, in a list; or an empty list."""
    compatibility, text = verdict
    place = f"{topic} of {endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"
    expected = f"{kind.__module__.partition('.')[0]}/msg/{kind.__name__}"
    if endpoint.topic_type != expected:
        return [f"{place}: type {endpoint.topic_type}, expected {expected}"]
    if compatibility == QoSCompatibility.ERROR:  # compared by value, since identities differ
        return [f"{place}: {text.removeprefix('ERROR: ').rstrip('; ')}"]
    return []
