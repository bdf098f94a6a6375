"""Pressures of a recording, merged with its joint states by log time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..messages.interfaces import deserialize
from ..messages.joint_samples import RejectedError
from ..messages.pressures import (
    PRESSURES,
    MeasuredForces,
    PressureInput,
    SupplyCheck,
    sample_of_pressures,
)
from .batch_outputs import NODE
from .batch_pipeline import BatchResult
from .storage.bag_reader import BagReader
from .storage.storage import Losses

PRESSURE_INPUT = f"{NODE}/cylinder_pressures"
_COMPUTED = f"{NODE}/cylinder_states"


class RecordedPressures:
    """Measured pressures of the cylinders over the log time of a bag."""

    def __init__(self, pressures: PressureInput, source: BagReader, losses: Losses) -> None:
        """Read all pressures of a bag.

        Args:
            pressures: pressures of the pipeline.
            source: the bag.
            losses: receives texts on unusable messages.
        """
        self._pressures = pressures
        log_ns: list[int] = []
        newest: list[tuple[MeasuredForces, ...]] = []
        for log, _ in read_pressures(pressures, source, losses):
            log_ns.append(log)
            newest.append(pressures.newest)
        pressures.newest = ()
        order = np.argsort(np.array(log_ns, dtype=np.int64), kind="stable")
        self._log_ns = np.array(log_ns, dtype=np.int64)[order]
        self._newest: list[tuple[MeasuredForces, ...]] = [(), *(newest[k] for k in order)]

    def newest_at(self, log_ns: int) -> tuple[MeasuredForces, ...]:
        """The newest pressures at a log time [ns]."""
        return self._newest[int(np.searchsorted(self._log_ns, log_ns, side="right"))]

    def add_to(self, result: BatchResult) -> None:
        """Add the latest measured forces to results."""
        if not len(self._log_ns):
            return
        places = np.searchsorted(self._log_ns, result.log_ns, side="right").tolist()
        stamps = result.stamp_ns.tolist()
        forces = np.full((len(stamps), len(self._pressures.drives)), np.nan)
        for row, (stamp, place) in enumerate(zip(stamps, places, strict=True)):
            measured = self._pressures.at(stamp, self._newest[place])
            if measured is not None:
                forces[row] = measured
        start = 0
        for run in result.runs:
            end = start + len(run.position)
            run.measured_forces = forces[start:end]
            start = end


def read_pressures(
    pressures: PressureInput, source: BagReader, losses: Losses
) -> Iterator[tuple[int, bool]]:
    """Take all pressures of a bag, one message after the other.

    Args:
        pressures: receiver of the pressures.
        source: the bag.
        losses: receives texts on unusable messages, and on cylinders whose pressures stay above
            those of their supply.

    Yields:
        Log time of each message [ns], and whether it was taken.
    """
    topic = pressure_topic(source)
    supply = SupplyCheck(pressures.cylinders, fade=1.0)
    for _, messages in source.read(frozenset([topic])) if topic else ():
        for row, log in enumerate(messages.log_ns.tolist()):
            problem = _take(pressures, messages.message(row))
            if problem:
                losses.add(f"{topic}: message logged at {log} ns: {problem}")
            elif pressures.sample is not None:
                supply.take(pressures.sample)
            yield log, not problem
    if supply.problem:
        losses.add(supply.problem)


def _take(pressures: PressureInput, data: bytes) -> str:
    """Store a message; returns why it is unusable, or an empty text."""
    try:
        pressures.take(sample_of_pressures(deserialize(data, PRESSURES)))
    except RejectedError as error:
        return error.rejection.text
    except Exception as error:  # noqa: BLE001 - whatever rosbags meets in damaged bytes
        return str(error) or type(error).__name__
    return ""


def pressure_topic(source: BagReader) -> str:
    """The topic with pressures; "" if there is none, or if there are several."""
    if PRESSURE_INPUT in source.topics:
        return PRESSURE_INPUT
    names = [topic.name for topic in source.topics.values() if topic.kind == PRESSURES]
    measured = [name for name in names if name != _COMPUTED]
    return measured[0] if len(measured) == 1 else ""
