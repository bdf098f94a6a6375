"""Log lines and messages at a limited rate."""

from __future__ import annotations

import time
from bisect import bisect_left
from collections.abc import Hashable
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

_LARGEST: Final = 2**63 - 1  # of NumPy's integers


class Throttle:
    """Lets one line of each kind through in a period, and counts those it held back."""

    def __init__(self, period: float) -> None:
        """Least time between two lines of the same kind [s]; 0 lets all through."""
        self.period = period
        self._last: dict[Hashable, float] = {}
        self._held: dict[Hashable, int] = {}

    def admit(self, kind: Hashable, now: float) -> int | None:
        """Number of lines of this kind held back since the last one; None if this one is too.

        Args:
            kind: what the line is about; the number of kinds must be bounded.
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
    """Warnings of each kind at a limited rate, and what changed."""

    def __init__(self, logger: Logger, period: float) -> None:
        """Logger, and least time between two lines of the same kind [s]."""
        self._logger = logger
        self.throttle = Throttle(period)

    def warn(self, kind: Hashable, text: str) -> None:
        """Log a line, unless one of its kind was logged just now."""
        held = self.throttle.admit(kind, time.monotonic())
        if held is None:
            return
        if held:
            text = f"{text} (and {held} like this before)"
        self._logger.warning(text)

    def info(self, text: str) -> None:
        """Log a change. None is held back: the last line about a thing says how it is."""
        self._logger.info(text)


class RateLimit:
    """Picks messages so that no more than a rate come through, by their stamps."""

    def __init__(self) -> None:
        self._next = 0
        self._last = 0

    def due(self, stamp_ns: int, rate: float) -> bool:
        """Whether a message goes out.

        Args:
            stamp_ns: its stamp [ns].
            rate: [Hz]; 0: all go out, below: none.
        """
        if rate <= 0.0:
            return rate == 0.0
        period = _period(rate)
        early = self._last <= stamp_ns < self._next  # an earlier stamp starts anew
        self._last = stamp_ns
        if early:
            return False
        # On a grid of periods, so that jitter of the stamps does not lower the rate.
        on_grid = stamp_ns - self._next < period and stamp_ns >= self._next
        self._next = self._next + period if on_grid else stamp_ns + period
        return True

    def due_rows(self, stamps_ns: NDArray[np.int64], rate: float) -> NDArray[np.intp]:
        """Which of many messages, one after the other, go out: what `due` says of each.

        Args:
            stamps_ns: their stamps (N,) [ns].
            rate: [Hz]; 0: all go out, below: none.
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
        self._next += period * len(grid)  # no point of the grid was left out
        self._last = int(stamps_ns[-1])
        return rows

    def _one_by_one(self, stamps_ns: list[int], rate: float) -> NDArray[np.intp]:
        """`due_rows` of stamps that rise: all before the next one are early."""
        rows: list[int] = []
        row = bisect_left(stamps_ns, self._next)
        while row < len(stamps_ns):
            self.due(stamps_ns[row], rate)
            rows.append(row)
            row = bisect_left(stamps_ns, self._next, row + 1)
        self._last = stamps_ns[-1]
        return np.array(rows, dtype=np.intp)


def _period(rate: float) -> int:
    """Period [ns] of a rate above 0 [Hz], at most 146 years: sums with a stamp fit 64 bits."""
    return round(min(1e9 / rate, _LARGEST / 2))
