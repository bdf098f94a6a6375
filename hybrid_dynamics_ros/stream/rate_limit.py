"""Rate limits of log lines and messages."""

from __future__ import annotations

import time
from bisect import bisect_left
from collections.abc import Hashable
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

_LARGEST: Final = 2**63 - 1  # largest int64


class Throttle:
    """Admits one line of each kind per period, and counts suppressed ones."""

    def __init__(self, period: float) -> None:
        """Set the least time between two lines of the same kind [s]; 0 admits all."""
        self.period = period
        self._last: dict[Hashable, float] = {}
        self._held: dict[Hashable, int] = {}

    def admit(self, kind: Hashable, now: float) -> int | None:
        """Number of suppressed lines of a kind since the last one; None if this line is suppressed.

        Args:
            kind: kind of the line; the number of kinds must be bounded.
            now: monotonic time [s].
        """
        last = self._last.get(kind)
        if last is not None and now - last < self.period:
            self._held[kind] = self._held.get(kind, 0) + 1
            return None
        self._last[kind] = now
        return self._held.pop(kind, 0)


class Logger(Protocol):
    """A logger."""

    def info(self, message: str) -> object:
        """Log a line."""

    def warning(self, message: str) -> object:
        """Log a line."""


class ThrottledLog:
    """A log with a limited rate of warnings of each kind, and unlimited infos."""

    def __init__(self, logger: Logger, period: float) -> None:
        """Set the logger, and the least time between two lines of the same kind [s]."""
        self._logger = logger
        self.throttle = Throttle(period)

    def warn(self, kind: Hashable, text: str) -> None:
        """Log a warning, unless one of its kind was logged within the period."""
        held = self.throttle.admit(kind, time.monotonic())
        if held is None:
            return
        if held:
            text = f"{text} (and {held} like this before)"
        self._logger.warning(text)

    def info(self, text: str) -> None:
        """Log a change; it is never suppressed, so that the last line shows the present state."""
        self._logger.info(text)


class RateLimit:
    """Selects messages by their stamps, up to a rate."""

    def __init__(self) -> None:
        self._next = 0
        self._last = 0

    def due(self, stamp_ns: int, rate: float) -> bool:
        """Whether a message is sent.

        Args:
            stamp_ns: its stamp [ns].
            rate: largest rate [Hz]; 0: all are sent, negative: none.
        """
        if rate <= 0.0:
            return rate == 0.0
        period = _period(rate)
        early = self._last <= stamp_ns < self._next  # an earlier stamp restarts
        self._last = stamp_ns
        if early:
            return False
        # On a grid of periods, so that jitter of the stamps does not lower the rate.
        on_grid = stamp_ns - self._next < period and stamp_ns >= self._next
        self._next = self._next + period if on_grid else stamp_ns + period
        return True

    def due_rows(self, stamps_ns: NDArray[np.int64], rate: float) -> NDArray[np.intp]:
        """Indices of consecutive messages that are sent, as by `due`.

        Args:
            stamps_ns: their stamps (N,) [ns].
            rate: largest rate [Hz]; 0: all are sent, negative: none.
        """
        if rate <= 0.0:
            return np.arange(len(stamps_ns) if rate == 0.0 else 0)
        if not len(stamps_ns) or stamps_ns[0] < self._last or (np.diff(stamps_ns) < 0).any():
            return np.flatnonzero([self.due(stamp, rate) for stamp in stamps_ns.tolist()])
        period = _period(rate)
        periods = (int(stamps_ns[-1]) - self._next) // period + 1
        count = min(periods, len(stamps_ns))
        if self._next + period * max(count, 1) > _LARGEST:
            return self._one_by_one(stamps_ns.tolist(), rate)
        grid = self._next + period * np.arange(count)
        rows = np.searchsorted(stamps_ns, grid)
        if not (stamps_ns[rows] - grid < period).all():
            return self._one_by_one(stamps_ns.tolist(), rate)
        self._next += period * len(grid)  # every point of the grid was used
        self._last = int(stamps_ns[-1])
        return rows

    def _one_by_one(self, stamps_ns: list[int], rate: float) -> NDArray[np.intp]:
        """`due_rows` for ascending stamps."""
        rows: list[int] = []
        row = bisect_left(stamps_ns, self._next)
        while row < len(stamps_ns):
            self.due(stamps_ns[row], rate)
            rows.append(row)
            row = bisect_left(stamps_ns, self._next, row + 1)
        self._last = stamps_ns[-1]
        return np.array(rows, dtype=np.intp)


def _period(rate: float) -> int:
    """Period [ns] of a positive rate [Hz], limited so that sums with a stamp fit 64 bits."""
    return round(min(1e9 / rate, _LARGEST / 2))
