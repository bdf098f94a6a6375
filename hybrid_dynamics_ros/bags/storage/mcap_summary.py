"""The summary of an MCAP file: a second copy of positions and log times of chunks."""

from __future__ import annotations

import mmap
import struct
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final
from zlib import crc32

from .mcap_format import CHUNK, CHUNK_INDEX, FOOTER, MAGIC, RECORD_HEAD

FOOTER_BODY: Final = struct.Struct("<QQI")  # start of summary, start of its offsets, checksum
FOOTER_SIZE: Final = RECORD_HEAD.size + FOOTER_BODY.size
_CHECKSUM_SIZE: Final = 4  # [bytes] at the end of the footer, not covered by the checksum
# The header of a chunk index: first and last log time, start and length of the chunk, size of a map
# of its message indices. After the map comes the size of these indices.
_CHUNK_HEAD: Final = struct.Struct("<QQQQI")
_SIZE: Final = struct.Struct("<Q")
_FOOTER_DAMAGED: Final = "the footer that leads to its index is damaged"


@dataclass(frozen=True)
class ChunkEntry:
    """The entry of a chunk in the summary.

    Attributes:
        start: offset of its record.
        end: offset after its record.
        index_end: offset after its message indices.
        span: first and last log time [ns].
    """

    start: int
    end: int
    index_end: int
    span: tuple[int, int]


@dataclass(frozen=True)
class Summary:
    """The summary at the end of a file.

    Attributes:
        start: its offset; 0 if there is none.
        chunks: chunks by offset.
        is_verified: whether a checksum verified it.
        problem: why it cannot be used; empty if it can, or if there is none.
    """

    start: int = 0
    chunks: Mapping[int, ChunkEntry] = field(default_factory=dict)
    is_verified: bool = False
    problem: str = ""

    @cached_property
    def _starts(self) -> list[int]:
        return sorted(self.chunks)

    def chunk_after(self, place: int) -> int | None:
        """Offset of the next chunk after an offset; None if there is none."""
        number = bisect_right(self._starts, place)
        if number == len(self._starts):
            return None
        return self._starts[number]

    def indices_end(self, place: int) -> int | None:
        """The end of the message indices that contain an offset; None if it is in none."""
        chunks_before = bisect_right(self._starts, place)
        if chunks_before == 0:
            return None
        entry = self.chunks[self._starts[chunks_before - 1]]
        if entry.end <= place < entry.index_end:
            return entry.index_end
        return None


class _DamagedError(Exception):
    """The summary is damaged; the text says how."""


def read_summary(data: mmap.mmap) -> Summary:
    """The summary of a file; empty if the file is truncated or has none."""
    footer = len(data) - len(MAGIC) - FOOTER_SIZE
    if footer < len(MAGIC) or data[-len(MAGIC) :] != MAGIC:
        return Summary()
    try:
        start, is_verified = _checked_start(data, footer)
        if not start:
            return Summary()
        entries = list(_entries(data, start, footer))
    except _DamagedError as error:
        return Summary(problem=str(error))
    except struct.error:
        return Summary(problem="its index is damaged")
    chunks = {entry.start: entry for entry in entries if is_verified or _is_chunk(data, entry)}
    return Summary(start, chunks, is_verified)


def _checked_start(data: mmap.mmap, footer: int) -> tuple[int, bool]:
    """Offset of the summary, or 0, and whether a checksum verified it.

    Raises:
        _DamagedError: the footer or the checksum is wrong.
    """
    if RECORD_HEAD.unpack_from(data, footer) != (FOOTER, FOOTER_BODY.size):
        raise _DamagedError(_FOOTER_DAMAGED)
    start, _, checksum = FOOTER_BODY.unpack_from(data, footer + RECORD_HEAD.size)
    if start and not len(MAGIC) <= start <= footer:
        raise _DamagedError(_FOOTER_DAMAGED)
    end = footer + FOOTER_SIZE - _CHECKSUM_SIZE
    if start and checksum and crc32(data[start:end]) != checksum:
        raise _DamagedError("the checksum of its index differs")
    return start, checksum != 0


def _entries(data: mmap.mmap, start: int, footer: int) -> Iterator[ChunkEntry]:
    """The chunks in a summary; raises struct.error if it is damaged."""
    record = start
    while record < footer:
        code, size = RECORD_HEAD.unpack_from(data, record)
        body = record + RECORD_HEAD.size
        record = body + size
        if record > footer:
            raise struct.error("a record without its end")
        if code != CHUNK_INDEX:
            continue
        first, last, chunk, length, map_size = _CHUNK_HEAD.unpack_from(data, body)
        (index_size,) = _SIZE.unpack_from(data, body + _CHUNK_HEAD.size + map_size)
        end = chunk + length
        index_end = end + index_size
        # entries beyond the end of the file belong to truncated chunks
        if index_end <= len(data):
            yield ChunkEntry(chunk, end, index_end, (first, last))


def _is_chunk(data: mmap.mmap, entry: ChunkEntry) -> bool:
    """Whether an entry of a summary without checksum points to a chunk."""
    size = entry.end - entry.start - RECORD_HEAD.size
    return RECORD_HEAD.unpack_from(data, entry.start) == (CHUNK, size)
