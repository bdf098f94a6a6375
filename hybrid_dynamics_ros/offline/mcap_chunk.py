"""Chunks of an MCAP file: blocks of equal messages, written with their record heads into one buffer, and packed."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_ros.cdr import Bytes, Template
from hybrid_dynamics_ros.offline.mcap_file import MESSAGE, PREFIX
from hybrid_dynamics_ros.offline.source import Messages

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

_LEVEL: Final = 1  # of zstd: higher levels take several times as long for a tenth of the size
_HEAD = np.dtype(
    [("code", "u1"), ("size", "<u8"), ("channel", "<u2"), ("number", "<u4"), ("log", "<u8"), ("sent", "<u8")]
)


@dataclass(frozen=True, eq=False)
class Block:
    """Messages of one channel and one size, in the order of log times.

    Attributes:
        channel: its number.
        log_ns: (N,) [ns].
        size: bytes of a message.
        put: writes all messages into an array (N, size); called when the chunk is made.
    """

    channel: int
    log_ns: NDArray[np.int64]
    size: int
    put: Callable[[Bytes], None] = field(repr=False)

    def __len__(self) -> int:
        return len(self.log_ns)

    @property
    def step(self) -> int:
        """Bytes of a message record."""
        return PREFIX + self.size

    @staticmethod
    def filled(channel: int, log_ns: NDArray[np.int64], template: Template, values: Mapping[str, Any]) -> Block:
        """Messages of one template, whose values must not change any more."""
        return Block(channel, log_ns, template.size, partial(template.fill, values=values))

    @staticmethod
    def copies(channel: int, messages: Messages) -> Iterator[Block]:
        """Messages as they are, by size."""
        for size in np.unique(messages.lengths).tolist():
            rows = np.flatnonzero(messages.lengths == size)
            yield Block(channel, messages.log_ns[rows], size, partial(_copy, messages.block(rows, size)))

    def write(self, records: Bytes) -> None:
        """Fill all message records (N, step)."""
        head = np.zeros(len(self), dtype=_HEAD)
        head["code"], head["size"], head["channel"] = MESSAGE, self.step - 9, self.channel
        head["log"] = head["sent"] = self.log_ns
        records[:, :PREFIX] = head.view(np.uint8).reshape(len(self), PREFIX)
        self.put(records[:, PREFIX:])


def _copy(messages: Bytes, to: Bytes) -> None:
    to[:] = messages


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
        size = sum(len(block) * block.step for block in blocks)
        if len(self._buffer) < size:
            self._buffer = np.empty(size, dtype=np.uint8)
        raw, at = self._buffer[:size], 0
        for block in blocks:
            end = at + len(block) * block.step
            block.write(raw[at:end].reshape(len(block), block.step))
            at = end
        packed = self._compressor.compress(raw, zstd.ZstdCompressor.FLUSH_FRAME)
        first = min(int(block.log_ns.min()) for block in blocks)
        last = max(int(block.log_ns.max()) for block in blocks)
        return Chunk(packed, size, crc32(raw), first, last, _indices(blocks))


def _indices(blocks: Sequence[Block]) -> dict[int, NDArray[np.uint64]]:
    found: dict[int, list[NDArray[np.uint64]]] = {}
    at = 0
    for block in blocks:
        entries = np.empty((len(block), 2), dtype="<u8")
        entries[:, 0], entries[:, 1] = block.log_ns, at + block.step * np.arange(len(block))
        found.setdefault(block.channel, []).append(entries)
        at += len(block) * block.step
    return {channel: parts[0] if len(parts) == 1 else _in_order(parts) for channel, parts in found.items()}


def _in_order(parts: Sequence[NDArray[np.uint64]]) -> NDArray[np.uint64]:
    whole = np.concatenate(parts)
    ordered: NDArray[np.uint64] = whole[np.argsort(whole[:, 0], kind="stable")]
    return ordered
