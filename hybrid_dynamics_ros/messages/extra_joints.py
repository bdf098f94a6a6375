"""Joints of a stream that the robot has not, as of a gripper: they pass through as they came."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from .joint_samples import FloatArray, JointSample

_MOST_LAYOUTS: Final = 16  # lists of names that are remembered


class ExtraJoints(NamedTuple):
    """Joints of one message.

    Attributes:
        stamp_ns: stamp of the message [ns].
        names: of the joints, (k,).
        values: (3, k) positions, velocities and efforts as they came; NaN where there is none.
    """

    stamp_ns: int
    names: tuple[str, ...]
    values: FloatArray


class PassThrough:
    """Remembers the extra joints of a stream's messages.

    Attributes:
        newest: the newest message of each list of names.
        max_age: joints of older messages are forgotten [s]; at first all that are older.
    """

    def __init__(self, joints: Sequence[str], measured: Sequence[str]) -> None:
        """Nothing is there yet.

        Args:
            joints: those of the robot, which are no extra ones.
            measured: those that the input measures.
        """
        self.newest: tuple[ExtraJoints, ...] = ()
        self.max_age = 0.0
        self._joints = frozenset(joints)
        self._measured = frozenset(measured)

    def take(self, sample: JointSample) -> bool:
        """Remember the extra joints of a message; whether it has no others."""
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
        """The extra joints at a stamp [ns], in the order of their names; None where there is none.

        Args:
            stamp_ns: of the reading that they go with [ns].
            newest: what `newest` was after the reading's last message.
        """
        recent = [extra for extra in newest if _is_recent(extra, stamp_ns, self.max_age)]
        if not recent:
            return None
        columns: dict[str, FloatArray] = {}
        for extra in recent:  # the last one that came counts
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
