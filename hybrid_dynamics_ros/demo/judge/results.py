"""What a result bag holds, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...bags.storage.bag_reader import read_raw
from ...bags.storage.storage import RawMessage
from ...messages.interfaces import deserialize
from ..topics import EFFORTS, INPUT, POSE, STATES, TYPES

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class JointSeries:
    """The JointState messages of one topic, a row each; columns in the order of ``names``.

    Attributes:
        names: joints.
        stamp_ns: header stamps (N,) [ns].
        log_ns: when each arrived, of the input when it was sent (N,) [ns].
        position, velocity, effort: (N, k) [rad or m, per s, N m or N]; NaN where a message has
        none.
    """

    names: tuple[str, ...]
    stamp_ns: IntArray
    log_ns: IntArray
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray


@dataclass(frozen=True, eq=False)
class PoseSeries:
    """The PoseStamped messages of one topic, a row each.

    Attributes:
        frame: frame of the poses.
        stamp_ns: header stamps (N,) [ns].
        position: (N, 3) [m].
        quaternion: (N, 4), x y z w.
    """

    frame: str
    stamp_ns: IntArray
    position: FloatArray
    quaternion: FloatArray


@dataclass(frozen=True, eq=False)
class Results:
    """All topics of a result bag."""

    inputs: JointSeries
    states: JointSeries
    efforts: JointSeries
    pose: PoseSeries

    @property
    def start_ns(self) -> int:
        """Stamp of the first input [ns], where the time of plots begins."""
        return int(self.inputs.stamp_ns[0])


def read_results(bag: Path) -> Results:
    """Read a bag that the demo recorded.

    Raises:
        BagError: there is no bag, or it cannot be read.
    """
    return Results(
        inputs=_joint_series(read_raw(bag, INPUT)),
        states=_joint_series(read_raw(bag, STATES)),
        efforts=_joint_series(read_raw(bag, EFFORTS)),
        pose=_pose_series(read_raw(bag, POSE)),
    )


def _joint_series(raw: list[RawMessage]) -> JointSeries:
    messages = [deserialize(data, TYPES[INPUT]) for _, data in raw]
    names = tuple(messages[0].name) if messages else ()
    return JointSeries(
        names,
        _stamps(messages),
        np.array([log_ns for log_ns, _ in raw], dtype=np.int64),
        *(_table(messages, names, field) for field in ("position", "velocity", "effort")),
    )


def _table(messages: list[Any], names: tuple[str, ...], field: str) -> FloatArray:
    table = np.full((len(messages), len(names)), np.nan)
    for row, message in zip(table, messages, strict=True):
        values = dict(zip(message.name, getattr(message, field), strict=False))
        row[:] = [values.get(name, np.nan) for name in names]
    return table


def _pose_series(raw: list[RawMessage]) -> PoseSeries:
    messages = [deserialize(data, TYPES[POSE]) for _, data in raw]
    positions = [message.pose.position for message in messages]
    turns = [message.pose.orientation for message in messages]
    return PoseSeries(
        messages[0].header.frame_id if messages else "",
        _stamps(messages),
        np.array([(p.x, p.y, p.z) for p in positions], dtype=np.float64).reshape(-1, 3),
        np.array([(q.x, q.y, q.z, q.w) for q in turns], dtype=np.float64).reshape(-1, 4),
    )


def _stamps(messages: list[Any]) -> IntArray:
    stamps = [message.header.stamp for message in messages]
    return np.array([stamp.sec * 10**9 + stamp.nanosec for stamp in stamps], dtype=np.int64)
