"""Writer of MCAP files; a separate thread compresses and writes the chunks."""

from __future__ import annotations

import struct
import time
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Final
from zlib import crc32

from .mcap_chunk import Chunk, ChunkPacker, RecordBlock
from .mcap_format import (
    CHANNEL,
    CHUNK,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    HEADER,
    MAGIC,
    MESSAGE_INDEX,
    RECORD_HEAD,
    SCHEMA,
    STATISTICS,
    pack_record,
    pack_text,
)
from .mcap_summary import FOOTER_BODY
from .qos import profile_text
from .storage import ROS2_MSG, Topic

_MAX_QUEUED: Final = 4  # largest number of pending chunks
_NO_TIME: Final = 2**63 - 1  # [ns] beyond every log time


class McapWriter:
    """An open MCAP file.

    Attributes:
        channels: number of the channel of each topic.
        counts: number of messages by channel.
        thread_time: time of the thread [s].
    """

    def __init__(self, path: Path, topics: Sequence[Topic]) -> None:
        """Begin a file.

        Args:
            path: the file, which must not exist.
            topics: all topics, with the descriptions of their types.
        """
        self.channels = {topic.name: k + 1 for k, topic in enumerate(topics)}
        self.counts = dict.fromkeys(self.channels.values(), 0)
        self.thread_time = 0.0
        self._schema_count = len({topic.kind for topic in topics})
        self._chunk_indices: list[bytes] = []
        self._first = _NO_TIME
        self._last = 0
        self._packer = ChunkPacker()
        self._thread = ThreadPoolExecutor(1)
        self._queue: deque[Future[None]] = deque()
        self._file = path.open("wb")
        header = pack_text("ros2") + pack_text("hybrid_dynamics")
        self._file.write(MAGIC + pack_record(HEADER, header))
        self._descriptions = b"".join(_describe(topics, self.channels))
        self._file.write(self._descriptions)

    @property
    def log_span(self) -> tuple[int, int]:
        """First and last log time of all messages [ns]; zeros without messages."""
        if not any(self.counts.values()):
            return 0, 0
        return self._first, self._last

    def write(self, blocks: Sequence[RecordBlock]) -> None:
        """Write one chunk of messages; raises errors of this or an earlier chunk."""
        blocks = [block for block in blocks if len(block)]
        if not blocks:
            return
        self._queue.append(self._thread.submit(self._write_chunk, blocks))
        while len(self._queue) > _MAX_QUEUED:
            self._queue.popleft().result()

    def close(self) -> None:
        """Write pending chunks and the index."""
        while self._queue:
            self._queue.popleft().result()
        self._thread.shutdown()
        self._file.write(pack_record(DATA_END, struct.pack("<I", 0)))
        start = self._file.tell()
        summary = self._descriptions + b"".join(self._chunk_indices) + self._statistics()
        head = RECORD_HEAD.pack(FOOTER, FOOTER_BODY.size) + struct.pack("<QQ", start, 0)
        checksum = crc32(summary + head)
        footer = FOOTER_BODY.pack(start, 0, checksum)
        self._file.write(summary + pack_record(FOOTER, footer) + MAGIC)
        self._file.close()

    def abort(self) -> None:
        """Discard the file."""
        self._thread.shutdown(cancel_futures=True)
        self._file.close()

    def _write_chunk(self, blocks: Sequence[RecordBlock]) -> None:
        """Pack and write a chunk with its indices, in the thread."""
        begin = time.perf_counter()
        chunk = self._packer.pack(blocks)
        self._first = min(self._first, chunk.first)
        self._last = max(self._last, chunk.last)
        start = self._file.tell()
        head = _chunk_head(chunk)
        size = len(head) + len(chunk.compressed)
        self._file.write(RECORD_HEAD.pack(CHUNK, size) + head)
        self._file.write(chunk.compressed)
        end = self._file.tell()
        index_places = self._write_message_indices(chunk)
        index_size = self._file.tell() - end
        index = struct.pack(
            "<QQQQI", chunk.first, chunk.last, start, end - start, len(index_places)
        )
        index += index_places + struct.pack("<Q", index_size) + pack_text("zstd")
        index += struct.pack("<QQ", len(chunk.compressed), chunk.size)
        self._chunk_indices.append(pack_record(CHUNK_INDEX, index))
        self.thread_time += time.perf_counter() - begin

    def _write_message_indices(self, chunk: Chunk) -> bytes:
        """Write an index for each channel; returns their offsets, packed."""
        places = b""
        for channel, entries in chunk.indices.items():
            self.counts[channel] += len(entries)
            places += struct.pack("<HQ", channel, self._file.tell())
            content = entries.tobytes()
            index = struct.pack("<HI", channel, len(content)) + content
            self._file.write(pack_record(MESSAGE_INDEX, index))
        return places

    def _statistics(self) -> bytes:
        first, last = self.log_span
        channel_counts = b""
        for channel, count in self.counts.items():
            channel_counts += struct.pack("<HQ", channel, count)
        numbers = struct.pack(
            "<QHIIIIQQI",
            sum(self.counts.values()),
            self._schema_count,
            len(self.channels),
            0,  # attachments
            0,  # metadata records
            len(self._chunk_indices),
            first,
            last,
            len(channel_counts),
        )
        return pack_record(STATISTICS, numbers + channel_counts)


def _chunk_head(chunk: Chunk) -> bytes:
    """The header of a chunk's record, before its compressed records."""
    head = struct.pack("<QQQI", chunk.first, chunk.last, chunk.size, chunk.checksum)
    return head + pack_text("zstd") + struct.pack("<Q", len(chunk.compressed))


def _describe(topics: Sequence[Topic], channels: dict[str, int]) -> Iterator[bytes]:
    """Records of the schemas and channels of all topics."""
    schemas: dict[str, int] = {}
    for topic in topics:
        if topic.kind not in schemas:
            schemas[topic.kind] = len(schemas) + 1
            schema = struct.pack("<H", schemas[topic.kind]) + pack_text(topic.kind)
            schema += pack_text(topic.language or ROS2_MSG) + pack_text(topic.definition)
            yield pack_record(SCHEMA, schema)
        notes = pack_text("offered_qos_profiles") + pack_text(profile_text(topic.qos))
        notes += pack_text("topic_type_hash") + pack_text(topic.digest)
        channel = struct.pack("<HH", channels[topic.name], schemas[topic.kind])
        channel += pack_text(topic.name) + pack_text(topic.encoding)
        channel += struct.pack("<I", len(notes)) + notes
        yield pack_record(CHANNEL, channel)
