"""Log lines at a limited rate, for each kind of line on its own."""

from __future__ import annotations

from collections.abc import Hashable


class Throttle:
    """Lets one line of each kind through in a period, and counts those it held back."""

    def __init__(self, period: float) -> None:
        """Least time between two lines of the same kind [s]; 0 lets all through."""
        self._period = period
        self._last: dict[Hashable, float] = {}
        self._held: dict[Hashable, int] = {}

    def admit(self, kind: Hashable, now: float) -> int | None:
        """Number of lines of this kind held back since the last one, or None if this one is held back.

        Args:
            kind: what the line is about; the number of kinds must be bounded.
            now: monotonic time [s].
        """
        last = self._last.get(kind)
        if last is not None and now - last < self._period:
            self._held[kind] = self._held.get(kind, 0) + 1
            return None
        self._last[kind] = now
        return self._held.pop(kind, 0)
