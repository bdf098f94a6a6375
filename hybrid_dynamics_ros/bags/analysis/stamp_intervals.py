"""Regularity of the stamps of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from ...messages.joint_samples import FloatArray

_LONG: Final = 1.5  # [nominal intervals] above this, at least one sample is missing


class LongInterval(NamedTuple):
    """An interval with missing samples.

    Attributes:
        begin: its start [s].
        length: [s].
        missing: number of missing samples.
    """

    begin: float
    length: float
    missing: int


@dataclass(frozen=True, eq=False)
class StampIntervals:
    """Intervals between stamps, one after the other.

    Attributes:
        first: time of the first stamp [s].
        intervals: (k,) [s].
    """

    first: float
    intervals: FloatArray

    @cached_property
    def nominal(self) -> float:
        """The median of positive intervals [s]; 0 if there are none."""
        rising = self.intervals[self.intervals > 0.0]
        return float(np.median(rising)) if len(rising) else 0.0

    @property
    def longest(self) -> tuple[float, float]:
        """The longest interval, and its start [s]."""
        if not len(self.intervals):
            return 0.0, self.first
        row = int(np.argmax(self.intervals))
        return float(self.intervals[row]), float(self._begins[row])

    @cached_property
    def missing(self) -> list[LongInterval]:
        """Intervals with missing samples.

        Such an interval is longer than 1.5 nominal ones, after subtracting what its neighbours are
        short. Only a late stamp is followed by a short interval, and no sample is missing.
        """
        nominal = self.nominal
        if not nominal:
            return []
        shortage = np.minimum(self.intervals - nominal, 0.0)  # of each interval, 0 or less
        before = np.insert(shortage[:-1], 0, 0.0)
        after = np.append(shortage[1:], 0.0)
        compensated = self.intervals + np.minimum(after, before)
        rows = np.flatnonzero(compensated > _LONG * nominal).tolist()
        return [self._long_interval(row) for row in rows]

    @property
    def missing_count(self) -> int:
        """Number of missing samples."""
        return sum(interval.missing for interval in self.missing)

    def _long_interval(self, row: int) -> LongInterval:
        length = float(self.intervals[row])
        missing = max(round(length / self.nominal) - 1, 1)
        return LongInterval(float(self._begins[row]), length, missing)

    @cached_property
    def _begins(self) -> FloatArray:
        """Start of each interval (k,) [s]."""
        return self.first + np.cumsum(self.intervals) - self.intervals
