"""MCAP files, chunk by chunk: a chunk's messages become one array, whatever of them can be trusted.

The specification: https://mcap.dev/spec. Chunks carry checksums, which are compared; a file that
ends early gives the chunks before its end.
"""

from __future__ import annotations

import mmap
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from zlib import crc32

import lz4.frame
import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.ground.wording import counted

from ..errors import BagError
from .bag_reader import Losses, Messages, Topic, qos_of, unpack_each

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAGIC: Final = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, INDEX, CHUNK_INDEX, STATISTICS, DATA_END = (
    *(1, 2, 3, 4, 5, 6, 7, 8, 0x0B, 0x0F),
)
_LAST: Final = 0x0F
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
PREFIX: Final = _RECORD.size + _MESSAGE.size  # bytes of a message record before its data
_LARGEST: Final = 1 << 32  # [bytes] of a chunk, unpacked: more is a broken length
_MANY: Final = 8  # records of one size after which more of them are looked for together
_LOOSE: Final = 4096  # messages outside chunks that are handed on together


@dataclass(frozen=True)
class _Piece:
    """A chunk, or a run of messages outside chunks: where it is, and its first and last log time [ns]."""

    start: int
    size: int
    first: int
    last: int
    chunk: bool


class McapFile:
    """One .mcap file, read only."""

    def __init__(self, path: Path, losses: Losses, packed: bool) -> None:
        """Open it and find its chunks.

        Raises:
            BagError: it is no MCAP file.
        """
        self._path, self._losses, self._packed = path, losses, packed
        self._file = path.open("rb")
        self._schemas: dict[int, tuple[str, str]] = {}
        self._channels: dict[int, Topic] = {}
        self._counts: dict[int, int] | None = None
        self._pieces: list[_Piece] = []
        try:
            _require_some(path)
            self._map = mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
            if self._map[: len(MAGIC)] != MAGIC:
                self._lose("does not begin as an MCAP file does")
            self._scan()
        except BaseException:
            self._file.close()
            raise

    def close(self) -> None:
        """Let go of the file."""
        self._map.close()
        self._file.close()

    def topics(self) -> list[Topic]:
        """What its index says it holds; without one, what its chunks hold."""
        if not self._channels:
            for piece in self._pieces:
                if piece.chunk and (records := self._unpacked(piece)) is not None:
                    self._records(records, piece, remember_only=True)
        counts = self._counts
        return [
            Topic(
                t.name,
                t.kind,
                t.qos,
                t.definition,
                t.digest,
                None if counts is None else counts.get(number, 0),
            )
            for number, t in self._channels.items()
        ]

    def read(self, wanted: frozenset[str] | None) -> Iterator[tuple[str, Messages]]:
        """Messages chunk by chunk; where chunks overlap in time, none is handed on before its turn."""
        pieces = sorted(self._pieces, key=lambda piece: piece.first)
        waiting: dict[str, list[Messages]] = {}
        for k, piece in enumerate(pieces):
            for topic, messages in self._messages(piece):
                if wanted is None or topic in wanted:
                    waiting.setdefault(topic, []).append(messages)
            border = pieces[k + 1].first if k + 1 < len(pieces) else None
            for topic in list(waiting):
                ready, later = _before(waiting.pop(topic), border)
                if later is not None:
                    waiting[topic] = [later]
                if len(ready):
                    yield (
                        topic,
                        (
                            unpack_each(ready, self._losses, self._path.name)
                            if self._packed
                            else ready
                        ),
                    )

    # -- finding

    def _lose(self, what: str) -> None:
        self._losses.add(f"{self._path.name}: {what}")

    def _scan(self) -> None:  # noqa: C901 - one branch for each way to end
        """Find chunks, and all schemas and channels outside them."""
        at, end = len(MAGIC), len(self._map)
        loose: list[int] = []  # where a run of messages outside chunks begins
        while True:
            if at + _RECORD.size > end:
                self._lose(f"ends at byte {end} without its index: it was cut off or never closed")
                break
            code, size = _RECORD.unpack_from(self._map, at)
            body = at + _RECORD.size
            if not 0 < code <= _LAST and code < 0x80:
                self._lose(f"no record begins at byte {at}: what follows is not read")
                break
            if body + size > end:
                self._lose(
                    f"the record at byte {at} ends {body + size - end} bytes beyond the file: it is"
                    " lost"
                )
                break
            if loose and code != MESSAGE:
                self._loose(loose, at)
            if code == FOOTER:
                if self._map[body + size : body + size + len(MAGIC)] != MAGIC:
                    self._lose("does not end as an MCAP file does")
                break
            self._found(code, at, body, size, loose)
            at = body + size
        if loose:
            self._loose(loose, at)

    def _found(self, code: int, at: int, body: int, size: int, loose: list[int]) -> None:
        record = (
            self._map[body : body + size]
            if code in (SCHEMA, CHANNEL, STATISTICS, DATA_END)
            else b""
        )
        try:
            if code == CHUNK:
                first, last = struct.unpack_from("<QQ", self._map, body)
                self._pieces.append(_Piece(body, size, first, last, chunk=True))
            elif code == MESSAGE:
                loose.append(at)
                if len(loose) >= _LOOSE:
                    self._loose(loose, body + size)
            elif code == STATISTICS:
                (length,) = struct.unpack_from("<I", record, 42)
                pairs = struct.iter_unpack("<HQ", record[46 : 46 + length])
                self._counts = dict(pairs)
            elif code == DATA_END:
                (told,) = struct.unpack("<I", record)
                if told and crc32(memoryview(self._map)[:at]) != told:
                    self._lose("its checksum differs: something in it was changed")
            else:
                self._remember(code, record)
        except (struct.error, UnicodeDecodeError, IndexError) as error:
            self._lose(f"the record at byte {at} is broken ({error})")

    def _loose(self, starts: list[int], end: int) -> None:
        times = [
            struct.unpack_from("<Q", self._map, start + _RECORD.size + 6)[0] for start in starts
        ]
        self._pieces.append(_Piece(starts[0], end - starts[0], min(times), max(times), chunk=False))
        starts.clear()

    def _remember(self, code: int, record: bytes) -> None:
        if code == SCHEMA:
            (number,) = struct.unpack_from("<H", record)
            name, at = _text(record, 2)
            encoding, at = _text(record, at)
            text, _ = _text(record, at)
            self._schemas[number] = (name, text if encoding == "ros2msg" else "")
        elif code == CHANNEL:
            number, schema = struct.unpack_from("<HH", record)
            topic, at = _text(record, 4)
            _, at = _text(record, at)
            told = _pairs(record, at)
            kind, text = self._schemas.get(schema, ("", ""))
            qos = qos_of(told.get("offered_qos_profiles"))
            self._channels[number] = Topic(topic, kind, qos, text, told.get("topic_type_hash", ""))

    # -- reading

    def _unpacked(self, piece: _Piece) -> bytes | None:
        """The records of a piece; None where they cannot be trusted, which is told."""
        raw = self._map[piece.start : piece.start + piece.size]
        if not piece.chunk:
            return raw
        where = (
            f"the chunk at byte {piece.start} (log times {piece.first} to {piece.last} ns) is lost"
        )
        try:
            size, checksum = struct.unpack_from("<QI", raw, 16)
            method, at = _text(raw, 28)
            (length,) = struct.unpack_from("<Q", raw, at)
            records = _unpack(method, raw[at + 8 : at + 8 + length], size)
        except (
            struct.error,
            UnicodeDecodeError,
            zstd.ZstdError,
            EOFError,
            RuntimeError,
            ValueError,
        ) as error:
            self._lose(f"{where}: it cannot be unpacked ({error})")
            return None
        if len(records) != size:
            self._lose(f"{where}: it has {counted(len(records), 'byte')}, expected {size}")
            return None
        if checksum and crc32(records) != checksum:
            self._lose(f"{where}: its checksum differs")
            return None
        return records

    def _messages(self, piece: _Piece) -> Iterator[tuple[str, Messages]]:
        records = self._unpacked(piece)
        if records is None:
            return
        starts, lengths = self._records(records, piece)
        data = np.frombuffer(records, dtype=np.uint8)
        if not len(starts):
            return
        numbers = _gathered(data, starts + _RECORD.size, "<u2")
        times = _gathered(data, starts + _RECORD.size + 6, "<u8").astype(np.int64)
        late = times < 0  # beyond 2^63 ns: the year 2262
        if late.any():
            self._lose(f"{int(late.sum())} messages with log times beyond the year 2262")
            numbers, times, starts, lengths = (
                numbers[~late],
                times[~late],
                starts[~late],
                lengths[~late],
            )
        for number in np.unique(numbers).tolist():
            if number not in self._channels:
                self._lose(
                    f"{int((numbers == number).sum())} messages of channel {number}, which is not"
                    " described"
                )
                continue
            own = np.flatnonzero(numbers == number)
            own = own[np.argsort(times[own], kind="stable")]
            yield (
                self._channels[number].name,
                Messages(times[own], data, starts[own] + PREFIX, lengths[own] - _MESSAGE.size),
            )

    def _records(
        self, records: bytes, piece: _Piece, *, remember_only: bool = False
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Where message records begin, and their lengths; others are remembered."""
        found, at, end = _Runs(), 0, len(records)
        unpack = _RECORD.unpack_from
        try:
            while at < end:
                code, size = unpack(records, at)
                if at + _RECORD.size + size > end or (code == MESSAGE and size < _MESSAGE.size):
                    raise struct.error(f"a record of {size} bytes at its byte {at}")  # noqa: TRY301
                if code == MESSAGE:
                    at = found.add(records, at, size)
                    continue
                if code in (SCHEMA, CHANNEL):
                    self._remember(code, records[at + _RECORD.size : at + _RECORD.size + size])
                at += _RECORD.size + size
        except (struct.error, UnicodeDecodeError, IndexError) as error:
            self._lose(
                f"what follows record {found.total} of the chunk at byte {piece.start} is lost:"
                f" {error}"
            )
        if remember_only:
            return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
        return found.places()


class _Runs:
    """Message records, those of one size that follow each other together."""

    def __init__(self) -> None:
        self._starts: list[int] = []
        self._sizes: list[int] = []
        self._counts: list[int] = []
        self._alike = 0  # records of one size, one after the other
        self.total = 0

    def add(self, records: bytes, at: int, size: int) -> int:
        """One record whose body has a size, and where many were like it all that follow; where the next begins."""
        self._alike = self._alike + 1 if self._sizes and self._sizes[-1] == size else 0
        count = 1 if self._alike < _MANY else _alike(records, at, _RECORD.size + size)
        self._starts.append(at)
        self._sizes.append(size)
        self._counts.append(count)
        self.total += count
        return at + count * (_RECORD.size + size)

    def places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Where each begins (N,), and the size of its body (N,)."""
        starts, sizes, counts = (
            np.array(part, dtype=np.int64) for part in (self._starts, self._sizes, self._counts)
        )
        inside = np.arange(self.total) - np.repeat(np.cumsum(counts) - counts, counts)
        sizes = np.repeat(sizes, counts)
        return np.repeat(starts, counts) + inside * (_RECORD.size + sizes), sizes


def _alike(records: bytes, at: int, step: int) -> int:
    """How many records from `at` on begin with the same code and size, so that each ends where the next begins."""
    every = np.ndarray(
        ((len(records) - at) // step, _RECORD.size),
        dtype=np.uint8,
        buffer=records,
        offset=at,
        strides=(step, 1),
    )
    found, ask = 1, _MANY
    while found < len(every):  # in growing steps: a run may be short
        same = (every[found : found + ask] == every[0]).all(axis=1)
        if not same.all():
            return found + int(np.argmin(same))
        found, ask = found + len(same), 4 * ask
    return found


def _require_some(path: Path) -> None:
    size = path.stat().st_size
    if size < len(MAGIC):
        raise BagError(f"{path.name}: {counted(size, 'byte')}: no MCAP file")


def _gathered(data: NDArray[np.uint8], starts: NDArray[np.int64], kind: str) -> NDArray[np.int64]:
    """The integers that begin at some places of the data."""
    every = np.ndarray(len(data) - np.dtype(kind).itemsize + 1, dtype=kind, buffer=data, strides=1)
    found: NDArray[np.int64] = every[starts].astype(np.int64)
    return found


def _before(parts: list[Messages], border: int | None) -> tuple[Messages, Messages | None]:
    """Messages in the order of log times, those before a time and the others."""
    parts = [part for part in parts if len(part)]
    if not parts:
        return Messages.of([], []), None
    whole = parts[0] if len(parts) == 1 else _joined(parts)
    order = np.argsort(whole.log_ns, kind="stable")
    if not (order[:-1] < order[1:]).all():
        whole = whole.part(order)
    if border is None or whole.log_ns[-1] < border:
        return whole, None
    split = int(np.searchsorted(whole.log_ns, border))
    rows = np.arange(len(whole))
    return whole.part(rows[:split]), whole.part(rows[split:])


def _joined(parts: list[Messages]) -> Messages:
    shifts = np.cumsum([0, *(len(part.data) for part in parts[:-1])])
    return Messages(
        np.concatenate([part.log_ns for part in parts]),
        np.concatenate([part.data for part in parts]),
        np.concatenate([part.offsets + shift for part, shift in zip(parts, shifts, strict=True)]),
        np.concatenate([part.lengths for part in parts]),
    )


def _unpack(method: str, data: bytes, size: int) -> bytes:
    if size > _LARGEST:
        raise ValueError(f"{size} bytes")
    if method == "zstd":
        return bytes(zstd.decompress(data))
    if method == "lz4":
        return bytes(lz4.frame.decompress(data))
    if method:
        raise ValueError(f"compression '{method[:16]}' is not known")
    return data


def _text(record: bytes, at: int) -> tuple[str, int]:
    (size,) = struct.unpack_from("<I", record, at)
    text = record[at + 4 : at + 4 + size]
    if len(text) != size:
        raise IndexError("a text without its end")
    return text.decode(), at + 4 + size


def _pairs(record: bytes, at: int) -> dict[str, str]:
    (size,) = struct.unpack_from("<I", record, at)
    end, at, pairs = at + 4 + size, at + 4, {}
    while at < end:
        key, at = _text(record, at)
        pairs[key], at = _text(record, at)
    return pairs
