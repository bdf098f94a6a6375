"""Chunks of an MCAP file: blocks of messages of one layout, in one buffer, compressed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ...messages.cdr import Bytes, MessageTemplate
from .compression import zstd
from .mcap_format import LOG_TIME_OFFSET, MESSAGE, MESSAGE_HEAD, PREFIX, RECORD_HEAD
from .storage import Messages

_LEVEL: Final = -3  # Zstandard level: twice as fast as level 1, with 6 % more bytes
_TIME_SIZE: Final = 8  # [bytes]

Columns = Sequence[tuple[int, Bytes]]  # (offset, bytes of each message (N, k))


@dataclass(frozen=True, eq=False)
class RecordBlock:
    """Message records of one channel and one size, in the order of log times.

    The records are written together with their chunk.

    Attributes:
        channel: number of the channel.
        log_ns: log times (N,) [ns].
        pattern: bytes that all records share (size,).
        columns: bytes that differ: offset, and the bytes of each record (N, k).
    """

    channel: int
    log_ns: NDArray[np.int64]
    pattern: Bytes = field(repr=False)
    columns: Columns = field(repr=False)

    def __len__(self) -> int:
        return len(self.log_ns)

    @property
    def size(self) -> int:
        """Bytes of a record."""
        return len(self.pattern)

    @staticmethod
    def filled(
        channel: int,
        log_ns: NDArray[np.int64],
        template: MessageTemplate,
        values: Mapping[str, Any],
    ) -> RecordBlock:
        """Make a block of messages of one template.

        Args:
            channel: number of the channel.
            log_ns: log times (N,) [ns].
            template: the layout of the messages.
            values: numbers of each slot (N, ...); they must not change afterwards.
        """
        return RecordBlock._of(channel, log_ns, template.pattern, template.columns(values))

    @staticmethod
    def copies(channel: int, messages: Messages) -> Iterator[RecordBlock]:
        """Copies of messages, a block for each size."""
        for size in messages.sizes():
            rows = np.flatnonzero(messages.lengths == size)
            columns = [(0, messages.block(rows, size))]
            pattern = np.zeros(size, dtype=np.uint8)
            yield RecordBlock._of(channel, messages.log_ns[rows], pattern, columns)

    @staticmethod
    def _of(
        channel: int, log_ns: NDArray[np.int64], message: Bytes, columns: Columns
    ) -> RecordBlock:
        """Make records from a message's pattern and columns."""
        head = RECORD_HEAD.pack(MESSAGE, MESSAGE_HEAD.size + len(message))
        head += MESSAGE_HEAD.pack(channel, 0, 0, 0)
        pattern = np.concatenate([np.frombuffer(head, dtype=np.uint8), message])
        times = np.ascontiguousarray(log_ns, dtype="<u8").view(np.uint8)
        times = times.reshape(len(log_ns), _TIME_SIZE)
        record_columns = [(LOG_TIME_OFFSET, times), (LOG_TIME_OFFSET + _TIME_SIZE, times)]
        record_columns += [(PREFIX + start, column) for start, column in columns]
        return RecordBlock(channel, log_ns, pattern, record_columns)

    def write(self, records: Bytes) -> None:
        """Write the records into an array (N, size).

        Raises:
            ValueError: a column has a wrong number of rows, or exceeds the record.
        """
        records[:] = self.pattern
        for start, column in self.columns:
            target = records[:, start : start + column.shape[1]]
            if target.shape != column.shape:
                raise ValueError("expected a row for each record, and columns inside them")
            target[:] = column


@dataclass(frozen=True, eq=False)
class Chunk:
    """The content of a chunk's record and its indices.

    Attributes:
        compressed: its records, compressed.
        size: uncompressed size of its records [bytes].
        checksum: CRC-32 of its uncompressed records.
        first, last: log times [ns].
        indices: log times and offsets of messages (n, 2), by channel.
    """

    compressed: bytes
    size: int
    checksum: int
    first: int
    last: int
    indices: dict[int, NDArray[np.uint64]]


class ChunkPacker:
    """Packs chunks, one after the other."""

    def __init__(self) -> None:
        self._buffer = np.empty(0, dtype=np.uint8)
        self._compressor = zstd.ZstdCompressor(level=_LEVEL)

    def pack(self, blocks: Sequence[RecordBlock]) -> Chunk:
        """Pack a chunk of non-empty blocks."""
        size = sum(len(block) * block.size for block in blocks)
        if len(self._buffer) < size:
            self._buffer = np.empty(size, dtype=np.uint8)
        records = self._buffer[:size]
        start = 0
        for block in blocks:
            end = start + len(block) * block.size
            block.write(records[start:end].reshape(len(block), block.size))
            start = end
        compressed = self._compressor.compress(records.data, zstd.ZstdCompressor.FLUSH_FRAME)
        first = min(int(block.log_ns.min()) for block in blocks)
        last = max(int(block.log_ns.max()) for block in blocks)
        return Chunk(compressed, size, crc32(records.data), first, last, _indices(blocks))


def _indices(blocks: Sequence[RecordBlock]) -> dict[int, NDArray[np.uint64]]:
    """Log times and offsets of messages (n, 2), by channel."""
    parts: dict[int, list[NDArray[np.uint64]]] = {}
    start = 0
    for block in blocks:
        entries = np.empty((len(block), 2), dtype="<u8")
        entries[:, 0] = block.log_ns
        entries[:, 1] = start + block.size * np.arange(len(block))
        parts.setdefault(block.channel, []).append(entries)
        start += len(block) * block.size
    return {channel: _merge(entries) for channel, entries in parts.items()}


def _merge(parts: Sequence[NDArray[np.uint64]]) -> NDArray[np.uint64]:
    """Merge entries of several blocks in the order of log times."""
    if len(parts) == 1:
        return parts[0]
    entries = np.concatenate(parts)
    order = np.argsort(entries[:, 0], kind="stable")
    ordered: NDArray[np.uint64] = entries[order]
    return ordered
