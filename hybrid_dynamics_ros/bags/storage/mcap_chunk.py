"""Chunks of an MCAP file: blocks of equal messages, written with their record heads into one buffer, and packed."""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ...messages.cdr import Bytes, Template
from . import compiled_rows
from .bag_reader import Messages
from .mcap_reader import MESSAGE, PREFIX

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

_LEVEL: Final = -3  # of zstd: packs twice as fast as level 1, into 6 % more bytes
_HEAD: Final = struct.Struct(
    "<BQHIQQ"
)  # of a message record: code, size, channel, number, log time, time sent
_BEFORE: Final = 9  # bytes of it that its size does not count
_LOG: Final = 15  # where its times are


@dataclass(frozen=True, eq=False)
class Block:
    """Message records of one channel and one size, in the order of log times; they are written when their chunk is.

    Attributes:
        channel: its number.
        log_ns: (N,) [ns].
        pattern: what all records share (size,).
        columns: where records differ: first byte, and the bytes of each record (N, k).
    """

    channel: int
    log_ns: NDArray[np.int64]
    pattern: Bytes = field(repr=False)
    columns: list[tuple[int, Bytes]] = field(repr=False)

    def __len__(self) -> int:
        return len(self.log_ns)

    @property
    def size(self) -> int:
        """Bytes of a record."""
        return len(self.pattern)

    @staticmethod
    def filled(
        channel: int, log_ns: NDArray[np.int64], template: Template, values: Mapping[str, Any]
    ) -> Block:
        """Messages of one template, whose values must not change any more."""
        return Block._of(channel, log_ns, template.pattern, template.columns(values))

    @staticmethod
    def copies(channel: int, messages: Messages) -> Iterator[Block]:
        """Messages as they are, by size."""
        for size in messages.sizes():
            rows = np.flatnonzero(messages.lengths == size)
            columns = [(0, messages.block(rows, size))]
            yield Block._of(channel, messages.log_ns[rows], np.zeros(size, dtype=np.uint8), columns)

    @staticmethod
    def _of(
        channel: int,
        log_ns: NDArray[np.int64],
        message: Bytes,
        columns: Sequence[tuple[int, Bytes]],
    ) -> Block:
        head = np.frombuffer(
            _HEAD.pack(MESSAGE, PREFIX - _BEFORE + len(message), channel, 0, 0, 0), dtype=np.uint8
        )
        times = np.ascontiguousarray(log_ns, dtype="<u8").view(np.uint8).reshape(len(log_ns), 8)
        own = [(PREFIX + start, column) for start, column in columns]
        stamps = [(_LOG, times), (_LOG + 8, times)]
        return Block(channel, log_ns, np.concatenate([head, message]), [*stamps, *own])


@dataclass(frozen=True, eq=False)
class Chunk:
    """What a chunk's record and its indices say.

    Attributes:
        packed: its records, compressed; size: bytes before; checksum: CRC-32 of those.
        first, last: log times [ns].
        indices: for each channel log times and places of its messages, (n, 2).
    """

    packed: bytes
    size: int
    checksum: int
    first: int
    last: int
    indices: dict[int, NDArray[np.uint64]]


class Packer:
    """Makes one chunk after the other."""

    def __init__(self) -> None:
        self._buffer = np.empty(0, dtype=np.uint8)
        self._compressor = zstd.ZstdCompressor(level=_LEVEL)

    def chunk(self, blocks: Sequence[Block]) -> Chunk:
        """The chunk of blocks that are not empty."""
        size = sum(len(block) * block.size for block in blocks)
        if len(self._buffer) < size:
            self._buffer = np.empty(size, dtype=np.uint8)
        raw = self._buffer[:size]
        _write(raw, blocks)
        packed = self._compressor.compress(raw.data, zstd.ZstdCompressor.FLUSH_FRAME)
        first = min(int(block.log_ns.min()) for block in blocks)
        last = max(int(block.log_ns.max()) for block in blocks)
        return Chunk(packed, size, crc32(raw.data), first, last, _indices(blocks))


def _write(raw: Bytes, blocks: Sequence[Block]) -> None:
    """All records of the blocks, one after the other."""
    ends = np.cumsum([len(block) * block.size for block in blocks]).tolist()
    places = [
        raw[end - len(b) * b.size : end].reshape(len(b), b.size)
        for b, end in zip(blocks, ends, strict=True)
    ]
    compiled = compiled_rows.writer()
    if compiled is not None:
        compiled(
            [(records, b.pattern, b.columns) for records, b in zip(places, blocks, strict=True)]
        )
        return
    for records, block in zip(places, blocks, strict=True):
        records[:] = block.pattern
        for start, column in block.columns:
            records[:, start : start + column.shape[1]] = column


def _indices(blocks: Sequence[Block]) -> dict[int, NDArray[np.uint64]]:
    found: dict[int, list[NDArray[np.uint64]]] = {}
    at = 0
    for block in blocks:
        entries = np.empty((len(block), 2), dtype="<u8")
        entries[:, 0], entries[:, 1] = block.log_ns, at + block.size * np.arange(len(block))
        found.setdefault(block.channel, []).append(entries)
        at += len(block) * block.size
    return {
        channel: parts[0] if len(parts) == 1 else _in_order(parts)
        for channel, parts in found.items()
    }


def _in_order(parts: Sequence[NDArray[np.uint64]]) -> NDArray[np.uint64]:
    whole = np.concatenate(parts)
    ordered: NDArray[np.uint64] = whole[np.argsort(whole[:, 0], kind="stable")]
    return ordered
