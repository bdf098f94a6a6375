"""Joint states and motions in bulk: messages of one layout become columns at once, others one by one by rosbags."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..messages.cdr import Bytes
from ..messages.interfaces import JOINT_MOTION, JOINT_STATE, typestore
from ..messages.joint_samples import (
    LARGEST,
    Calibration,
    FloatArray,
    JointOrder,
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
    nanoseconds,
)
from ..messages.joint_state_layout import JointStateLayout, LayoutError, layout_of
from .storage.storage import Messages

_LAYOUTS: Final = 32  # kept at a time: a bag has a handful
T = TypeVar("T")
_FEW: Final = 4  # messages of one layout below which finding it costs more than it saves


@dataclass(eq=False)
class Samples:
    """Samples of the measured joints, a row each, in the order of the messages.

    Attributes:
        log_ns, stamp_ns: (N,) [ns].
        position, velocity: (N, n) [rad or m, per second]; velocity is NaN where there is none.
        measured: (N,) whether there are velocities.
        effort: (N, n) recorded efforts [N m or N], NaN where there are none.
        acceleration: (N, n) as they were told [per second^2]; None: to be estimated.
        rejected: rows that are no samples, and why; their numbers say nothing.
        bulk: how many came in bulk.
        broken: rows that are no message of their type at all.
    """

    log_ns: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    position: FloatArray
    velocity: FloatArray
    measured: NDArray[np.bool_]
    effort: FloatArray
    acceleration: FloatArray | None = None
    rejected: dict[int, Rejection] = field(default_factory=dict)
    broken: dict[int, str] = field(default_factory=dict)
    bulk: int = 0

    def __len__(self) -> int:
        return len(self.stamp_ns)

    @property
    def usable(self) -> NDArray[np.bool_]:
        """(N,) which rows are samples."""
        good = np.ones(len(self), dtype=bool)
        good[[*self.rejected, *self.broken]] = False
        return good

    def calibrated(self, calibration: Calibration | None) -> Samples:
        """The samples of the joints from those of their sensors."""
        if calibration is None:
            return self
        offset, factor = calibration.offset, calibration.factor
        return replace(
            self,
            position=factor * (self.position - offset),
            velocity=factor * self.velocity,
            acceleration=None if self.acceleration is None else factor * self.acceleration,
        )

    def part(self, rows: slice) -> Samples:
        """Samples of some rows that follow each other; views of these."""
        return self._at(rows, range(rows.start, rows.stop))

    def only(self, rows: NDArray[np.intp]) -> Samples:
        """Samples of some rows."""
        return self if len(rows) == len(self) else self._at(rows, rows.tolist())

    def _at(self, rows: slice | NDArray[np.intp], numbers: Sequence[int]) -> Samples:
        places = {row: k for k, row in enumerate(numbers)} if self.rejected or self.broken else {}
        return Samples(
            log_ns=self.log_ns[rows],
            stamp_ns=self.stamp_ns[rows],
            position=self.position[rows],
            velocity=self.velocity[rows],
            measured=self.measured[rows],
            effort=self.effort[rows],
            acceleration=None if self.acceleration is None else self.acceleration[rows],
            rejected=_numbered(self.rejected, places),
            broken=_numbered(self.broken, places),
        )


def _numbered(table: dict[int, T], places: dict[int, int]) -> dict[int, T]:
    return {places[row]: why for row, why in table.items() if row in places}


class Decoder:
    """Decodes the messages of one topic; remembers the layouts that it has seen."""

    def __init__(
        self, joints: Sequence[str], kind: str = JOINT_STATE, *, bulk: bool = True
    ) -> None:
        """The joints that are wanted, in order.

        kind: of the messages, JOINT_STATE or JOINT_MOTION.
        bulk: False: every message through the library.
        """
        self._joints, self._kind, self._bulk = tuple(joints), kind, bulk
        self._order = JointOrder(joints)
        self._layouts: dict[int, list[JointStateLayout]] = {}

    def decode(self, messages: Messages) -> Samples:
        """Samples of messages."""
        count, n = len(messages), len(self._joints)
        out = Samples(
            log_ns=messages.log_ns,
            stamp_ns=np.full(count, -1, dtype=np.int64),
            position=np.full((count, n), np.nan),
            velocity=np.full((count, n), np.nan),
            measured=np.zeros(count, dtype=bool),
            effort=np.full((count, n), np.nan),
            acceleration=np.full((count, n), np.nan) if self._kind == JOINT_MOTION else None,
        )
        for size in messages.sizes() if self._bulk else ():
            self._decode_size(out, messages, size)
        if not self._bulk:
            for row in range(count):
                self._one(out, row, messages.message(row))
        return out

    def _decode_size(self, out: Samples, messages: Messages, size: int) -> None:
        rows = np.flatnonzero(messages.lengths == size)
        block = messages.block(rows, size)
        while len(rows):
            layout = self._find(block, size) if len(rows) >= _FEW else None
            if layout is None:
                self._one(out, int(rows[0]), bytes(block[0]))
                rows, block = rows[1:], block[1:]
                continue
            same = layout.matches(block)
            own, part = (rows, block) if same.all() else (rows[same], block[same])
            if not self._take(out, layout, own, part):
                for row, message in zip(own, part, strict=True):
                    self._one(out, int(row), bytes(message))
            rows, block = rows[~same], block[~same]

    def _find(self, block: Bytes, size: int) -> JointStateLayout | None:
        known = self._layouts.setdefault(size, [])
        for layout in known:
            if layout.matches(block[:1])[0]:
                return layout
        try:
            known.append(layout_of(bytes(block[0])))
        except LayoutError:
            return None
        del known[:-_LAYOUTS]
        return known[-1]

    def _take(
        self, out: Samples, layout: JointStateLayout, rows: NDArray[np.intp], block: Bytes
    ) -> bool:
        """Columns of many messages; False where each has to be asked what is wrong with it."""
        names, counts = layout.names, [count for _, count in layout.starts]
        parts = [out.position]
        if counts[1] or out.acceleration is not None:
            parts.append(out.velocity)
        if out.acceleration is not None:
            parts.append(out.acceleration)
        complete = counts[: len(parts)] == [len(names)] * len(parts)
        if not complete or any(names.count(joint) != 1 for joint in self._joints):
            return False
        places = [names.index(joint) for joint in self._joints]
        own = slice(None) if len(rows) == len(out) else rows
        out.stamp_ns[own] = stamps = layout.stamps(block)
        out.measured[own] = counts[1] > 0
        good = stamps >= 0
        for which, values in enumerate(parts):
            values[own] = numbers = layout.numbers(block, which)[:, places]
            fit = np.abs(numbers) < LARGEST
            if not fit.all():
                good &= fit.all(axis=1)
        if out.acceleration is None and counts[2] == len(names):
            out.effort[own] = layout.numbers(block, 2)[:, places]
        for k in np.flatnonzero(~good):
            self._one(out, int(rows[k]), bytes(block[k]))
        out.bulk += int(good.sum())
        return True

    def _one(self, out: Samples, row: int, data: bytes) -> None:
        try:
            message: Any = typestore().deserialize_cdr(_fields(data), self._kind)
        except Exception as error:  # noqa: BLE001 - whatever the library meets in damaged bytes
            out.broken[row] = (
                f"no {self._kind.rpartition('/')[2]}: {str(error) or type(error).__name__}"
            )
            return
        sample = motion_of(message) if self._kind == JOINT_MOTION else sample_of(message)
        out.stamp_ns[row] = sample.stamp_ns
        try:
            if sample.stamp_ns < 0:
                told = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
                raise RejectedError(RejectionCode.BAD_STAMP, told)  # noqa: TRY301 - as the pipeline does
            motion = self._order.arrange(sample)
        except RejectedError as error:
            out.rejected[row] = error.rejection
            return
        out.position[row] = motion.position
        out.measured[row] = motion.velocity is not None
        out.velocity[row] = np.nan if motion.velocity is None else motion.velocity
        if out.acceleration is not None:
            out.acceleration[row] = motion.acceleration
            return
        efforts = np.asarray(message.effort)
        if len(efforts) == len(sample.names):
            out.effort[row] = efforts[[sample.names.index(joint) for joint in self._joints]]


def _fields(data: bytes) -> bytes:
    """A message without what its writer left after it, which the library does not take."""
    try:
        return data[: layout_of(data).end]
    except LayoutError:
        return data  # the library says what is wrong


def sample_of(message: Any) -> JointSample:
    """A JointState of rosbags as a sample, as `conversions.sample_of_state` makes it of one of rclpy."""
    velocity = np.array(message.velocity, dtype=np.float64) if len(message.velocity) else None
    return _sample(message, velocity, None)


def motion_of(message: Any) -> JointSample:
    """A JointMotion of rosbags as a sample, as `conversions.sample_of_motion` makes it of one of rclpy."""
    velocity, acceleration = (
        np.array(part, dtype=np.float64) for part in (message.velocity, message.acceleration)
    )
    return _sample(message, velocity, acceleration)


def _sample(
    message: Any, velocity: FloatArray | None, acceleration: FloatArray | None
) -> JointSample:
    stamp = message.header.stamp
    return JointSample(
        stamp_ns=nanoseconds(stamp.sec, stamp.nanosec),
        names=[name.partition("\0")[0] for name in message.name],  # C strings end there
        position=np.array(message.position, dtype=np.float64),
        velocity=velocity,
        acceleration=acceleration,
    )
