"""How regular the stamps of a recording are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ...messages.joint_samples import FloatArray

_LONG: Final = 1.5  # nominal intervals, beyond which at least one sample is missing


@dataclass(frozen=True, eq=False)
class Stamps:
    """Intervals between stamps (k,) [s], one after the other from the time `first` [s] on."""

    first: float
    intervals: FloatArray

    @cached_property
    def nominal(self) -> float:
        """The median interval [s]; 0 where there is none."""
        rising = self.intervals[self.intervals > 0.0]
        return float(np.median(rising)) if len(rising) else 0.0

    @property
    def longest(self) -> tuple[float, float]:
        """The longest interval and the time at which it begins [s]."""
        if not len(self.intervals):
            return 0.0, self.first
        row = int(np.argmax(self.intervals))
        return float(self.intervals[row]), float(self._begins[row])

    @cached_property
    def missing(self) -> list[tuple[float, float, int]]:
        """Intervals that miss samples: where they begin, how long they are [s], and how many samples are missing.

        An interval is long if it is beyond 1.5 nominal ones, whatever the one before or behind it
        makes up for: a stamp that is late is followed by a short interval, and no sample is
        missing.
        """
        nominal, steps = self.nominal, self.intervals
        if not nominal:
            return []
        spare = np.minimum(steps - nominal, 0.0)
        around = np.minimum(np.append(spare[1:], 0.0), np.insert(spare[:-1], 0, 0.0))
        left = steps + around
        rows = np.flatnonzero(left > _LONG * nominal)
        return [
            (float(self._begins[k]), float(steps[k]), max(round(steps[k] / nominal) - 1, 1))
            for k in rows
        ]

    @cached_property
    def _begins(self) -> FloatArray:
        """(k,) when each interval begins [s]."""
        return self.first + np.cumsum(self.intervals) - self.intervals
