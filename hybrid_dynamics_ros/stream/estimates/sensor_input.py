"""Joint states from sensors over a stream. This module does not depend on ROS."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import HybridDynamicsError, InputError
from hybrid_dynamics_core.filtering import StateFilter, read_sensors
from hybrid_dynamics_core.ground.wording import one_line

from ...messages.joint_samples import JointSample, RejectedError, RejectionCode
from ...messages.sensor_topics import SensorReading, SensorTopics
from ...parameters import (
    ESTIMATION_DELAY,
    ESTIMATION_RATE,
    ESTIMATION_SENSORS,
    NodeSettings,
    ParameterError,
)

NS: Final = 10**9
DOUBTFUL: Final = 30  # readings in a row beyond their gate, after which a sensor is doubtful


class SensorInput:
    """Estimates of the measured joints from readings, as samples for the pipeline.

    Attributes:
        topics: topics of the sensors.
    """

    def __init__(
        self, robot: Robot, measured: Sequence[str], settings: NodeSettings, path: Path
    ) -> None:
        """Read the file of sensors.

        Raises:
            HybridDynamicsError: the file is wrong, or its sensors do not determine the state.
        """
        self._robot = robot
        self._carried = read_sensors(path, robot)
        self._delay = settings[ESTIMATION_DELAY]
        self._period_ns = round(NS / settings[ESTIMATION_RATE])
        self._names = tuple(measured)
        self._columns = [robot.coordinates.index(name) for name in measured]
        self.topics = SensorTopics(self._carried.sensors)
        self.clear()

    def clear(self) -> None:
        """Discard all readings; the next ones start the estimate anew."""
        sensors, motion = self._carried.sensors, self._carried.motion
        self._filter = StateFilter(self._robot, sensors, motion, latest=self._delay)
        self._first_ns: int | None = None
        self._newest_ns = 0
        self._given_ns = -(2**62)
        self._in_row: Counter[str] = Counter()

    def take(self, readings: Sequence[SensorReading]) -> JointSample | None:
        """Take the readings of a message; the joints, when they are due.

        Raises:
            RejectedError: the readings contradict each other at the start, or a stamp is negative.
        """
        for reading in readings:
            if self._first_ns is None:
                self._first_ns = self._newest_ns = reading.stamp_ns
            time = (reading.stamp_ns - self._first_ns) / NS
            had_started = self._filter.has_started
            try:
                shown = self._filter.add(time, reading.sensor, reading.values)
            except InputError as error:
                raise RejectedError(RejectionCode.REFUSED, one_line(error)) from error
            self._newest_ns = max(self._newest_ns, reading.stamp_ns)
            if had_started:
                shown = shown[:1]  # the others are repeated, since this one came late
            for innovation in shown:
                self._in_row[innovation.sensor] += 1
                if innovation.is_used:
                    self._in_row[innovation.sensor] = 0
        is_due = self._newest_ns >= self._given_ns + self._period_ns
        if not self._filter.has_started or not is_due:
            return None
        self._given_ns = self._newest_ns
        return self._sample()

    def _sample(self) -> JointSample:
        """The measured joints at the newest reading, with rates and accelerations."""
        estimate = self._filter.estimate
        accelerations = self._robot.accelerations(estimate.state, estimate.ddu)
        return JointSample(
            stamp_ns=self._newest_ns,
            names=self._names,
            position=np.array(estimate.state.s[self._columns]),
            velocity=np.array(estimate.state.ds[self._columns]),
            acceleration=accelerations[self._columns],
        )

    @property
    def doubtful(self) -> tuple[str, ...]:
        """Sensors whose newest readings all contradict the others."""
        return tuple(name for name, count in self._in_row.items() if count >= DOUBTFUL)

    def describe(self) -> dict[str, str]:
        """What became of the readings, and how well each joint is determined."""
        counts = self._filter.counts
        facts = {
            "sensors that contradict the others": ", ".join(self.doubtful) or "none",
            "readings used": str(counts.used.total()),
            "readings beyond the gate": _by_sensor(counts.beyond_gate),
            "readings too late": _by_sensor(counts.late),
            "readings before the first state": _by_sensor(counts.early),
            "readings repeated": _by_sensor(counts.duplicate),
            "starts of the filter": str(counts.starts),
        }
        if self._filter.has_started:
            deviations = self._filter.belief.deviations()[0]
            pairs = zip(self._robot.active, deviations.tolist(), strict=True)
            facts["deviations"] = ", ".join(f"{name} {value:.2g}" for name, value in pairs)
        return facts


def _by_sensor(counter: dict[str, int]) -> str:
    """Counts by name of the sensor."""
    parts = [f"{name} {count}" for name, count in counter.items() if count]
    return ", ".join(parts) or "0"


def sensor_input_of(
    robot: Robot, measured: Sequence[str], settings: NodeSettings
) -> SensorInput | None:
    """The input of sensors, if the parameters name a file of them; otherwise None.

    Raises:
        ParameterError: the file is wrong, or its sensors do not determine the state.
    """
    name = settings[ESTIMATION_SENSORS]
    if not name:
        return None
    try:
        return SensorInput(robot, measured, settings, Path(name))
    except HybridDynamicsError as error:
        raise ParameterError(f"parameter {ESTIMATION_SENSORS.name}: {one_line(error)}") from error
