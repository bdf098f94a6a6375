"""What is watched about the stream, and how bad it is. Knows no ROS."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from ..messages.joint_samples import Rejection
from ..parameters import (
    LATENCY,
    LATEST_AGE,
    LEAST_RATE,
    RESIDUAL,
    SINGULARITY_ERROR,
    SINGULARITY_WARN,
    STROKE_ERROR,
    STROKE_WARN,
    Settings,
)
from .pipeline import Counts
from .results import MotionResult
from .stroke_margins import Strokes

_KEPT = 4096  # latencies between two reports, the newest of them


class Level(IntEnum):
    """How bad it is; the numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Entry:
    """One line of a report: name, value as text, how bad it is."""

    name: str
    value: str
    level: Level = Level.OK


class Monitor:
    """Collects while messages flow; reports now and then."""

    def __init__(self, strokes: Strokes) -> None:
        self.skipped = 0  # inputs left out because they came faster than they could be answered
        self.lost = 0  # messages that the middleware threw away
        self.last_error = ""
        self._strokes = strokes
        self._latencies: deque[float] = deque(maxlen=_KEPT)
        self._received = self._rejected = 0  # at the last report
        self._reported = time.monotonic()

    def answered(self, latency: float) -> None:
        """An input was answered this long after the node took it up [s]."""
        self._latencies.append(latency)

    def rejected(self, rejection: Rejection) -> None:
        """An input was refused."""
        self.last_error = f"{rejection.code.value}: {rejection.text}"

    def report(
        self, result: MotionResult | None, counts: Counts, now_ns: int, settings: Settings
    ) -> list[Entry]:
        """How things are since the last report.

        Args:
            result: of the newest input, or None.
            counts: of all inputs.
            now_ns: the node's clock [ns].
            settings: levels.
        """
        entries = [*self._traffic(counts, settings), *self._timing(result, now_ns, settings)]
        if result is not None:
            entries += self._geometry(result, settings)
        return [*entries, Entry("last error", self.last_error or "none")]

    def beyond(self, result: MotionResult) -> dict[str, str]:
        """Each joint that is beyond its limit, in words."""
        told: dict[str, str] = {}
        if self._strokes.within(result.position):
            return told
        for end, left in zip(
            ("lower", "upper"), self._strokes.margins(result.position), strict=True
        ):
            for k in np.flatnonzero(left < 0.0).tolist():
                name, unit = self._strokes.joints[k], self._strokes.units[k]
                told[name] = (
                    f"{name} is beyond its {end} limit by {-left[k]:.4g} {unit}; it is answered"
                )
        return told

    def _traffic(self, counts: Counts, settings: Settings) -> list[Entry]:
        now = time.monotonic()
        received, rejected = (
            counts.received - self._received,
            counts.rejected.total() - self._rejected,
        )
        rate = received / max(now - self._reported, 1e-3)
        self._received, self._rejected, self._reported = (
            counts.received,
            counts.rejected.total(),
            now,
        )
        return [
            Entry(
                "rate [Hz]", f"{rate:.1f}", Level.WARN if rate < settings[LEAST_RATE] else Level.OK
            ),
            Entry("received", str(counts.received), Level.OK if received else Level.STALE),
            Entry(
                "rejected since last report", str(rejected), Level.WARN if rejected else Level.OK
            ),
            Entry("counts", counts.summary()),
            Entry("lost in the queue", str(self.lost)),
            Entry("left out under overload", str(self.skipped)),
        ]

    def _timing(self, result: MotionResult | None, now_ns: int, settings: Settings) -> list[Entry]:
        entries = []
        if result is not None:
            age = (now_ns - result.stamp_ns) * 1e-9
            old = abs(age) > settings[LATEST_AGE]  # from the future as well: then clocks differ
            entries.append(
                Entry("age of the stamp [s]", f"{age:.6f}", Level.WARN if old else Level.OK)
            )
        if self._latencies:
            middle, late = np.percentile(self._latencies, (50.0, 99.0)).tolist()
            slow = late > settings[LATENCY]
            entries.append(Entry("latency, median [s]", f"{middle:.6f}"))
            entries.append(
                Entry("latency, 99 % [s]", f"{late:.6f}", Level.WARN if slow else Level.OK)
            )
            self._latencies.clear()
        return entries

    def _geometry(self, result: MotionResult, settings: Settings) -> list[Entry]:
        bad = result.residual > settings[RESIDUAL]
        entries = [Entry("residual", f"{result.residual:.3g}", Level.ERROR if bad else Level.OK)]
        near, loop = result.nearest
        level = _below(near, settings[SINGULARITY_WARN], settings[SINGULARITY_ERROR])
        entries.append(Entry("singularity margin", f"{near:.4g} {loop}".strip(), level))
        if self._strokes.joints:
            margins = np.minimum(*self._strokes.margins(result.position))
            k = int(np.argmin(margins))
            level = _below(float(margins[k]), settings[STROKE_WARN], settings[STROKE_ERROR])
            entries.append(
                Entry("stroke margin", f"{margins[k]:.4g} {self._strokes.joints[k]}", level)
            )
        return entries


def _below(value: float, warn: float, error: float) -> Level:
    return Level.ERROR if value < error else Level.WARN if value < warn else Level.OK
