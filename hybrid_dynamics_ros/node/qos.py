"""Quality of service of the topics, by the names that the parameters know."""

from __future__ import annotations

from typing import Final

from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

from ..parameters import BEST_EFFORT, LATEST, RELIABLE, SENSOR_DATA

_PROFILES: Final = {
    # Each message arrives, as long as the queue holds it. Does not connect to a best-effort
    # publisher.
    RELIABLE: (QoSReliabilityPolicy.RELIABLE, None),
    # A lost message stays lost. As subscriber it connects to every publisher.
    BEST_EFFORT: (QoSReliabilityPolicy.BEST_EFFORT, None),
    # As ROS names it: best effort with a short queue, whatever depth is asked for.
    SENSOR_DATA: (QoSReliabilityPolicy.BEST_EFFORT, 5),
    # The newest message and no other: what waits is replaced.
    LATEST: (QoSReliabilityPolicy.RELIABLE, 1),
}

# Where one topic needs other policies, at start: parameters
# qos_overrides.TOPIC.{publisher,subscription}.{depth,...}.
OVERRIDES: Final = QoSOverridingOptions.with_default_policies()


def profile(name: str, depth: int) -> QoSProfile:
    """Volatile profile that keeps the last messages.

    Args:
        name: of the profile, as the parameters know it.
        depth: how many messages it keeps, unless the profile says so itself.

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
    """Reliable and transient local: subscriptions that come later get the last messages too."""
    return QoSProfile(
        reliability=QoSReliabilityPolicy.RELIABLE,
        durability=QoSDurabilityPolicy.TRANSIENT_LOCAL,
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=depth,
    )
