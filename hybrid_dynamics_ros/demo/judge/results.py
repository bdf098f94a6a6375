"""The content of a result bag, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...bags.storage.bag_reader import read_raw
from ...bags.storage.storage import RawMessage
from ...messages.conversions import stamp_to_ns
from ...messages.interfaces import deserialize
from ...messages.joint_samples import FloatArray
from ..topics import EFFORTS, INPUT, POSE, STATES, TYPES

IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class JointSeries:
    """The JointState messages of one topic, a row each; columns in the order of `names`.

    Attributes:
        names: joints.
        stamp_ns: header stamps (N,) [ns].
        log_ns: times of arrival; for the input, times of sending (N,) [ns].
        position: (N, k) [rad or m]; NaN where a message has none.
        velocity: (N, k) [rad/s or m/s]; NaN where a message has none.
        effort: (N, k) [N m or N]; NaN where a message has none.
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
        """Stamp of the first input [ns], the origin of time in plots."""
        return int(self.inputs.stamp_ns[0])


def read_results(bag: Path) -> Results:
    """Read a bag recorded by the demo.

    Raises:
        BagError: there is no bag, or it cannot be read.
    """
    return Results(
        inputs=_joint_series(read_raw(bag, INPUT)),
        states=_joint_series(read_raw(bag, STATES)),
        efforts=_joint_series(read_raw(bag, EFFORTS)),
        pose=_pose_series(read_raw(bag, POSE)),
    )


def _joint_series(raw: Sequence[RawMessage]) -> JointSeries:
    messages = [deserialize(entry.data, TYPES[INPUT]) for entry in raw]
    names: tuple[str, ...] = ()
    if messages:
        names = tuple(messages[0].name)
    return JointSeries(
        names=names,
        stamp_ns=_stamps(messages),
        log_ns=np.array([entry.log_ns for entry in raw], dtype=np.int64),
        position=_table(messages, names, "position"),
        velocity=_table(messages, names, "velocity"),
        effort=_table(messages, names, "effort"),
    )


def _table(messages: Sequence[Any], names: tuple[str, ...], field: str) -> FloatArray:
    """A field of all messages (N, k), columns in the order of the names."""
    table = np.full((len(messages), len(names)), np.nan)
    for row, message in enumerate(messages):
        # not strict: a message may leave the field empty
        values = dict(zip(message.name, getattr(message, field), strict=False))
        table[row] = [values.get(name, np.nan) for name in names]
    return table


def _pose_series(raw: Sequence[RawMessage]) -> PoseSeries:
    messages = [deserialize(entry.data, TYPES[POSE]) for entry in raw]
    position = np.zeros((len(messages), 3))
    quaternion = np.zeros((len(messages), 4))
    for row, message in enumerate(messages):
        place, turn = message.pose.position, message.pose.orientation
        position[row] = (place.x, place.y, place.z)
        quaternion[row] = (turn.x, turn.y, turn.z, turn.w)
    frame = messages[0].header.frame_id if messages else ""
    return PoseSeries(frame, _stamps(messages), position, quaternion)


def _stamps(messages: Sequence[Any]) -> IntArray:
    """Header stamps (N,) [ns]."""
    stamps = [stamp_to_ns(message.header.stamp) for message in messages]
    return np.array(stamps, dtype=np.int64)
