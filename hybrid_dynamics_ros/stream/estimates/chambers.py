"""Pressure sensors on the wrong side: measured forces fit better with exchanged chambers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.dynamics.pressure_check import exchanged_text, fits_exchanged

from ...messages.joint_samples import FloatArray

_SPACING: Final = 100_000_000  # [ns] between samples that count
_LEAST: Final = 20  # samples
_FADE: Final = 0.98  # of the sums at each sample, so that old motions fade


class ChamberCheck:
    """Compares measured forces of cylinders with those that the motion requires."""

    def __init__(self, robot: Robot) -> None:
        """Start without samples."""
        self._drives = tuple(robot.drives)
        self.clear()

    def clear(self) -> None:
        """Discard all samples."""
        shape = len(self._drives)
        self._newest = -_SPACING
        self._counts = np.zeros(shape, dtype=int)
        self._given, self._exchanged = np.zeros(shape), np.zeros(shape)

    def is_due(self, stamp_ns: int) -> bool:
        """Whether a sample counts: the last one is older than a tenth of a second, or newer."""
        return abs(stamp_ns - self._newest) >= _SPACING

    def take(
        self,
        stamp_ns: int,
        required: Mapping[str, Any],
        measured: FloatArray,
        exchanged: FloatArray,
    ) -> None:
        """Add a sample.

        Args:
            stamp_ns: its stamp [ns].
            required: force of each drive for the motion [N].
            measured: forces from pressures (d,) [N]; NaN where unknown.
            exchanged: the same with exchanged chambers (d,) [N].
        """
        self._newest = stamp_ns
        needed = np.array([np.max(required[name]) for name in self._drives])
        rises = measured - needed
        others = exchanged - needed
        is_there = np.isfinite(rises) & np.isfinite(others)
        self._counts += is_there
        self._given = _FADE * self._given + np.where(is_there, rises, 0.0) ** 2
        self._exchanged = _FADE * self._exchanged + np.where(is_there, others, 0.0) ** 2

    @property
    def problem(self) -> str:
        """A text on cylinders whose chambers seem to be exchanged; "" if there are none."""
        is_better = fits_exchanged(self._given, self._exchanged)
        places = np.flatnonzero(is_better & (self._counts >= _LEAST))
        names = [self._drives[place] for place in places.tolist()]
        return exchanged_text(names) if names else ""
