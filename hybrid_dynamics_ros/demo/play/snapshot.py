"""The newest messages of all topics, as numbers for people to look at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...messages.interfaces import deserialize
from ..topics import EFFORTS, POSE, STATES, TYPES


@dataclass(frozen=True)
class Snapshot:
    """The robot as the node last told it.

    Attributes:
        stamp_ns: header stamp of the joint states [ns].
        position, velocity: all coordinates by name [rad or m, per s].
        effort: of the active joints by name [N m or N]; empty until there are any.
        tool: end-effector point in the base frame, x, y, z [m].
        quaternion: end-effector orientation in the base frame, x, y, z, w.
    """

    stamp_ns: int
    position: Mapping[str, float]
    velocity: Mapping[str, float]
    effort: Mapping[str, float]
    tool: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


def take_snapshot(latest: Mapping[str, bytes]) -> Snapshot | None:
    """From the newest message of each topic; None until there are joint states and a pose.

    Args:
        latest: CDR bytes by topic.
    """
    if STATES not in latest or POSE not in latest:
        return None
    states = deserialize(latest[STATES], TYPES[STATES])
    pose = deserialize(latest[POSE], TYPES[POSE]).pose
    efforts = deserialize(latest[EFFORTS], TYPES[EFFORTS]) if EFFORTS in latest else None
    stamp = states.header.stamp
    return Snapshot(
        stamp_ns=stamp.sec * 10**9 + stamp.nanosec,
        position=dict(zip(states.name, states.position.tolist(), strict=True)),
        velocity=dict(zip(states.name, states.velocity.tolist(), strict=False)),
        effort=(
            {} if efforts is None else dict(zip(efforts.name, efforts.effort.tolist(), strict=True))
        ),
        tool=(pose.position.x, pose.position.y, pose.position.z),
        quaternion=(pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w),
    )
