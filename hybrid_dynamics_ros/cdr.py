"""CDR: messages whose names and lengths stay, written once; their numbers are filled in, one message or many.

Little-endian CDR as ROS 2 writes it: four bytes that tell the encoding, then the fields, each aligned to its size from
the fifth byte on.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
HEAD: Final = 4
LITTLE: Final = b"\x00\x01\x00\x00"
_STAMP: Final = struct.Struct("<iI")
_NS: Final = 10**9


class Template:
    """A message with fixed names and lengths: `fill` writes many of them at a time, `message` one."""

    def __init__(self) -> None:
        self._parts = bytearray(LITTLE)
        self._slots: dict[str, tuple[int, np.dtype[Any]]] = {}

    def slot(self, name: str, kind: str, count: int = 1) -> Template:
        """Numbers that differ from message to message: `count` of a NumPy type such as "<f8"."""
        one = np.dtype(kind)
        if count:
            self._align(one.itemsize)
        shaped = one if count == 1 else np.dtype((one, (count,)))
        if count:
            self._slots[name] = (len(self._parts), shaped)
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
        self.length(count)
        if count:
            self._align(np.dtype(kind).itemsize)
            self._slots[name] = (len(self._parts), np.dtype((np.dtype(kind), (count,))))
            self._parts += bytes(np.dtype(kind).itemsize * count)
        return self

    def _align(self, size: int) -> None:
        self._parts += bytes(-(len(self._parts) - HEAD) % size)

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return len(self._parts)

    def fill(self, rows: Bytes, values: Mapping[str, NDArray[Any]]) -> None:
        """Write messages into `rows` (N, size) from the slots' values (N, ...)."""
        rows[:] = np.frombuffer(bytes(self._parts), dtype=np.uint8)
        for name, (start, kind) in self._slots.items():
            view = rows[:, start : start + kind.itemsize]
            shape = (len(rows), kind.itemsize)
            part = np.ascontiguousarray(values[name], dtype=kind.base)
            view[:] = part.reshape(len(rows), -1).view(np.uint8).reshape(shape)

    def message(self, stamp_ns: int, values: Mapping[str, NDArray[Any]]) -> bytes:
        """One message that begins with a header: its stamp [ns] and the values of its slots."""
        parts = bytearray(self._parts)
        _STAMP.pack_into(parts, HEAD, *divmod(stamp_ns, _NS))
        for name, value in values.items():
            if value.size:  # an empty sequence has no slot
                start, kind = self._slots[name]
                parts[start : start + kind.itemsize] = value.tobytes()
        return bytes(parts)
