"""CDR: where the numbers of a message are, to write or read them without an object for each message.

Little-endian CDR as ROS 2 writes it: four bytes that tell the encoding, then the fields, each
aligned to its size from the fifth byte on.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .joint_samples import nanoseconds

Bytes = NDArray[np.uint8]
HEAD: Final = 4
LITTLE: Final = b"\x00\x01\x00\x00"
PADDING: Final = (
    8  # bytes that writers leave after the fields, at most: some pad to four, rclpy leaves eight
)
_STAMP: Final = struct.Struct("<iI")
_DOUBLE: Final = struct.Struct("<d")
_FLOAT64: Final = np.dtype("<f8")
_NS: Final = 10**9
LEAST_SEC: Final = -(2**31)  # [s] of builtin_interfaces/Time
MOST_SEC: Final = 2**31 - 1


class Template:
    """A message with fixed names and lengths: `pattern` and `columns` make many of them at a time, `fill` one."""

    def __init__(self) -> None:
        self._parts = bytearray(LITTLE)
        self._slots: list[tuple[str, int, np.dtype[Any]]] = []  # complete before the first message

    def slot(self, name: str, kind: str, count: int = 1) -> Template:
        """Numbers that differ from message to message: `count` of a NumPy type such as "<f8"."""
        one = np.dtype(kind)
        if count:
            self._align(one.itemsize)
        self._slots.append(
            (name, len(self._parts), one if count == 1 else np.dtype((one, (count,))))
        )
        self._parts += bytes(one.itemsize * count)
        return self

    def header(self, frame: str = "") -> Template:
        """A std_msgs/Header: slots `sec` and `nanosec`, and a frame that stays."""
        return self.slot("sec", "<i4").slot("nanosec", "<u4").string(frame)

    def string(self, text: str) -> Template:
        """A string that stays."""
        encoded = text.encode() + b"\0"
        self.length(len(encoded))
        self._parts += encoded
        return self

    def strings(self, texts: Sequence[str]) -> Template:
        """A sequence of strings that stay."""
        self.length(len(texts))
        for text in texts:
            self.string(text)
        return self

    def length(self, count: int) -> Template:
        """The length of a sequence."""
        self._align(4)
        self._parts += struct.pack("<I", count)
        return self

    def sequence(self, name: str, count: int, kind: str = "<f8") -> Template:
        """A sequence of numbers: its length stays."""
        return self.length(count).slot(name, kind, count)

    def _align(self, size: int) -> None:
        self._parts += bytes(-(len(self._parts) - HEAD) % size)

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return len(self._parts)

    @property
    def pattern(self) -> Bytes:
        """A message whose numbers are zero, (size,)."""
        return np.frombuffer(bytes(self._parts), dtype=np.uint8)

    def named(
        self, stamp_ns: NDArray[np.int64], values: Sequence[NDArray[Any] | float]
    ) -> dict[str, NDArray[Any]]:
        """Slots of N messages, for `columns`: stamps of their headers [ns] and the other slots, in order."""
        slots: dict[str, NDArray[Any]] = {"sec": stamp_ns // _NS, "nanosec": stamp_ns % _NS}
        names = [name for name, _, _ in self._slots if name not in slots]
        slots.update(zip(names, map(np.asarray, values), strict=True))
        return slots

    def columns(self, values: Mapping[str, NDArray[Any]]) -> list[tuple[int, Bytes]]:
        """Where in a message each slot is, and the bytes (N, k) of its values in N messages, given as (N, ...)."""
        found = []
        for name, start, kind in self._slots:
            if not kind.itemsize:
                continue
            part = np.ascontiguousarray(values[name], dtype=kind.base)
            found.append((start, part.reshape(len(part), -1).view(np.uint8)))
        return found

    def fill(self, stamp_ns: int, values: Iterable[NDArray[Any] | float]) -> bytes:
        """One message: the stamp of its headers [ns] and the values of its other slots, in their order.

        Raises ValueError where there are more or fewer values than slots, or one is of another type
        or count, and where the stamp is beyond the seconds that a message of ROS can hold.
        """
        pieces, stamps, numbers = self._pieces
        pieces = pieces.copy()
        try:
            stamp = _STAMP.pack(*divmod(stamp_ns, _NS))
        except struct.error as error:  # asked for afterwards: a good stamp pays nothing
            told = (
                f"the stamp {stamp_ns} ns is {stamp_ns / _NS:.10g} s; messages of ROS have seconds"
                " in 32 bits"
            )
            raise ValueError(f"{told}, from {LEAST_SEC} to {MOST_SEC} (January 2038)") from error
        for hole in stamps:
            pieces[hole] = stamp
        for (hole, size, kind, name), value in zip(numbers, values, strict=True):
            if isinstance(value, float):
                data, own = _DOUBLE.pack(value), _FLOAT64
            else:
                data, own = value.tobytes(), value.dtype
            if len(data) != size or (own is not kind and own != kind):
                raise ValueError(
                    f"slot {name}: {len(data)} bytes of {own}; expected {size} of {kind}"
                )
            pieces[hole] = data
        return b"".join(pieces)

    @cached_property
    def _pieces(self) -> tuple[list[bytes], list[int], list[tuple[int, int, np.dtype[Any], str]]]:
        """The message cut at its slots; which pieces are stamps, and which are numbers: size, type and name."""
        pieces, stamps, numbers, end = [], [], [], 0
        for name, at, kind in self._slots:
            if name == "nanosec":  # went with the seconds
                continue
            pieces += [bytes(self._parts[end:at]), b""]
            if name == "sec":
                stamps.append(len(pieces) - 1)
                end = at + _STAMP.size
            else:
                numbers.append((len(pieces) - 1, kind.itemsize, kind.base, name))
                end = at + kind.itemsize
        return [*pieces, bytes(self._parts[end:])], stamps, numbers


class LayoutError(ValueError):
    """Bytes are not of the layout that was expected."""


@dataclass(frozen=True, eq=False)
class JointStateLayout:
    """Where the numbers of a JointState are, for messages that differ in nothing else.

    A JointMotion is laid out alike, with accelerations in the place of efforts.

    Attributes:
        names: joints.
        starts: of position, velocity and effort: first byte and how many numbers.
        size: bytes of a message; end: those of its fields.
        fixed: bytes that all messages of the layout share (padding is left out), and their values.
    """

    names: tuple[str, ...]
    starts: tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
    size: int
    end: int
    fixed: Bytes = field(repr=False)
    places: NDArray[np.intp] = field(repr=False)

    def matches(self, rows: Bytes) -> NDArray[np.bool_]:
        """Which of the messages (N, size) have this layout."""
        same: NDArray[np.bool_] = (rows[:, self.places] == self.fixed).all(axis=1)
        return same

    @cached_property
    def _segments(self) -> list[tuple[int, bytes]]:
        """The fixed bytes in runs."""
        edges = [0, *(np.flatnonzero(np.diff(self.places) > 1) + 1).tolist(), len(self.places)]
        return [(int(self.places[i]), self.fixed[i:j].tobytes()) for i, j in pairwise(edges)]

    def fits(self, message: bytes) -> bool:
        """Whether one message has this layout."""
        if len(message) != self.size:
            return False
        # Looked at for every message: a loop is quicker than a generator.
        for at, own in self._segments:  # noqa: SIM110
            if not message.startswith(own, at):
                return False
        return True

    def stamp(self, message: bytes) -> int:
        """Stamp of one message [ns]; -1 where the nanoseconds are a second or more."""
        return nanoseconds(*_STAMP.unpack_from(message, HEAD))

    def numbers_of(self, message: bytes, which: int) -> NDArray[np.float64]:
        """Positions (0), velocities (1) or efforts (2) of one message, (count,)."""
        start, count = self.starts[which]
        return np.frombuffer(message, dtype="<f8", count=count, offset=start)

    def stamps(self, rows: Bytes) -> NDArray[np.int64]:
        """Stamps (N,) [ns]; -1 where the nanoseconds are a second or more."""
        sec = rows[:, 4:8].view("<i4")[:, 0].astype(np.int64)
        nanosec = rows[:, 8:12].view("<u4")[:, 0].astype(np.int64)
        return np.where(nanosec < _NS, sec * _NS + nanosec, -1)

    def numbers(self, rows: Bytes, which: int) -> NDArray[np.float64]:
        """Positions (0), velocities (1) or efforts (2), (N, count)."""
        start, count = self.starts[which]
        return rows[:, start : start + 8 * count].view("<f8").astype(np.float64)


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
    if reader.at > len(message) or len(message) - reader.at > PADDING:
        raise LayoutError(f"{len(message)} bytes; its fields take {reader.at}")
    places = np.flatnonzero(reader.fixed[: len(message)])
    return JointStateLayout(
        names, starts, len(message), reader.at, np.frombuffer(message, np.uint8)[places], places
    )


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
        if b"\0" in text[:-1]:
            raise LayoutError(
                f"a name that ends before its length: {text[:-1]!r}"
            )  # ROS reads it up to there
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
