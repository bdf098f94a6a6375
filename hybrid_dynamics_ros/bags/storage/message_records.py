"""Positions of the messages in a chunk, found in runs of records of one size."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from .mcap_format import CHANNEL_OFFSET, LOG_TIME_OFFSET, MESSAGE_HEAD, PREFIX, RECORD_HEAD
from .storage import Messages

_MIN_RUN: Final = 8  # records of one size after which the rest of the run is found at once

Places = NDArray[np.int64]


class MessageRuns:
    """Runs of message records.

    Attributes:
        total: number of records of all runs.
    """

    def __init__(self) -> None:
        self._starts: list[int] = []
        self._sizes: list[int] = []
        self._counts: list[int] = []
        self._equal_sizes = 0  # consecutive records of the last size
        self.total = 0

    def add(self, records: bytes, start: int, size: int) -> int:
        """Add a record or, after several of its size, a whole run; returns the next offset.

        Args:
            records: all records of a chunk.
            start: offset of the record.
            size: size of its body [bytes].
        """
        if self._sizes and self._sizes[-1] == size:
            self._equal_sizes += 1
        else:
            self._equal_sizes = 0
        step = RECORD_HEAD.size + size
        count = 1
        if self._equal_sizes >= _MIN_RUN:
            count = _run_length(records, start, step)
        self._starts.append(start)
        self._sizes.append(size)
        self._counts.append(count)
        self.total += count
        return start + count * step

    def places(self) -> tuple[Places, Places]:
        """Offset (N,) and body size (N,) of each record."""
        counts = np.array(self._counts, dtype=np.int64)
        starts = np.repeat(np.array(self._starts, dtype=np.int64), counts)
        sizes = np.repeat(np.array(self._sizes, dtype=np.int64), counts)
        first_of_run = np.repeat(np.cumsum(counts) - counts, counts)
        number_in_run = np.arange(self.total) - first_of_run
        return starts + number_in_run * (RECORD_HEAD.size + sizes), sizes


def _run_length(records: bytes, start: int, step: int) -> int:
    """Number of records from `start` on with the same code and size."""
    most = (len(records) - start) // step
    heads = np.ndarray(
        (most, RECORD_HEAD.size),
        dtype=np.uint8,
        buffer=records,
        offset=start,
        strides=(step, 1),
    )
    count = 1
    compared = _MIN_RUN
    while count < len(heads):  # in growing steps, since a run may be short
        equal = (heads[count : count + compared] == heads[0]).all(axis=1)
        if not equal.all():
            return count + int(np.argmin(equal))
        count += len(equal)
        compared *= 4
    return count


class MessageTable:
    """The messages of a chunk: channel, log time [ns] and position of each.

    Attributes:
        channels: numbers of the channels (N,).
        log_ns: log times (N,) [ns]; negative beyond the year 2262.
    """

    def __init__(self, records: bytes, starts: Places, sizes: Places) -> None:
        """Read the headers of message records.

        Args:
            records: all records of the chunk.
            starts: offset of each message record (N,).
            sizes: size of the body of each (N,).
        """
        self._data = np.frombuffer(records, dtype=np.uint8)
        self._starts = starts
        self._sizes = sizes
        self.channels = _integers_at(self._data, starts + CHANNEL_OFFSET, "<u2")
        self.log_ns = _integers_at(self._data, starts + LOG_TIME_OFFSET, "<u8")

    def select(self, rows: NDArray[np.bool_]) -> None:
        """Keep some of the messages only."""
        self._starts = self._starts[rows]
        self._sizes = self._sizes[rows]
        self.channels = self.channels[rows]
        self.log_ns = self.log_ns[rows]

    def messages_of(self, channel: int) -> Messages:
        """The messages of one channel in the order of log times."""
        rows = np.flatnonzero(self.channels == channel)
        rows = rows[np.argsort(self.log_ns[rows], kind="stable")]
        offsets = self._starts[rows] + PREFIX
        lengths = self._sizes[rows] - MESSAGE_HEAD.size
        return Messages(self.log_ns[rows], self._data, offsets, lengths)


def _integers_at(data: NDArray[np.uint8], starts: Places, kind: str) -> NDArray[np.int64]:
    """Integers at some offsets of the data."""
    count = len(data) - np.dtype(kind).itemsize + 1
    at_every_byte = np.ndarray(count, dtype=kind, buffer=data, strides=1)
    integers = at_every_byte[starts]
    return integers.astype(np.int64)


def split_by_time(parts: list[Messages], border: int | None) -> tuple[Messages, Messages | None]:
    """Split messages at a time [ns]: those before it, and those from it on.

    Args:
        parts: messages of one topic.
        border: the time; None: all are before it.
    """
    parts = [part for part in parts if len(part)]
    if not parts:
        return Messages.of([], []), None
    merged = parts[0]
    if len(parts) > 1:
        merged = _concatenate(parts)
    order = np.argsort(merged.log_ns, kind="stable")
    if not (order[:-1] < order[1:]).all():
        merged = merged.part(order)
    if border is None or merged.log_ns[-1] < border:
        return merged, None
    split = int(np.searchsorted(merged.log_ns, border))
    rows = np.arange(len(merged))
    return merged.part(rows[:split]), merged.part(rows[split:])


def _concatenate(parts: list[Messages]) -> Messages:
    sizes = [len(part.data) for part in parts]
    shifts = np.cumsum([0, *sizes[:-1]])
    offsets = [part.offsets + shift for part, shift in zip(parts, shifts, strict=True)]
    return Messages(
        np.concatenate([part.log_ns for part in parts]),
        np.concatenate([part.data for part in parts]),
        np.concatenate(offsets),
        np.concatenate([part.lengths for part in parts]),
    )
