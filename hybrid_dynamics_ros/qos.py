"""Named quality-of-service profiles of the topics."""

from __future__ import annotations

from typing import Final

from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy

RELIABLE: Final = "reliable"
BEST_EFFORT: Final = "best_effort"

_RELIABILITY: Final = {
    # Each message arrives, as long as the queue holds it. Does not connect to a best-effort publisher.
    RELIABLE: QoSReliabilityPolicy.RELIABLE,
    # A lost message stays lost. As subscriber it connects to every publisher.
    BEST_EFFORT: QoSReliabilityPolicy.BEST_EFFORT,
}

NAMES: Final = tuple(_RELIABILITY)


def profile(name: str, depth: int) -> QoSProfile:
    """Volatile profile that keeps the last ``depth`` messages.

    Raises:
        KeyError: no profile has this name; :data:`NAMES` lists them.
    """
    return QoSProfile(
        reliability=_RELIABILITY[name],
        durability=QoSDurabilityPolicy.VOLATILE,
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=depth,
    )
