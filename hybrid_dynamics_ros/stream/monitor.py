"""Monitoring of the stream for diagnostics. It does not depend on ROS."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np

from ..messages.joint_samples import Rejection
from ..messages.pressures import SupplyCheck
from ..parameters import (
    INPUT_QOS,
    LATENCY,
    LATEST,
    LATEST_AGE,
    LEAST_RATE,
    RESIDUAL,
    SENSOR_DATA,
    SINGULARITY_ERROR,
    SINGULARITY_WARN,
    STROKE_ERROR,
    STROKE_WARN,
    NodeSettings,
)
from .estimates.chambers import ChamberCheck
from .estimates.sensor_input import SensorInput
from .estimates.tool_force import ToolForceInput
from .limit_margins import drives_beyond, margins_of_result
from .pipeline import Counts
from .results import MotionResult
from .stroke_margins import StrokeMargins

_MOST_LATENCIES: Final = 4096  # newest latencies kept between reports
_ENDS: Final = ("lower", "upper")


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class StatusEntry:
    """One line of a report: name, value as text, level."""

    name: str
    value: str
    level: Level = Level.OK


@dataclass
class Tally:
    """Numbers of received and of refused messages of a topic."""

    received: int = 0
    rejected: int = 0


class Monitor:
    """Collects statistics of the stream for periodic reports."""

    def __init__(self, strokes: StrokeMargins) -> None:
        self.skipped = 0  # inputs skipped under overload
        self.lost = 0  # lost messages, by sequence numbers
        self.inactive = 0  # inputs skipped while the node was inactive
        self.pressures = Tally()
        self.sensors: SensorInput | None = None
        self.tool: ToolForceInput | None = None
        self.chambers: ChamberCheck | None = None
        self.supply: SupplyCheck | None = None
        # Incompatible publishers and subscriptions of the node's topics, with reasons.
        self.unconnected = ""
        self.last_error = ""
        self._reported_lost = 0
        self._reported_skipped = 0
        self._reported_pressures = 0
        self._reported_tool = 0
        self._strokes = strokes
        self._latencies: deque[float] = deque(maxlen=_MOST_LATENCIES)
        self._received = 0  # value at the last report
        self._rejected = 0
        self._reported = time.monotonic()

    def answered(self, latency: float) -> None:
        """Register the latency of a processed input [s]."""
        self._latencies.append(latency)

    def rejected(self, rejection: Rejection) -> None:
        """Register a refused input."""
        self.last_error = f"{rejection.code.value}: {rejection.text}"

    def unprocessed(self) -> str:
        """Messages that were not processed, as text, by what became of them; "" if none."""
        counts = {
            "left out under overload": self.skipped,
            "left out while not active": self.inactive,
            "lost on the way": self.lost,
        }
        return "".join(f", {count} {what}" for what, count in counts.items() if count)

    def report(
        self, result: MotionResult | None, counts: Counts, now_ns: int, settings: NodeSettings
    ) -> list[StatusEntry]:
        """Report on the stream since the last report.

        Rate, rejections and latencies are since the last report, counts since the start.

        Args:
            result: result of the newest input, or None.
            counts: counts of all inputs.
            now_ns: the node's clock [ns].
            settings: settings with thresholds.
        """
        entries = [*self._traffic(counts, settings), *self._timing(result, now_ns, settings)]
        entries += [*self._tool_entries(), *self._chamber_entries(), *self._sensor_entries()]
        return [*entries, StatusEntry("last error", self.last_error or "none")]

    def beyond(self, result: MotionResult) -> dict[str, str]:
        """A text for each joint beyond its limit."""
        texts: dict[str, str] = {}
        strokes = self._strokes
        if strokes.within(result.position):
            return texts
        for end, margins in zip(_ENDS, strokes.margins(result.position), strict=True):
            for k in np.flatnonzero(margins < 0.0).tolist():
                name, excess = strokes.joints[k], f"{-margins[k]:.4g} {strokes.units[k]}"
                texts[name] = f"{name} is beyond its {end} limit by {excess}; it is answered"
        return texts

    def _traffic(self, counts: Counts, settings: NodeSettings) -> list[StatusEntry]:
        now = time.monotonic()
        all_rejected = counts.rejected.total()
        # since the last report
        received = counts.received - self._received
        rejected = all_rejected - self._rejected
        lost = self.lost - self._reported_lost
        skipped = self.skipped - self._reported_skipped
        rate = received / max(now - self._reported, 1e-3)
        self._reported = now
        self._received = counts.received
        self._rejected = all_rejected
        self._reported_lost = self.lost
        self._reported_skipped = self.skipped
        lossy = settings[INPUT_QOS] in (LATEST, SENSOR_DATA)  # these profiles may lose messages
        return [
            StatusEntry("rate [Hz]", f"{rate:.1f}", _warn_if(rate < settings[LEAST_RATE])),
            StatusEntry("received", str(counts.received), Level.OK if received else Level.STALE),
            StatusEntry("rejected since last report", str(rejected), _warn_if(rejected > 0)),
            StatusEntry("counts", counts.summary()),
            StatusEntry("lost on the way", str(self.lost), _warn_if(lost > 0 and not lossy)),
            StatusEntry("left out under overload", str(self.skipped), _warn_if(skipped > 0)),
            StatusEntry("left out while not active", str(self.inactive)),
            self._pressure_entry(),
            StatusEntry("not connected", self.unconnected or "none", _warn_if(self.unconnected)),
        ]

    def _tool_entries(self) -> list[StatusEntry]:
        """Samples without a force at the tool since the start; a warning if there are new ones."""
        if self.tool is None or not self.tool.lost:
            return []
        recent = self.tool.lost - self._reported_tool
        self._reported_tool = self.tool.lost
        text = f"{self.tool.lost} samples give none; the newest: {self.tool.problem}"
        return [StatusEntry("force at the tool", text, _warn_if(recent > 0))]

    def _chamber_entries(self) -> list[StatusEntry]:
        """Warnings on cylinders: exchanged chambers, pressures above those of the supply."""
        entries: list[StatusEntry] = []
        for name, check in (("chambers", self.chambers), ("supply", self.supply)):
            if check is not None and check.problem:
                entries.append(StatusEntry(name, check.problem, Level.WARN))
        return entries

    def _sensor_entries(self) -> list[StatusEntry]:
        """What became of readings of sensors; a warning if one contradicts the others."""
        if self.sensors is None:
            return []
        level = _warn_if(self.sensors.doubtful)
        facts = self.sensors.describe()
        return [StatusEntry(name, text, level) for name, text in facts.items()]

    def _pressure_entry(self) -> StatusEntry:
        """Number of pressure messages since the start; a warning if some were refused since."""
        tally = self.pressures
        recent = tally.rejected - self._reported_pressures
        self._reported_pressures = tally.rejected
        text = f"{tally.received} received, {tally.rejected} rejected"
        return StatusEntry("pressures", text, _warn_if(recent > 0))

    def _timing(
        self, result: MotionResult | None, now_ns: int, settings: NodeSettings
    ) -> list[StatusEntry]:
        entries = []
        if result is not None:
            age = (now_ns - result.stamp_ns) * 1e-9
            old = abs(age) > settings[LATEST_AGE]  # also from the future
            entries.append(StatusEntry("age of the stamp [s]", f"{age:.6f}", _warn_if(old)))
        if self._latencies:
            middle, late = np.percentile(self._latencies, (50.0, 99.0)).tolist()
            slow = late > settings[LATENCY]
            entries.append(StatusEntry("latency, median [s]", f"{middle:.6f}"))
            entries.append(StatusEntry("latency, 99 % [s]", f"{late:.6f}", _warn_if(slow)))
            self._latencies.clear()
        return entries

    def robot_report(self, result: MotionResult, settings: NodeSettings) -> list[StatusEntry]:
        """Report on the robot at an input: residual, singularities, and margins to limits."""
        is_open = result.residual > settings[RESIDUAL]
        residual_level = Level.ERROR if is_open else Level.OK
        entries = [StatusEntry("residual", f"{result.residual:.3g}", residual_level)]
        near, loop = result.nearest
        level = _below(near, settings[SINGULARITY_WARN], settings[SINGULARITY_ERROR])
        entries.append(StatusEntry("singularity margin", f"{near:.4g} {loop}".strip(), level))
        if self._strokes.joints:
            margins = np.minimum(*self._strokes.margins(result.position))
            least = int(np.argmin(margins))
            margin, joint = float(margins[least]), self._strokes.joints[least]
            level = _below(margin, settings[STROKE_WARN], settings[STROKE_ERROR])
            entries.append(StatusEntry("stroke margin", f"{margin:.4g} {joint}", level))
        return [*entries, *_drive_entries(result)]


def _drive_entries(result: MotionResult) -> list[StatusEntry]:
    """What is beyond limits of rates, drives, cylinders and pumps, or the nearest one."""
    margins = margins_of_result(result)
    if margins is None or margins.nearest is None:
        return []
    beyond = [margin.text for margin in drives_beyond(margins)]
    text = "; ".join(beyond) or margins.nearest.text
    return [StatusEntry("limits", text, _warn_if(beyond))]


def _warn_if(condition: object) -> Level:
    return Level.WARN if condition else Level.OK


def _below(value: float, warn: float, error: float) -> Level:
    if value < error:
        return Level.ERROR
    return _warn_if(value < warn)
