"""Reader of MCAP files by chunk: the messages of a chunk become one array.

Checksums of chunks are verified. A truncated file gives the chunks before its end. Positions and
times of chunks are in the file several times, so that a damaged one is detected.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final
from zlib import crc32

import numpy as np

from hybrid_dynamics_core.ground.wording import counted

from ..errors import BagError
from .mcap_descriptions import Descriptions
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
    MESSAGE_INDEX,
    RECORD_HEAD,
    SCHEMA,
    STATISTICS,
)
from .mcap_segment import LostChunkError, Segment, Span, unpack_chunk
from .mcap_summary import ChunkEntry, read_summary
from .message_records import MessageRuns, MessageTable, Places
from .pieces import Piece
from .storage import Losses, Messages, Topic

_MAX_LOOSE: Final = 4096  # messages outside chunks per segment
_INDEX_HEAD: Final = struct.Struct("<HI")  # of a message index: channel, size of its entries
_BROKEN_RECORD: Final = (struct.error, UnicodeDecodeError, IndexError)


class McapReader:
    """A reader of one .mcap file."""

    def __init__(self, path: Path, losses: Losses) -> None:
        """Open the file and find its chunks.

        Args:
            path: the file.
            losses: receives texts on parts that cannot be read.

        Raises:
            BagError: it is no MCAP file.
        """
        self._path = path
        self._losses = losses
        self._descriptions = Descriptions(self._lose)
        self._channels: dict[int, Topic] | None = None
        self._counts: dict[int, int] | None = None  # number of messages by channel, if in the file
        self._segments: list[Segment] = []
        self._loose: list[int] = []  # offsets of messages outside chunks in the current run
        self._file = path.open("rb")
        try:
            _require_magic_size(path)
            self._map = mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
            if self._map[: len(MAGIC)] != MAGIC:
                self._lose("does not begin as an MCAP file does")
            self._summary = read_summary(self._map)
            if self._summary.problem:
                self._lose(f"{self._summary.problem}; the file is read without it")
            self._scan()
        except BaseException:
            self._file.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._map.close()
        self._file.close()

    def topics(self) -> list[Topic]:
        """The topics of the file's index or, without an index, of its chunks."""
        channels = self._described()
        counts = self._counts
        if counts is None:
            return list(channels.values())
        return [
            replace(topic, message_count=counts.get(number, 0))
            for number, topic in channels.items()
        ]

    def pieces(self, wanted: frozenset[str] | None) -> list[Piece]:
        """The chunks of the file, and runs of messages outside them."""
        pieces = []
        for segment in self._segments:
            span = self._span(segment)
            if span is not None:
                pieces.append(self._piece(segment, span, wanted))
        return pieces

    def _piece(self, segment: Segment, span: Span, wanted: frozenset[str] | None) -> Piece:
        def read() -> Iterator[tuple[str, Messages]]:
            for topic, messages in self._messages(segment):
                if messages.log_ns[0] < span[0]:
                    self._lose(
                        f"the part from byte {segment.start} has messages before {span[0]} ns,"
                        " contrary to its index: the order of messages may be wrong"
                    )
                if wanted is None or topic in wanted:
                    yield topic, messages

        return Piece(span, read)

    def _span(self, segment: Segment) -> Span | None:
        """First and last log time of a segment [ns]; None if no message can be read.

        The messages are read unless two places in the file agree.
        """
        if segment.agreed_span is not None:
            return segment.agreed_span
        times = [messages.log_ns for _, messages in self._messages(segment)]
        if not times:
            return None
        first = min(part[0] for part in times)
        last = max(part[-1] for part in times)
        return int(first), int(last)

    def _lose(self, what: str) -> None:
        self._losses.add(f"{self._path.name}: {what}")

    # -- finding

    def _scan(self) -> None:
        """Find chunks, and all schemas and channels outside them."""
        start = len(MAGIC)
        is_summary = False
        while (record := self._record_at(start)) is not None:
            code, body, end = record
            if code != MESSAGE:
                self._end_loose(start)
            if code == FOOTER:
                if self._map[end : end + len(MAGIC)] != MAGIC:
                    self._lose("does not end as an MCAP file does")
                return
            if not (is_summary and self._summary.problem):
                self._register(code, start, body, end)
            is_summary = is_summary or code == DATA_END
            start = end
        self._end_loose(start)

    def _record_at(self, start: int) -> tuple[int, int, int] | None:
        """Code, body and end of the record at an offset, or of the next one if it is damaged.

        None if there is none, which is added to the losses.
        """
        problem = self._problem_at(start)
        if not problem:
            code, size = RECORD_HEAD.unpack_from(self._map, start)
            body = start + RECORD_HEAD.size
            return code, body, body + size
        entry = self._summary.chunks.get(start)
        if entry is not None:
            return CHUNK, start + RECORD_HEAD.size, entry.end
        indices_end = self._summary.indices_end(start)
        if indices_end is not None:  # their data are in the chunk too
            return MESSAGE_INDEX, indices_end, indices_end
        after = self._summary.chunk_after(start)
        if after is None and start < self._summary.start:
            after = self._summary.start
        if after is None:
            self._lose(problem)
            return None
        self._lose(f"no record begins at byte {start}: it is lost up to byte {after}")
        self._end_loose(start)
        return self._record_at(after)

    def _problem_at(self, start: int) -> str:
        """The reason why there is no record at an offset; empty if there is one."""
        file_end = len(self._map)
        if start + RECORD_HEAD.size > file_end:
            return f"ends at byte {file_end} without its index: it was cut off or never closed"
        code, size = RECORD_HEAD.unpack_from(self._map, start)
        if not 0 < code <= LAST_CODE:
            return f"no record begins at byte {start}: what follows is not read"
        end = start + RECORD_HEAD.size + size
        if end > file_end:
            beyond = end - file_end
            return f"the record at byte {start} ends {beyond} bytes beyond the file: it is lost"
        return self._contradiction(start, code, end)

    def _contradiction(self, start: int, code: int, end: int) -> str:
        """What the index has where a record of another kind or length begins."""
        entry = self._summary.chunks.get(start)
        if entry is not None and (code, end) != (CHUNK, entry.end):
            return "its index has another chunk there"
        if code != MESSAGE_INDEX and self._summary.indices_end(start) is not None:
            return "its index has the message indices of a chunk there"
        after = self._summary.chunk_after(start)
        if after is not None and end > after:
            return "its index has a chunk inside it"
        return ""

    def _register(self, code: int, start: int, body: int, end: int) -> None:
        """Register a record outside of chunks."""
        try:
            if code == CHUNK:
                self._register_chunk(body, end, self._summary.chunks.get(start))
            elif code == MESSAGE:
                self._register_loose(start, body, end)
            elif code == MESSAGE_INDEX:
                self._register_times(self._map[body:end])
            elif code == STATISTICS:
                self._register_counts(self._map[body:end])
            elif code == DATA_END:
                self._check_data(start, self._map[body:end])
            elif code in (SCHEMA, CHANNEL):
                is_verified = self._summary.is_verified and start >= self._summary.start
                self._descriptions.add(code, self._map[body:end], is_verified=is_verified)
        except _BROKEN_RECORD as error:
            self._lose(f"the record at byte {start} is broken ({error})")

    def _register_chunk(self, body: int, end: int, entry: ChunkEntry | None) -> None:
        first, last = struct.unpack_from("<QQ", self._map, body)
        spans = [(first, last)]
        if entry is not None:
            spans.append(entry.span)
        self._segments.append(Segment(body, end - body, is_chunk=True, spans=spans))

    def _register_times(self, record: bytes) -> None:
        """Register the log times of a message index for the chunk before it."""
        _, size = _INDEX_HEAD.unpack_from(record)
        if not self._segments or not size or size != len(record) - _INDEX_HEAD.size:
            return
        entries = np.frombuffer(record, dtype="<u8", offset=_INDEX_HEAD.size, count=size // 8)
        self._segments[-1].add_index(entries[::2])

    def _register_loose(self, start: int, body: int, end: int) -> None:
        if end - body < MESSAGE_HEAD.size:
            raise struct.error(f"a message of {end - body} bytes")
        self._loose.append(start)
        if len(self._loose) >= _MAX_LOOSE:
            self._end_loose(end)

    def _end_loose(self, end: int) -> None:
        """End the current run of messages outside chunks as a segment."""
        starts = self._loose
        if not starts:
            return
        places = [start + LOG_TIME_OFFSET for start in starts]
        times = [struct.unpack_from("<Q", self._map, place)[0] for place in places]
        start = starts[0]
        span = (min(times), max(times))
        self._segments.append(Segment(start, end - start, is_chunk=False, spans=[span, span]))
        self._loose = []

    def _register_counts(self, record: bytes) -> None:
        (size,) = struct.unpack_from("<I", record, 42)
        pairs = struct.iter_unpack("<HQ", record[46 : 46 + size])
        self._counts = dict(pairs)

    def _check_data(self, end: int, record: bytes) -> None:
        (checksum,) = struct.unpack("<I", record)
        if checksum and crc32(memoryview(self._map)[:end]) != checksum:
            self._lose("its checksum differs: something in it was changed")

    # -- reading

    def _records_of(self, segment: Segment) -> tuple[bytes, bool]:
        """The records of a segment, and whether a checksum verified them.

        They are empty if they are damaged, which is added to the losses.
        """
        raw = self._map[segment.start : segment.start + segment.size]
        if not segment.is_chunk:
            return raw, False
        try:
            return unpack_chunk(raw)
        except LostChunkError as error:
            self._lose(f"{segment.describe()} is lost: {error}")
            return b"", False

    def _messages(self, segment: Segment) -> Iterator[tuple[str, Messages]]:
        """The messages of a segment by topic."""
        channels = self._described()
        records, is_verified = self._records_of(segment)
        starts, sizes = self._find_messages(records, segment, is_verified=is_verified)
        if not len(starts):
            return
        table = MessageTable(records, starts, sizes)
        too_late = table.log_ns < 0  # beyond 2^63 ns, the year 2262
        if too_late.any():
            self._lose(f"{int(too_late.sum())} messages with log times beyond the year 2262")
            table.select(~too_late)
        for number in np.unique(table.channels).tolist():
            messages = table.messages_of(number)
            if number in channels:
                yield channels[number].name, messages
            else:
                self._lose(f"{len(messages)} messages of channel {number}, which is not described")

    def _described(self) -> dict[int, Topic]:
        """Topics by channel number; if the file describes none, those of its chunks."""
        if self._channels is None:
            if not self._descriptions.has_channels:
                for segment in self._segments:
                    records, is_verified = self._records_of(segment)
                    self._find_messages(records, segment, is_verified=is_verified)
            self._channels = self._descriptions.topics()
        return self._channels

    def _find_messages(
        self, records: bytes, segment: Segment, *, is_verified: bool
    ) -> tuple[Places, Places]:
        """Offsets of message records and sizes of their bodies; channels are registered."""
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
                    record = records[body : body + size]
                    self._descriptions.add(code, record, is_verified=is_verified)
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
