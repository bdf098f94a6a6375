"""Segments of an MCAP file with messages: chunks, and runs of messages outside chunks."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.ground.wording import counted

from .compression import ZSTD_ERRORS, decompress_chunk
from .mcap_format import unpack_text

Span = tuple[int, int]  # first and last log time [ns]
_SIZES: Final = struct.Struct("<QI")  # uncompressed size of the records, and their checksum
_SIZES_OFFSET: Final = 16  # after the log times
_METHOD_OFFSET: Final = 28
_BROKEN_CHUNK: Final = (
    *ZSTD_ERRORS,
    struct.error,
    IndexError,
    UnicodeDecodeError,
    RuntimeError,
    ValueError,
    MemoryError,
)


class LostChunkError(Exception):
    """The records of a chunk are damaged; the text says how."""


@dataclass
class Segment:
    """A chunk, or a run of messages outside chunks.

    Attributes:
        start: its offset in the file; for a chunk, that of the record's body.
        size: its size [bytes].
        is_chunk: whether it is a chunk.
        spans: log times in the header of the chunk, and in the index of chunks.
        indexed: log times in the message indices after it.
    """

    start: int
    size: int
    is_chunk: bool
    spans: list[Span]
    indexed: Span | None = None

    @property
    def agreed_span(self) -> Span | None:
        """The span on which at least two places agree, without contradiction; otherwise None."""
        spans = self.spans
        if self.indexed is not None:
            spans = [*spans, self.indexed]
        if len(spans) < 2 or len(set(spans)) > 1:
            return None
        return spans[0]

    def add_index(self, times: NDArray[np.uint64]) -> None:
        """Add the log times of a message index [ns]."""
        first, last = int(times.min()), int(times.max())
        if self.indexed is not None:
            first = min(first, self.indexed[0])
            last = max(last, self.indexed[1])
        self.indexed = (first, last)

    def describe(self) -> str:
        """Text on its position in the file and in time."""
        first, last = self.spans[-1]
        return f"the chunk at byte {self.start} (log times {first} to {last} ns)"


def unpack_chunk(raw: bytes) -> tuple[bytes, bool]:
    """The records of a chunk, and whether a checksum verified them.

    Raises:
        LostChunkError: decompression failed, or the checksum is wrong.
    """
    try:
        size, checksum = _SIZES.unpack_from(raw, _SIZES_OFFSET)
        method, place = unpack_text(raw, _METHOD_OFFSET)
        (length,) = struct.unpack_from("<Q", raw, place)
        start = place + 8
        records = decompress_chunk(method, raw[start : start + length], size)
    except _BROKEN_CHUNK as error:
        raise LostChunkError(f"it cannot be unpacked ({error})") from error
    if len(records) != size:
        raise LostChunkError(f"it has {counted(len(records), 'byte')}, expected {size}")
    if checksum and crc32(records) != checksum:
        raise LostChunkError("its checksum differs")
    return records, checksum != 0
