"""Readings of a stream: NaN stands for absent values, and partial messages are joined.

Several drivers may publish some of the joints each. The newest value of each joint is used. A
reading is complete as soon as each joint was named since the last reading, and none is older than a
limit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .joint_samples import (
    FloatArray,
    JointOrder,
    JointSample,
    OrderedMotion,
    RejectedError,
    RejectionCode,
)

MAX_AGE: Final = 0.2  # [s] default of the node
_MOST_LAYOUTS: Final = 64  # cached layouts of partial messages
_MOST_LISTED: Final = 12  # names listed in a text
_NEVER: Final = -(2**62)  # [ns]
_ABSENT: Final = (RejectionCode.MISSING_JOINT, RejectionCode.NOT_FINITE)


class Joined(NamedTuple):
    """All joints at one time.

    Attributes:
        stamp_ns: newest stamp of the joints [ns].
        values: (kinds, n) positions, velocities and further kinds; NaN where absent.
    """

    stamp_ns: int
    values: FloatArray

    @property
    def motion(self) -> OrderedMotion:
        """Positions and velocities; velocities are None if all are absent."""
        position, velocity = self.values[:2]
        return OrderedMotion(position, None if np.isnan(velocity).all() else velocity, None)


class PartialJoiner:
    """Joins messages with some of the joints each."""

    def __init__(self, joints: Sequence[str], resting: Mapping[str, float], max_age: float) -> None:
        """Start without messages.

        Args:
            joints: names of the joints.
            resting: default positions of joints that may be missing [rad or m].
            max_age: largest difference of stamps in one reading [s]; 0: messages are not joined.
        """
        self._joints = tuple(joints)
        self.max_age = max_age
        self.is_clear = True
        self._resting = np.array([resting.get(name, np.nan) for name in joints])
        self._is_needed = np.isnan(self._resting)
        self._stamps = np.full(len(joints), _NEVER, dtype=np.int64)
        self._is_fresh = np.zeros(len(joints), dtype=bool)
        self._values = np.zeros((0, len(joints)))

    def clear(self) -> None:
        """Discard all messages."""
        self.is_clear = True
        self._stamps[:] = _NEVER
        self._is_fresh[:] = False

    def add(self, stamp_ns: int, values: FloatArray, refusal: RejectedError) -> Joined | None:
        """Add a message; returns a complete reading, or None if joints are missing.

        Args:
            stamp_ns: stamp of the message [ns].
            values: (kinds, n), positions first; NaN for missing joints.
            refusal: error of the message if it cannot be joined.

        Raises:
            RejectedError: a joint is in no message within the age.
        """
        self._store(stamp_ns, values)
        is_recent = self._stamps != _NEVER
        missing = self._is_needed & ~is_recent
        if missing.any():
            raise self._refused(refusal, missing)
        if not self._is_fresh[self._is_needed].all():
            return None
        self._is_fresh[:] = False
        return Joined(int(self._stamps[is_recent].max()), self._rested(is_recent))

    def _refused(self, refusal: RejectedError, missing: NDArray[np.bool_]) -> RejectedError:
        """A refusal that lists the missing joints."""
        code, text = refusal.rejection.code, refusal.rejection.text
        names = ", ".join(np.array(self._joints)[missing][:_MOST_LISTED])
        return RejectedError(code, f"{text}; within {self.max_age:g} s no message has {names}")

    def _store(self, stamp_ns: int, values: FloatArray) -> None:
        """Store the values of a message, and drop values that are too old or from the future."""
        self.is_clear = False
        is_there = ~np.isnan(values[0])
        if len(self._values) != len(values):
            self._values = np.full_like(values, np.nan)
        self._values[:, is_there] = values[:, is_there]
        self._stamps[is_there] = stamp_ns
        self._is_fresh[is_there] = True
        is_old = np.abs(self._stamps - stamp_ns) * 1e-9 > self.max_age
        self._stamps[is_old] = _NEVER
        self._is_fresh[is_old] = False

    def _rested(self, is_recent: NDArray[np.bool_]) -> FloatArray:
        """The values, with defaults for missing joints."""
        rested = self._values.copy()
        rested[0, ~is_recent] = self._resting[~is_recent]
        rested[1:, ~is_recent] = 0.0
        if np.isnan(self._values[1, is_recent]).all():
            rested[1] = np.nan
        return rested


class _PartialLayout:
    """Indices of joints in partial messages with one list of names.

    Attributes:
        refusal: error of such a message if it cannot be joined.
        joints: indices of the named joints.
    """

    def __init__(
        self, joints: Sequence[str], names: tuple[str, ...], refusal: RejectedError
    ) -> None:
        self.refusal = refusal
        self.joints = [k for k, joint in enumerate(joints) if joint in names]
        self._count = len(joints)
        self._order = JointOrder([joints[k] for k in self.joints])

    def motion(self, sample: JointSample) -> OrderedMotion:
        """Positions and velocities of all joints (n,), NaN where absent.

        Raises:
            RejectedError: a joint is named twice, lengths differ, or a number is infinite.
        """
        is_absent = np.isnan(sample.position)
        finite = sample._replace(position=np.where(is_absent, 0.0, sample.position))
        motion = self._order.arrange(finite, is_reading=True)
        absences = self._order.pick("position", sample.names, is_absent.astype(np.float64))
        position = self._widened(np.where(absences > 0.0, np.nan, motion.position))
        velocity = None if motion.velocity is None else self._widened(motion.velocity)
        return OrderedMotion(position, velocity, None)

    def _widened(self, values: FloatArray) -> FloatArray:
        wide = np.full(self._count, np.nan)
        wide[self.joints] = values
        return wide


class ReadingOrder:
    """Converts messages of a stream to an order of joints, and joins partial ones.

    Attributes:
        joiner: joiner of partial messages.
    """

    def __init__(
        self,
        joints: Sequence[str],
        resting: Mapping[str, float] | None = None,
        max_age: float = MAX_AGE,
    ) -> None:
        """Set the order; arguments are those of `JointOrder` and `PartialJoiner`."""
        self.joiner = PartialJoiner(joints, resting or {}, max_age)
        self._joints = tuple(joints)
        self._order = JointOrder(joints, resting)
        self._layouts: dict[tuple[str, ...], _PartialLayout] = {}

    def read(self, sample: JointSample) -> tuple[OrderedMotion, RejectedError | None]:
        """The joints of one message, and the error if it is partial.

        Positions and velocities of missing joints in a partial message are NaN.

        Raises:
            RejectedError: as in `JointOrder.arrange`; for a missing joint only if messages are not
                joined, or no joint is named.
        """
        names = tuple(sample.names)
        layout = self._layouts.get(names) if self._layouts else None
        if layout is None:
            try:
                return self._order.arrange(sample, is_reading=True), None
            except RejectedError as error:
                if error.rejection.code not in _ABSENT or self.joiner.max_age <= 0.0:
                    raise
                layout = self._layout(names, error)
        return layout.motion(sample), layout.refusal

    def arrange(self, sample: JointSample) -> tuple[int, OrderedMotion] | None:
        """Stamp [ns] and motion of all joints; None if joints are missing.

        Raises:
            RejectedError: as in `JointOrder.arrange`; a joint counts as missing if no message
                within the age names it.
        """
        motion, refusal = self.read(sample)
        if refusal is None:
            if not self.joiner.is_clear:
                self.joiner.clear()
            return sample.stamp_ns, motion
        joined = self.joiner.add(sample.stamp_ns, values_of(motion), refusal)
        return None if joined is None else (joined.stamp_ns, joined.motion)

    def _layout(self, names: tuple[str, ...], refusal: RejectedError) -> _PartialLayout:
        """The layout of partial messages, cached by names."""
        layout = _PartialLayout(self._joints, names, refusal)
        if not layout.joints:
            raise refusal
        if refusal.rejection.code is RejectionCode.MISSING_JOINT:
            if len(self._layouts) >= _MOST_LAYOUTS:
                self._layouts.clear()
            self._layouts[names] = layout
        return layout


def values_of(motion: OrderedMotion) -> FloatArray:
    """Positions and velocities (2, n), NaN where absent."""
    values = np.full((2, len(motion.position)), np.nan)
    values[0] = motion.position
    if motion.velocity is not None:
        values[1] = motion.velocity
    return values
