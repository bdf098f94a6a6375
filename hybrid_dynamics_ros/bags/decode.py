"""Bulk decoding of joint states and motions: messages of one layout become columns at once.

Other messages are decoded one by one with rosbags.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..messages.cdr import Bytes
from ..messages.extra_joints import ExtraJoints, PassThrough
from ..messages.interfaces import JOINT_MOTION, JOINT_STATE, deserialize
from ..messages.joint_samples import (
    LARGEST,
    LONGEST,
    FloatArray,
    JointOrder,
    JointSample,
    RejectedError,
    RejectionCode,
    nanoseconds,
    oversized,
)
from ..messages.joint_state_layout import JointStateLayout, LayoutError, layout_of
from ..messages.readings import MAX_AGE, ReadingOrder
from .samples import Samples
from .storage.storage import Messages

_MAX_LAYOUTS: Final = 32  # cached per message size; a bag has only a few
_MIN_BULK: Final = 4  # least number of messages of one layout for which it saves time


class Decoder:
    """Decodes the messages of one topic, and caches their layouts."""

    def __init__(
        self,
        joints: Sequence[str],
        kind: str = JOINT_STATE,
        *,
        bulk: bool = True,
        resting: Mapping[str, float] | None = None,
        max_age: float = MAX_AGE,
        extras: PassThrough | None = None,
    ) -> None:
        """Start without messages.

        Args:
            joints: the requested joints, in order.
            kind: type of the messages, JOINT_STATE or JOINT_MOTION.
            bulk: False: decode every message with rosbags.
            resting: default positions of joints that messages may leave out [rad or m].
            max_age: largest difference of stamps at which partial joint states are joined [s]; 0:
                they are refused.
            extras: collects joints that the robot does not have; messages are then decoded one by
                one.
        """
        self._joints = tuple(joints)
        self._kind = kind
        self._bulk = bulk and extras is None
        self._extras = extras
        self._newest: dict[int, tuple[ExtraJoints, ...]] = {}  # latest extra joints by row
        self._resting = dict(resting or {})
        self._order = JointOrder(joints, resting)
        self._readings = ReadingOrder(joints, resting, max_age)
        self._refusals: dict[int, RejectedError] = {}  # refusals of partial rows
        self._layouts: dict[int, list[JointStateLayout]] = {}  # by message size

    def decode(self, messages: Messages) -> Samples:
        """The samples of messages, in continuation of those decoded before."""
        self._refusals.clear()
        self._newest.clear()
        has_acceleration = self._kind == JOINT_MOTION
        samples = Samples.blank(
            messages.log_ns, len(self._joints), has_acceleration=has_acceleration
        )
        if self._bulk:
            for size in messages.sizes():
                self._decode_size(samples, messages, size)
        else:
            for row in range(len(messages)):
                self._decode_one(samples, row, messages.message(row))
        if self._refusals or not self._readings.joiner.is_clear:
            self._join(samples)
        if self._extras is not None:
            stamps = samples.stamp_ns.tolist()
            none: tuple[ExtraJoints, ...] = ()
            samples.extras = [
                self._extras.at(stamp, self._newest.get(row, none))
                for row, stamp in enumerate(stamps)
            ]
        return samples

    def _join(self, samples: Samples) -> None:
        """Join partial rows, in order."""
        joiner = self._readings.joiner
        for row in np.flatnonzero(samples.usable).tolist():
            refusal = self._refusals.get(row)
            if refusal is None:
                joiner.clear()
                continue
            values = [samples.position[row], samples.velocity[row], samples.effort[row]]
            try:
                joined = joiner.add(int(samples.stamp_ns[row]), np.array(values), refusal)
            except RejectedError as error:
                samples.rejected[row] = error.rejection
                continue
            if joined is None:
                samples.waiting[row] = None
                continue
            samples.stamp_ns[row] = joined.stamp_ns
            samples.position[row], samples.velocity[row], samples.effort[row] = joined.values

    def _decode_size(self, samples: Samples, messages: Messages, size: int) -> None:
        """Decode the messages of one size, by layout."""
        rows = np.flatnonzero(messages.lengths == size)
        block = messages.block(rows, size)
        while len(rows):
            layout = None
            if len(rows) >= _MIN_BULK and size <= LONGEST:
                layout = self._layout_of_first(block)
            if layout is None:
                self._decode_one(samples, int(rows[0]), bytes(block[0]))
                rows = rows[1:]
                block = block[1:]
                continue
            matches = layout.matches(block)
            if matches.all():
                self._decode_layout(samples, layout, rows, block)
                return
            self._decode_layout(samples, layout, rows[matches], block[matches])
            rows = rows[~matches]
            block = block[~matches]

    def _layout_of_first(self, block: Bytes) -> JointStateLayout | None:
        """The layout of the first message; None if it has none."""
        layouts = self._layouts.setdefault(block.shape[1], [])
        for layout in layouts:
            if layout.matches(block[:1])[0]:
                return layout
        try:
            layouts.append(layout_of(bytes(block[0])))
        except LayoutError:
            return None
        del layouts[:-_MAX_LAYOUTS]
        return layouts[-1]

    def _decode_layout(
        self, samples: Samples, layout: JointStateLayout, rows: NDArray[np.intp], block: Bytes
    ) -> None:
        """Decode messages of one layout: in bulk if it is complete, otherwise one by one."""
        # layout.starts: (first byte, count) of position, velocity, and effort or acceleration. A
        # motion must have all three; otherwise it is decoded by itself, and refused.
        targets = [samples.position]
        if layout.starts[1][1] or samples.acceleration is not None:
            targets.append(samples.velocity)
        if samples.acceleration is not None:
            targets.append(samples.acceleration)
        if self._is_complete(layout, len(targets)):
            self._decode_block(samples, layout, targets, rows, block)
            return
        for row, message in zip(rows.tolist(), block, strict=True):
            self._decode_one(samples, row, bytes(message))

    def _is_complete(self, layout: JointStateLayout, part_count: int) -> bool:
        """Whether a layout has each joint once, and a number for each name in its first arrays.

        Joints with a default may be missing.
        """
        names = layout.names
        for joint in self._joints:
            count = names.count(joint)
            if count != 1 and not (count == 0 and joint in self._resting):
                return False
        return all(count == len(names) for _, count in layout.starts[:part_count])

    def _decode_block(
        self,
        samples: Samples,
        layout: JointStateLayout,
        targets: Sequence[FloatArray],
        rows: NDArray[np.intp],
        block: Bytes,
    ) -> None:
        """Read columns of messages; those with an invalid stamp or number go one by one."""
        names = layout.names
        selection: slice | NDArray[np.intp] = rows
        if len(rows) == len(samples):
            selection = slice(None)
        stamps = layout.stamps(block)
        samples.stamp_ns[selection] = stamps
        good = stamps >= 0
        may_be_absent = samples.acceleration is None
        for which, target in enumerate(targets):
            numbers = self._columns(names, layout.numbers(block, which), at_rest=which == 0)
            in_range = np.abs(numbers) < LARGEST
            if which == 1 and may_be_absent and not in_range.all():
                numbers, in_range = self._with_absences(names, numbers)
            target[selection] = numbers
            if not in_range.all():
                good &= in_range.all(axis=1)
        if samples.acceleration is None and layout.starts[2][1] == len(names):
            samples.effort[selection] = self._columns(names, layout.numbers(block, 2))
        for k in np.flatnonzero(~good):
            self._decode_one(samples, int(rows[k]), bytes(block[k]))
        samples.bulk_count += int(good.sum())

    def _with_absences(
        self, names: Sequence[str], rates: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Velocities (rows, n), NaN where absent, and a mask of those that are absent or valid.

        If all named joints have no velocity, joints at rest have none either.
        """
        is_absent = np.isnan(rates)
        is_named = np.array([joint in names for joint in self._joints])
        rates[is_absent[:, is_named].all(axis=1)] = np.nan
        return rates, is_absent | (np.abs(rates) < LARGEST)

    def _decode_one(self, samples: Samples, row: int, data: bytes) -> None:
        """Decode one message with rosbags; its error is stored."""
        rejection = oversized(len(data))
        if rejection is not None:
            samples.rejected[row] = rejection
            return
        try:
            message = deserialize(_without_padding(data), self._kind)
        except Exception as error:  # noqa: BLE001 - whatever rosbags meets in damaged bytes
            type_name = self._kind.rpartition("/")[2]
            samples.broken[row] = f"no {type_name}: {str(error) or type(error).__name__}"
            return
        try:
            self._take(samples, row, message)
        except RejectedError as error:
            samples.rejected[row] = error.rejection

    def _take(self, samples: Samples, row: int, message: Any) -> None:
        """Store the numbers of one message; raises RejectedError if it is invalid."""
        is_motion = self._kind == JOINT_MOTION
        sample = sample_of_motion(message) if is_motion else sample_of_state(message)
        samples.stamp_ns[row] = sample.stamp_ns
        _require_stamp(sample.stamp_ns)
        if is_motion:
            motion = self._order.arrange(sample)
        else:
            if self._extras is not None:
                has_no_others = self._extras.take(sample)
                self._newest[row] = self._extras.newest
                if has_no_others:
                    samples.waiting[row] = None
                    return
            motion, refusal = self._readings.read(sample)
            if refusal is not None:
                self._refusals[row] = refusal
        samples.position[row] = motion.position
        samples.velocity[row] = np.nan if motion.velocity is None else motion.velocity
        if samples.acceleration is not None:
            samples.acceleration[row] = motion.acceleration
        elif len(message.effort) == len(sample.names):
            efforts = np.array(message.effort, dtype=np.float64)[None]
            samples.effort[row] = self._columns(sample.names, efforts)[0]

    def _columns(
        self, names: Sequence[str], numbers: FloatArray, *, at_rest: bool = False
    ) -> FloatArray:
        """Columns of the joints (rows, n), from columns of the message's names (rows, k).

        Args:
            names: names of the columns.
            numbers: one row for each message.
            at_rest: whether missing joints have their default position, and not 0. Joints without a
                default have NaN.
        """
        columns = np.full((len(numbers), len(self._joints)), np.nan)
        for k, joint in enumerate(self._joints):
            if joint in names:
                columns[:, k] = numbers[:, names.index(joint)]
            elif joint in self._resting:
                columns[:, k] = self._resting[joint] if at_rest else 0.0
        return columns


def _require_stamp(stamp_ns: int) -> None:
    if stamp_ns < 0:
        text = f"stamp is {stamp_ns} ns, expected 0 or more"
        raise RejectedError(RejectionCode.BAD_STAMP, text)


def _without_padding(data: bytes) -> bytes:
    """A message without trailing padding, which rosbags refuses."""
    try:
        return data[: layout_of(data).end]
    except LayoutError:
        return data  # rosbags raises the error


def sample_of_state(message: Any) -> JointSample:
    """A JointState of rosbags as a sample; `conversions` does it for rclpy."""
    velocity = effort = None
    if len(message.velocity):
        velocity = np.array(message.velocity, dtype=np.float64)
    if len(message.effort):
        effort = np.array(message.effort, dtype=np.float64)
    return _sample(message, velocity, None)._replace(effort=effort)


def sample_of_motion(message: Any) -> JointSample:
    """A JointMotion of rosbags as a sample; `conversions` does it for rclpy."""
    velocity = np.array(message.velocity, dtype=np.float64)
    acceleration = np.array(message.acceleration, dtype=np.float64)
    return _sample(message, velocity, acceleration)


def _sample(
    message: Any, velocity: FloatArray | None, acceleration: FloatArray | None
) -> JointSample:
    stamp = message.header.stamp
    return JointSample(
        stamp_ns=nanoseconds(stamp.sec, stamp.nanosec),
        names=[name.partition("\0")[0] for name in message.name],  # C strings end at a null byte
        position=np.array(message.position, dtype=np.float64),
        velocity=velocity,
        acceleration=acceleration,
    )
