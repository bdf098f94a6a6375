"""Writing of CDR messages as bytes, without message objects.

ROS 2 uses little-endian CDR: four bytes for the encoding, then the fields. Each field is aligned to
its size, counted from the fifth byte.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
HEAD: Final = 4  # [bytes] encapsulation header before the fields
LITTLE: Final = b"\x00\x01\x00\x00"
STAMP: Final = struct.Struct("<iI")
NS: Final = 10**9  # [ns] in a second
LEAST_SEC: Final = -(2**31)  # [s] of builtin_interfaces/Time
MOST_SEC: Final = 2**31 - 1
_DOUBLE: Final = struct.Struct("<d")
_FLOAT64: Final = np.dtype("<f8")


class MessageTemplate:
    """A message with fixed names and lengths, and slots for numbers.

    `fill` makes one message; `pattern` and `columns` make many.
    """

    def __init__(self) -> None:
        self._parts = bytearray(LITTLE)
        self._slots: list[tuple[str, int, np.dtype[Any]]] = []  # (name, offset [bytes], type)

    def slot(self, name: str, kind: str, count: int = 1) -> MessageTemplate:
        """Append a slot for numbers.

        Args:
            name: name of the slot.
            kind: a NumPy type such as "<f8".
            count: number of numbers.
        """
        one = np.dtype(kind)
        if count:
            self._align(one.itemsize)
        slot_type = one if count == 1 else np.dtype((one, (count,)))
        self._slots.append((name, len(self._parts), slot_type))
        self._parts += bytes(one.itemsize * count)
        return self

    def header(self, frame: str = "") -> MessageTemplate:
        """Append a std_msgs/Header: slots `sec` and `nanosec`, and a fixed frame."""
        return self.slot("sec", "<i4").slot("nanosec", "<u4").string(frame)

    def string(self, text: str) -> MessageTemplate:
        """Append a fixed string."""
        encoded = text.encode() + b"\0"
        self.length(len(encoded))
        self._parts += encoded
        return self

    def strings(self, texts: Sequence[str]) -> MessageTemplate:
        """Append a sequence of fixed strings."""
        self.length(len(texts))
        for text in texts:
            self.string(text)
        return self

    def length(self, count: int) -> MessageTemplate:
        """Append the length of a sequence."""
        self._align(4)
        self._parts += struct.pack("<I", count)
        return self

    def sequence(self, name: str, count: int, kind: str = "<f8") -> MessageTemplate:
        """Append a sequence of numbers of fixed length."""
        return self.length(count).slot(name, kind, count)

    def _align(self, size: int) -> None:
        self._parts += bytes(-(len(self._parts) - HEAD) % size)

    @property
    def size(self) -> int:
        """Size of a message [bytes]."""
        return len(self._parts)

    @property
    def pattern(self) -> Bytes:
        """The bytes (size,) of a message with all numbers zero."""
        return np.frombuffer(bytes(self._parts), dtype=np.uint8)

    def named(
        self, stamp_ns: NDArray[np.int64], values: Sequence[NDArray[Any] | float]
    ) -> dict[str, NDArray[Any]]:
        """Values of N messages by slot, for `columns`.

        Args:
            stamp_ns: stamps of their headers (N,) [ns].
            values: values of the other slots, in order, (N, ...).
        """
        slots: dict[str, NDArray[Any]] = {"sec": stamp_ns // NS, "nanosec": stamp_ns % NS}
        names = [name for name, _, _ in self._slots if name not in slots]
        slots.update(zip(names, map(np.asarray, values), strict=True))
        return slots

    def columns(self, values: Mapping[str, NDArray[Any]]) -> list[tuple[int, Bytes]]:
        """For each slot, its offset in a message, and the bytes (N, k) of its values.

        Args:
            values: values of the slots in N messages, (N, ...).
        """
        columns = []
        for name, start, kind in self._slots:
            if kind.itemsize:
                part = np.ascontiguousarray(values[name], dtype=kind.base)
                columns.append((start, part.reshape(len(part), -1).view(np.uint8)))
        return columns

    def fill(self, stamp_ns: int, values: Iterable[NDArray[Any] | float]) -> bytes:
        """Make one message.

        Args:
            stamp_ns: stamp of its headers [ns].
            values: values of the other slots, in order.

        Raises:
            ValueError: the number of values, or the type or count of one, is wrong, or the stamp is
                out of ROS's range.
        """
        pieces, stamps, numbers = self._pieces
        pieces = pieces.copy()
        try:
            stamp = STAMP.pack(*divmod(stamp_ns, NS))
        except struct.error as error:  # checked only after a failure
            raise ValueError(_beyond(stamp_ns)) from error
        for hole in stamps:
            pieces[hole] = stamp
        for (hole, size, kind, name), value in zip(numbers, values, strict=True):
            if isinstance(value, float):
                data, given = _DOUBLE.pack(value), _FLOAT64
            else:
                data, given = value.tobytes(), value.dtype
            if len(data) != size or (given is not kind and given != kind):
                raise ValueError(
                    f"slot {name}: {len(data)} bytes of {given}; expected {size} of {kind}"
                )
            pieces[hole] = data
        return b"".join(pieces)

    @cached_property
    def _pieces(self) -> _Pieces:
        """The message cut at its slots."""
        pieces = _Pieces([], [], [])
        end = 0
        for name, start, kind in self._slots:
            if name == "nanosec":  # written with the seconds
                continue
            pieces.parts.extend((bytes(self._parts[end:start]), b""))
            hole = len(pieces.parts) - 1
            if name == "sec":
                pieces.stamps.append(hole)
                end = start + STAMP.size
            else:
                pieces.numbers.append((hole, kind.itemsize, kind.base, name))
                end = start + kind.itemsize
        pieces.parts.append(bytes(self._parts[end:]))
        return pieces


class _Pieces(NamedTuple):
    """A message cut at its slots.

    Attributes:
        parts: fixed pieces, with an empty one for each slot.
        stamps: indices in `parts` of the stamps.
        numbers: index in `parts`, size [bytes], type and name of each other slot.
    """

    parts: list[bytes]
    stamps: list[int]
    numbers: list[tuple[int, int, np.dtype[Any], str]]


def _beyond(stamp_ns: int) -> str:
    return (
        f"the stamp {stamp_ns} ns is {stamp_ns / NS:.10g} s; messages of ROS have seconds in 32"
        f" bits, from {LEAST_SEC} to {MOST_SEC} (January 2038)"
    )
