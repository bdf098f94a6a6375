"""Joints of a stream that are not the robot's, such as a gripper's, and pass through unchanged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from .joint_samples import FloatArray, JointSample

_MOST_LAYOUTS: Final = 16  # cached lists of names


class ExtraJoints(NamedTuple):
    """Extra joints of one message.

    Attributes:
        stamp_ns: stamp of the message [ns].
        names: names of the joints (k,).
        values: (3, k) positions, velocities and efforts of the message; NaN if missing.
    """

    stamp_ns: int
    names: tuple[str, ...]
    values: FloatArray


class PassThrough:
    """Stores the extra joints of a stream's messages.

    Attributes:
        newest: the newest message of each list of names.
        max_age: largest age of stored joints [s].
    """

    def __init__(self, joints: Sequence[str], measured: Sequence[str]) -> None:
        """Start without joints.

        Args:
            joints: names of the robot's joints, which are never extra.
            measured: names of the measured joints.
        """
        self.newest: tuple[ExtraJoints, ...] = ()
        self.max_age = 0.0
        self._joints = frozenset(joints)
        self._measured = frozenset(measured)

    def take(self, sample: JointSample) -> bool:
        """Store the extra joints of a message; returns whether it has only extra joints."""
        names = sample.names
        columns = [k for k, name in enumerate(names) if name not in self._joints]
        if not columns or len(sample.position) != len(names):
            return False
        extra = ExtraJoints(
            sample.stamp_ns, tuple(names[k] for k in columns), _values(sample, columns)
        )
        others = [other for other in self.newest if self._is_beside(other, extra)]
        self.newest = (*others[-_MOST_LAYOUTS:], extra)
        return not self._measured.intersection(names)

    def _is_beside(self, other: ExtraJoints, extra: ExtraJoints) -> bool:
        return other.names != extra.names and _is_recent(other, extra.stamp_ns, self.max_age)

    def at(self, stamp_ns: int, newest: tuple[ExtraJoints, ...]) -> ExtraJoints | None:
        """The extra joints at a stamp [ns], sorted by name; None if there are none.

        Args:
            stamp_ns: stamp of the reading that they accompany [ns].
            newest: value of `newest` after the reading's last message.
        """
        recent = [extra for extra in newest if _is_recent(extra, stamp_ns, self.max_age)]
        if not recent:
            return None
        columns: dict[str, FloatArray] = {}
        for extra in recent:  # later messages overwrite earlier ones
            columns |= dict(zip(extra.names, extra.values.T, strict=True))
        names = tuple(sorted(columns))
        return ExtraJoints(stamp_ns, names, np.array([columns[name] for name in names]).T)


def _is_recent(extra: ExtraJoints, stamp_ns: int, max_age: float) -> bool:
    return abs(stamp_ns - extra.stamp_ns) * 1e-9 <= max_age


def _values(sample: JointSample, columns: list[int]) -> FloatArray:
    """Positions, velocities and efforts (3, k) of some joints of a message."""
    values = np.full((3, len(columns)), np.nan)
    parts = (sample.position, sample.velocity, sample.effort)
    for row, part in zip(values, parts, strict=True):
        if part is not None and len(part) == len(sample.names):
            row[:] = part[columns]
    return values
