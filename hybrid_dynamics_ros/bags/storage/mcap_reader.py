"""MCAP files, read chunk by chunk: a chunk's messages become one array.

Chunks carry checksums, which are compared. A file that ends early gives the chunks before its end.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Final
from zlib import crc32

import numpy as np

from hybrid_dynamics_core.ground.wording import counted

from ..errors import BagError
from .compression import ZSTD_ERRORS, decompress_chunk
from .mcap_format import (
    CHANNEL,
    CHUNK,
    DATA_END,
    FOOTER,
    LAST_CODE,
    LOG_TIME_OFFSET,
    MAGIC,
    MESSAGE,
    MESSAGE_HEAD,
    RECORD_HEAD,
    SCHEMA,
    STATISTICS,
    unpack_pairs,
    unpack_text,
)
from .message_records import MessageRuns, MessageTable, Places, split_by_time
from .qos import read_profiles
from .storage import Losses, Messages, Topic, decompress_each

_MAX_LOOSE: Final = 4096  # messages outside chunks that make a segment together
_BROKEN_RECORD: Final = (struct.error, UnicodeDecodeError, IndexError)
_BROKEN_CHUNK: Final = (
    *ZSTD_ERRORS,
    struct.error,
    IndexError,
    UnicodeDecodeError,
    RuntimeError,
    ValueError,
)


@dataclass(frozen=True)
class _Segment:
    """A chunk, or a run of messages outside chunks.

    Attributes:
        start: its first byte in the file, of a chunk that of the record's body.
        size: its bytes.
        first, last: log times [ns].
        is_chunk: whether it is a chunk.
    """

    start: int
    size: int
    first: int
    last: int
    is_chunk: bool


class McapReader:
    """One .mcap file, read only."""

    def __init__(self, path: Path, losses: Losses, *, message_compression: bool) -> None:
        """Open the file and find its chunks.

        Args:
            path: the file.
            losses: where to tell what cannot be read.
            message_compression: whether messages are compressed one by one.

        Raises:
            BagError: it is no MCAP file.
        """
        self._path = path
        self._losses = losses
        self._message_compression = message_compression
        self._schemas: dict[int, tuple[str, str]] = {}  # message type and definition
        self._channels: dict[int, Topic] = {}
        self._counts: dict[int, int] | None = None  # messages by channel, as the file says
        self._segments: list[_Segment] = []
        self._loose: list[int] = []  # where messages outside chunks begin, of the run that is read
        self._file = path.open("rb")
        try:
            _require_magic_size(path)
            self._map = mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
            if self._map[: len(MAGIC)] != MAGIC:
                self._lose("does not begin as an MCAP file does")
            self._scan()
        except BaseException:
            self._file.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._map.close()
        self._file.close()

    def topics(self) -> list[Topic]:
        """The topics of the file's index; without an index, those that its chunks describe."""
        if not self._channels:
            for segment in self._segments:
                if segment.is_chunk:
                    self._describe_channels(segment)
        counts = self._counts
        if counts is None:
            return list(self._channels.values())
        return [
            replace(topic, message_count=counts.get(number, 0))
            for number, topic in self._channels.items()
        ]

    def read(self, wanted: frozenset[str] | None) -> Iterator[tuple[str, Messages]]:
        """Messages chunk by chunk; where chunks overlap in time, messages wait for their turn."""
        segments = sorted(self._segments, key=lambda segment: segment.first)
        borders = [segment.first for segment in segments[1:]]
        waiting: dict[str, list[Messages]] = {}
        for segment, border in zip_longest(segments, borders):
            for topic, messages in self._messages(segment):
                if wanted is None or topic in wanted:
                    waiting.setdefault(topic, []).append(messages)
            for topic in list(waiting):
                ready, later = split_by_time(waiting.pop(topic), border)
                if later is not None:
                    waiting[topic] = [later]
                if len(ready):
                    yield topic, self._decompress(ready)

    def _decompress(self, messages: Messages) -> Messages:
        if not self._message_compression:
            return messages
        return decompress_each(messages, self._losses, self._path.name)

    def _lose(self, what: str) -> None:
        self._losses.add(f"{self._path.name}: {what}")

    # -- finding

    def _scan(self) -> None:
        """Find chunks, and all schemas and channels outside them."""
        start = len(MAGIC)
        while (record := self._record_at(start)) is not None:
            code, end = record
            if code != MESSAGE:
                self._end_loose(start)
            if code == FOOTER:
                if self._map[end : end + len(MAGIC)] != MAGIC:
                    self._lose("does not end as an MCAP file does")
                return
            self._register(code, start, end)
            start = end
        self._end_loose(start)

    def _record_at(self, start: int) -> tuple[int, int] | None:
        """Code and end of the record at a place; None where there is none, which is a loss."""
        file_end = len(self._map)
        if start + RECORD_HEAD.size > file_end:
            self._lose(f"ends at byte {file_end} without its index: it was cut off or never closed")
            return None
        code, size = RECORD_HEAD.unpack_from(self._map, start)
        if not 0 < code <= LAST_CODE:
            self._lose(f"no record begins at byte {start}: what follows is not read")
            return None
        end = start + RECORD_HEAD.size + size
        if end > file_end:
            self._lose(
                f"the record at byte {start} ends {end - file_end} bytes beyond the file: it is"
                " lost"
            )
            return None
        return code, end

    def _register(self, code: int, start: int, end: int) -> None:
        """Take what a record outside chunks says."""
        body = start + RECORD_HEAD.size
        try:
            if code == CHUNK:
                first, last = struct.unpack_from("<QQ", self._map, body)
                self._segments.append(_Segment(body, end - body, first, last, is_chunk=True))
            elif code == MESSAGE:
                self._loose.append(start)
                if len(self._loose) >= _MAX_LOOSE:
                    self._end_loose(end)
            elif code == STATISTICS:
                self._register_counts(self._map[body:end])
            elif code == DATA_END:
                self._check_data(start, self._map[body:end])
            elif code in (SCHEMA, CHANNEL):
                self._register_channel(code, self._map[body:end])
        except _BROKEN_RECORD as error:
            self._lose(f"the record at byte {start} is broken ({error})")

    def _end_loose(self, end: int) -> None:
        """Make a segment of the messages outside chunks that were found."""
        starts = self._loose
        if not starts:
            return
        places = [start + LOG_TIME_OFFSET for start in starts]
        times = [struct.unpack_from("<Q", self._map, place)[0] for place in places]
        start = starts[0]
        size = end - start
        segment = _Segment(start, size, min(times), max(times), is_chunk=False)
        self._segments.append(segment)
        self._loose = []

    def _register_counts(self, record: bytes) -> None:
        (size,) = struct.unpack_from("<I", record, 42)
        pairs = struct.iter_unpack("<HQ", record[46 : 46 + size])
        self._counts = dict(pairs)

    def _check_data(self, end: int, record: bytes) -> None:
        (checksum,) = struct.unpack("<I", record)
        if checksum and crc32(memoryview(self._map)[:end]) != checksum:
            self._lose("its checksum differs: something in it was changed")

    def _register_channel(self, code: int, record: bytes) -> None:
        """Take a schema or a channel."""
        if code == SCHEMA:
            (number,) = struct.unpack_from("<H", record)
            name, place = unpack_text(record, 2)
            encoding, place = unpack_text(record, place)
            text, _ = unpack_text(record, place)
            definition = text if encoding == "ros2msg" else ""
            self._schemas[number] = (name, definition)
            return
        number, schema = struct.unpack_from("<HH", record)
        name, place = unpack_text(record, 4)
        _, place = unpack_text(record, place)
        notes = unpack_pairs(record, place)
        kind, definition = self._schemas.get(schema, ("", ""))
        profiles = read_profiles(notes.get("offered_qos_profiles"))
        digest = notes.get("topic_type_hash", "")
        self._channels[number] = Topic(name, kind, profiles, definition, digest)

    # -- reading

    def _records_of(self, segment: _Segment) -> bytes | None:
        """The records of a segment; None where they cannot be trusted, which is a loss."""
        raw = self._map[segment.start : segment.start + segment.size]
        if not segment.is_chunk:
            return raw
        times = f"log times {segment.first} to {segment.last} ns"
        name = f"the chunk at byte {segment.start} ({times}) is lost"
        try:
            size, checksum = struct.unpack_from("<QI", raw, 16)
            method, place = unpack_text(raw, 28)
            (length,) = struct.unpack_from("<Q", raw, place)
            records = decompress_chunk(method, raw[place + 8 : place + 8 + length], size)
        except _BROKEN_CHUNK as error:
            self._lose(f"{name}: it cannot be unpacked ({error})")
            return None
        if len(records) != size:
            self._lose(f"{name}: it has {counted(len(records), 'byte')}, expected {size}")
            return None
        if checksum and crc32(records) != checksum:
            self._lose(f"{name}: its checksum differs")
            return None
        return records

    def _messages(self, segment: _Segment) -> Iterator[tuple[str, Messages]]:
        """The messages of a segment by topic."""
        records = self._records_of(segment)
        if records is None:
            return
        starts, sizes = self._find_messages(records, segment)
        if not len(starts):
            return
        table = MessageTable(records, starts, sizes)
        too_late = table.log_ns < 0  # beyond 2^63 ns: the year 2262
        if too_late.any():
            self._lose(f"{int(too_late.sum())} messages with log times beyond the year 2262")
            table.select(~too_late)
        for number in np.unique(table.channels).tolist():
            messages = table.messages_of(number)
            if number in self._channels:
                yield self._channels[number].name, messages
            else:
                self._lose(f"{len(messages)} messages of channel {number}, which is not described")

    def _describe_channels(self, segment: _Segment) -> None:
        """Take the schemas and channels inside a chunk."""
        records = self._records_of(segment)
        if records is not None:
            self._find_messages(records, segment)

    def _find_messages(self, records: bytes, segment: _Segment) -> tuple[Places, Places]:
        """Where message records begin, and the bytes of their bodies; channels are registered."""
        runs = MessageRuns()
        start = 0
        end = len(records)
        unpack = RECORD_HEAD.unpack_from
        try:
            while start < end:
                code, size = unpack(records, start)
                body = start + RECORD_HEAD.size
                if body + size > end or (code == MESSAGE and size < MESSAGE_HEAD.size):
                    raise struct.error(f"a record of {size} bytes at its byte {start}")
                if code == MESSAGE:
                    start = runs.add(records, start, size)
                    continue
                if code in (SCHEMA, CHANNEL):
                    self._register_channel(code, records[body : body + size])
                start = body + size
        except _BROKEN_RECORD as error:
            self._lose(
                f"what follows record {runs.total} of the chunk at byte {segment.start} is lost:"
                f" {error}"
            )
        return runs.places()


def _require_magic_size(path: Path) -> None:
    size = path.stat().st_size
    if size < len(MAGIC):
        raise BagError(f"{path.name}: {counted(size, 'byte')}: no MCAP file")
