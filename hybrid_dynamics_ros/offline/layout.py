"""Where the numbers of a JointState are in its bytes, so that many messages of one layout are one array."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_ros.cdr import HEAD, LITTLE, Bytes


class LayoutError(ValueError):
    """Bytes are not of the layout that was expected."""


@dataclass(frozen=True, eq=False)
class JointStateLayout:
    """Where the numbers of a JointState are, for messages that differ in nothing else.

    Attributes:
        names: joints.
        starts: of position, velocity and effort: first byte and how many numbers.
        size: bytes of a message.
        fixed: bytes that all messages of the layout share (padding is left out), and their values.
    """

    names: tuple[str, ...]
    starts: tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
    size: int
    fixed: Bytes = field(repr=False)
    places: NDArray[np.intp] = field(repr=False)

    def matches(self, rows: Bytes) -> NDArray[np.bool_]:
        """Which of the messages (N, size) have this layout."""
        same: NDArray[np.bool_] = (rows[:, self.places] == self.fixed).all(axis=1)
        return same

    def stamps(self, rows: Bytes) -> NDArray[np.int64]:
        """Stamps (N,) [ns]; -1 where the nanoseconds are a second or more."""
        words = np.ascontiguousarray(rows[:, 4:12])
        sec = words[:, :4].copy().view("<i4")[:, 0].astype(np.int64)
        nanosec = words[:, 4:].copy().view("<u4")[:, 0].astype(np.int64)
        return np.where(nanosec < 10**9, sec * 10**9 + nanosec, -1)

    def numbers(self, rows: Bytes, which: int) -> NDArray[np.float64]:
        """Positions (0), velocities (1) or efforts (2), (N, count)."""
        start, count = self.starts[which]
        part = np.ascontiguousarray(rows[:, start : start + 8 * count])
        return part.view("<f8").reshape(len(rows), count).astype(np.float64, copy=False)


def layout_of(message: bytes) -> JointStateLayout:
    """The layout of one JointState.

    Raises:
        LayoutError: it is not little-endian CDR, or ends early or late.
    """
    if message[:4] != LITTLE:
        raise LayoutError("not plain little-endian CDR")
    reader = _Reader(message)
    reader.skip(8)
    reader.string()
    names = tuple(reader.string() for _ in range(reader.count()))
    starts = (reader.doubles(), reader.doubles(), reader.doubles())
    if reader.at > len(message) or len(message) - reader.at > 3:  # some writers pad to four bytes
        raise LayoutError(f"{len(message)} bytes; its fields take {reader.at}")
    places = np.flatnonzero(reader.fixed[: len(message)])
    return JointStateLayout(names, starts, len(message), np.frombuffer(message, np.uint8)[places], places)


class _Reader:
    def __init__(self, message: bytes) -> None:
        self.message, self.at = message, HEAD
        self.fixed = np.zeros(len(message) + 8, dtype=bool)
        self.fixed[:HEAD] = True

    def skip(self, size: int) -> None:
        self.at += size

    def count(self) -> int:
        self.at += -(self.at - HEAD) % 4
        if self.at + 4 > len(self.message):
            raise LayoutError("ends before its fields do")
        (value,) = struct.unpack_from("<I", self.message, self.at)
        self.fixed[self.at : self.at + 4] = True
        self.at += 4
        if value > len(self.message):
            raise LayoutError(f"a length of {value} in {len(self.message)} bytes")
        return int(value)

    def string(self) -> str:
        size = self.count()
        text = self.message[self.at : self.at + size]
        if len(text) != size or (size and text[-1]):
            raise LayoutError("a string without its end")
        self.fixed[self.at : self.at + size] = True
        self.at += size
        try:
            return text[:-1].decode()
        except UnicodeDecodeError as error:
            raise LayoutError(f"a name that is no text: {text[:-1]!r}") from error

    def doubles(self) -> tuple[int, int]:
        count = self.count()
        if count:
            self.at += -(self.at - HEAD) % 8
        start = self.at
        self.at += 8 * count
        if self.at > len(self.message):
            raise LayoutError("ends before its numbers do")
        return start, count
