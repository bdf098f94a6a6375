"""QoS profiles of the topics, by their names in parameters."""

from __future__ import annotations

from typing import Final

from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

from ..parameters import BEST_EFFORT, LATEST, RELIABLE, SENSOR_DATA

_PROFILES: Final = {
    # Each message arrives, as long as the queue holds it. Incompatible with best-effort publishers.
    RELIABLE: (QoSReliabilityPolicy.RELIABLE, None),
    # Messages may be lost. As a subscription it is compatible with every publisher.
    BEST_EFFORT: (QoSReliabilityPolicy.BEST_EFFORT, None),
    # ROS's sensor data profile: best effort with a short queue of fixed depth.
    SENSOR_DATA: (QoSReliabilityPolicy.BEST_EFFORT, 5),
    # Only the newest message: pending ones are replaced.
    LATEST: (QoSReliabilityPolicy.RELIABLE, 1),
}

# Other policies for one topic, at start: parameters
# qos_overrides.TOPIC.{publisher,subscription}.{depth,...}.
OVERRIDES: Final = QoSOverridingOptions.with_default_policies()


def profile(name: str, depth: int) -> QoSProfile:
    """A volatile profile that keeps the last messages.

    Args:
        name: name of the profile in parameters.
        depth: history depth, unless the profile has its own.

    Raises:
        KeyError: no profile has this name.
    """
    reliability, fixed_depth = _PROFILES[name]
    return QoSProfile(
        reliability=reliability,
        durability=QoSDurabilityPolicy.VOLATILE,
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=fixed_depth or depth,
    )


def transient_local(depth: int = 1) -> QoSProfile:
    """A reliable and transient local profile: late subscriptions get the last messages."""
    return QoSProfile(
        reliability=QoSReliabilityPolicy.RELIABLE,
        durability=QoSDurabilityPolicy.TRANSIENT_LOCAL,
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=depth,
    )
