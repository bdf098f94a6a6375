"""Layouts of JointState messages, for reading and writing without message objects."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .cdr import HEAD, LITTLE, NS, STAMP, Bytes, MessageTemplate
from .joint_samples import nanoseconds

# [bytes] longest padding after the fields: some writers pad to four, rclpy adds eight
PADDING: Final = 8


def joint_state_template(names: Sequence[str], *, velocity: bool, effort: bool) -> MessageTemplate:
    """A sensor_msgs/JointState: slots `position`, `velocity`, `effort`.

    Args:
        names: names of the joints.
        velocity: whether there is a slot for velocities; otherwise the field is empty.
        effort: the same for efforts.
    """
    count = len(names)
    template = MessageTemplate().header().strings(names).sequence("position", count)
    for name, has_slot in (("velocity", velocity), ("effort", effort)):
        if has_slot:
            template.sequence(name, count)
        else:
            template.length(0)
    return template


class LayoutError(ValueError):
    """Bytes do not have the expected layout."""


@dataclass(frozen=True, eq=False)
class JointStateLayout:
    """Offsets of the numbers of a JointState, for messages that are equal otherwise.

    A JointMotion has the same layout, with accelerations in place of efforts.

    Attributes:
        names: names of the joints.
        starts: offset and count of position, velocity and effort.
        size: size of a message [bytes].
        end: offset after its fields.
        fixed: bytes that all messages of the layout share, without padding.
        places: offsets of the fixed bytes.
    """

    names: tuple[str, ...]
    starts: tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
    size: int
    end: int
    fixed: Bytes = field(repr=False)
    places: NDArray[np.intp] = field(repr=False)

    def matches(self, rows: Bytes) -> NDArray[np.bool_]:
        """Mask (N,) of messages (N, size) with this layout."""
        same: NDArray[np.bool_] = (rows[:, self.places] == self.fixed).all(axis=1)
        return same

    @cached_property
    def _segments(self) -> list[tuple[int, bytes]]:
        """Runs of fixed bytes, with offsets."""
        breaks = np.flatnonzero(np.diff(self.places) > 1) + 1
        edges = [0, *breaks.tolist(), len(self.places)]
        return [(int(self.places[i]), self.fixed[i:j].tobytes()) for i, j in pairwise(edges)]

    def fits(self, message: bytes) -> bool:
        """Whether one message has this layout."""
        if len(message) != self.size:
            return False
        # Called for every message; a loop is faster than a generator.
        for start, fixed in self._segments:  # noqa: SIM110
            if not message.startswith(fixed, start):
                return False
        return True

    def stamp(self, message: bytes) -> int:
        """Stamp of one message [ns]; -1 if the nanoseconds are a second or more."""
        return nanoseconds(*STAMP.unpack_from(message, HEAD))

    def numbers_of(self, message: bytes, which: int) -> NDArray[np.float64]:
        """Positions (0), velocities (1) or efforts (2) of one message, (count,)."""
        start, count = self.starts[which]
        return np.frombuffer(message, dtype="<f8", count=count, offset=start)

    def stamps(self, rows: Bytes) -> NDArray[np.int64]:
        """Stamps (N,) [ns]; -1 if the nanoseconds are a second or more."""
        sec = rows[:, 4:8].view("<i4")[:, 0].astype(np.int64)
        nanosec = rows[:, 8:12].view("<u4")[:, 0].astype(np.int64)
        return np.where(nanosec < NS, sec * NS + nanosec, -1)

    def numbers(self, rows: Bytes, which: int) -> NDArray[np.float64]:
        """Positions (0), velocities (1) or efforts (2), (N, count)."""
        start, count = self.starts[which]
        return rows[:, start : start + 8 * count].view("<f8").astype(np.float64)


def layout_of(message: bytes) -> JointStateLayout:
    """The layout of one JointState.

    Raises:
        LayoutError: it is not little-endian CDR, or has a wrong length.
    """
    if message[:HEAD] != LITTLE:
        raise LayoutError("not plain little-endian CDR")
    reader = _Reader(message)
    reader.skip(STAMP.size)
    reader.string()
    names = tuple(reader.string() for _ in range(reader.count()))
    starts = (reader.doubles(), reader.doubles(), reader.doubles())
    size = len(message)
    if not 0 <= size - reader.place <= PADDING:
        raise LayoutError(f"{size} bytes; its fields take {reader.place}")
    places = np.flatnonzero(reader.is_fixed[:size])
    fixed = np.frombuffer(message, np.uint8)[places]
    return JointStateLayout(names, starts, size, reader.place, fixed, places)


class _Reader:
    """Parses the fields of a message, and marks its fixed bytes."""

    def __init__(self, message: bytes) -> None:
        self.message, self.place = message, HEAD
        self.is_fixed = np.zeros(len(message) + 8, dtype=bool)
        self.is_fixed[:HEAD] = True

    def skip(self, size: int) -> None:
        self.place += size

    def count(self) -> int:
        self._align(4)
        if self.place + 4 > len(self.message):
            raise LayoutError("ends before its fields do")
        (value,) = struct.unpack_from("<I", self.message, self.place)
        self._fixed(4)
        if value > len(self.message):
            raise LayoutError(f"a length of {value} in {len(self.message)} bytes")
        return int(value)

    def string(self) -> str:
        size = self.count()
        text = self.message[self.place : self.place + size]
        if len(text) != size or (size and text[-1]):
            raise LayoutError("a string without its end")
        if b"\0" in text[:-1]:  # ROS strings end at a null byte
            raise LayoutError(f"a name that ends before its length: {text[:-1]!r}")
        self._fixed(size)
        try:
            return text[:-1].decode()
        except UnicodeDecodeError as error:
            raise LayoutError(f"a name that is no text: {text[:-1]!r}") from error

    def doubles(self) -> tuple[int, int]:
        count = self.count()
        if count:
            self._align(8)
        start = self.place
        self.skip(8 * count)
        if self.place > len(self.message):
            raise LayoutError("ends before its numbers do")
        return start, count

    def _align(self, size: int) -> None:
        self.place += -(self.place - HEAD) % size

    def _fixed(self, size: int) -> None:
        self.is_fixed[self.place : self.place + size] = True
        self.place += size
