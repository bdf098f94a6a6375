"""The newest messages of all topics, as numbers for display."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...messages.conversions import stamp_to_ns
from ...messages.interfaces import deserialize
from ...messages.joint_samples import FloatArray
from ..topics import EFFORTS, POSE, STATES, TYPES


@dataclass(frozen=True)
class Snapshot:
    """The latest state of the robot in the node's messages.

    Attributes:
        stamp_ns: header stamp of the joint states [ns].
        position: all coordinates by name [rad or m].
        velocity: their rates by name [rad/s or m/s].
        effort: efforts of the active joints by name [N m or N]; empty until there are any.
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
    """A snapshot from the newest message of each topic; None until joint states and a pose exist.

    Args:
        latest: CDR bytes by topic.
    """
    if STATES not in latest or POSE not in latest:
        return None
    states = deserialize(latest[STATES], TYPES[STATES])
    pose = deserialize(latest[POSE], TYPES[POSE]).pose
    effort: dict[str, float] = {}
    if EFFORTS in latest:
        efforts = deserialize(latest[EFFORTS], TYPES[EFFORTS])
        effort = _by_name(efforts.name, efforts.effort)
    velocity: dict[str, float] = {}
    if len(states.velocity):
        velocity = _by_name(states.name, states.velocity)
    place, turn = pose.position, pose.orientation
    return Snapshot(
        stamp_ns=stamp_to_ns(states.header.stamp),
        position=_by_name(states.name, states.position),
        velocity=velocity,
        effort=effort,
        tool=(place.x, place.y, place.z),
        quaternion=(turn.x, turn.y, turn.z, turn.w),
    )


def _by_name(names: Sequence[str], values: FloatArray) -> dict[str, float]:
    return dict(zip(names, values.tolist(), strict=True))
