"""Quality-of-service profiles of publishers in bags."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, Final

import yaml
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

# ROS writes 2^63 - 1 ns, split into [s] and [ns], for no deadline.
_INFINITE: Final = QosTime(9223372036, 854775807)


def reliable_profile(depth: int, *, transient_local: bool = False) -> Qos:
    """A reliable profile that keeps the last messages.

    Args:
        depth: history depth.
        transient_local: whether late subscriptions get the kept messages.
    """
    durability = QosDurability.VOLATILE
    if transient_local:
        durability = QosDurability.TRANSIENT_LOCAL
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=depth,
        reliability=QosReliability.RELIABLE,
        durability=durability,
        deadline=_INFINITE,
        lifespan=_INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_INFINITE,
        avoid_ros_namespace_conventions=False,
    )


def read_profiles(raw: Any) -> tuple[Qos, ...]:
    """The profiles of a topic in a bag; empty if they cannot be read.

    Args:
        raw: the value of `offered_qos_profiles`: YAML text, or its content; None or "" if missing.
    """
    if isinstance(raw, str):
        return _profiles_of(raw)
    return _parsed(raw)


@cache  # most topics of a bag have the same
def _profiles_of(text: str) -> tuple[Qos, ...]:
    return _parsed(text)


def _parsed(raw: Any) -> tuple[Qos, ...]:
    try:
        return tuple(parse_qos(raw or []))
    except Exception:  # noqa: BLE001 - a profile is no reason to refuse a bag
        return ()


def profile_entries(profiles: Sequence[Qos]) -> list[Any]:
    """Profiles as entries of `metadata.yaml`."""
    return list(dump_qos_v9(list(profiles)))


@cache  # most topics of a bag have the same
def profile_text(profiles: tuple[Qos, ...]) -> str:
    """Profiles as YAML text for a channel of an MCAP file."""
    return yaml.safe_dump(profile_entries(profiles), sort_keys=False).strip()
